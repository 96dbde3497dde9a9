#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "haptic_step/haptics_step.h"
#include "haptics_node/shape_maker.h"
#include "link/messages.h"
#include "link/shape_parts.h"
#include "scene/scene_file.h"

namespace hapton {

// Deforms the objects with `deformed_by = "program"` as programs request. A shape arrives in parts. Once it is complete, a slow task makes
// it ready. Then its vertices are sent to the hub, and then the scene time is announced at which the surface begins to move to it: later
// than the last reply, so that no force already sent becomes wrong, and not before the surface has reached the shape before. No vertex is
// faster than kMaxSurfaceSpeed. Source: decision 201.
//
// A flood of requests costs little: each part is only copied, and each shape waits for the one before. RT: accept, set_pace, take_due and
// the getters yes; work no; the rest set-up only. Threads: one, except work.
class ObjectShaper {
 public:
  // The vertices of the next shape are sent once the present motion ends within this time.
  static constexpr std::int64_t kSendAheadNs = 20'000'000;
  // Once a program has sent no shape for this time, another program may deform the object.
  static constexpr std::int64_t kSilentNs = 1'000'000'000;
  // The hub is given twice the time that it took lately to make a shape ready, but at least and at most these times for each vertex. The
  // smaller one is twice the 15 us per vertex measured on large meshes (decision 191); the larger one is for a hub an eighth as fast.
  static constexpr std::int64_t kMinStageNsPerVertex = 30'000;
  static constexpr std::int64_t kMaxStageNsPerVertex = 240'000;
  // Shortest time between two replies that reject parts.
  static constexpr std::int64_t kRejectEveryNs = 100'000'000;

  // source: ObjectShape::source of this process. Pre: the method of the step was made for the scene, and outlives this.
  ObjectShaper(const Scene& scene, const TouchStep& touch, std::uint32_t source);
  ~ObjectShaper();
  ObjectShaper(const ObjectShaper&) = delete;
  ObjectShaper& operator=(const ObjectShaper&) = delete;

  bool has_objects() const noexcept { return !objects_.empty(); }
  // Starts the slow task in its own thread, which calls work(). Without this, the caller must call work().
  void start();
  bool work();  // makes the newest shape of each object ready; false: there was none

  void accept(const ShapeRequest& part, std::int64_t now_ns) noexcept;
  // Sends vertices of a shape again: with count 0 all from `first` on, of the object's newest shape; otherwise `count` of them, also of one
  // that was announced shortly before. A status about another process or shape is ignored.
  void accept(const ShapeStatus& status, std::int64_t now_ns) noexcept;

  // Delays while the hub computes the force. lead_ns (PatchSender::find_lead_ns): how much later than the last reply motions begin, so that
  // the hub knows of them before; then several motions can wait for their start. 0: the hub does not compute the force.
  struct Pace {
    std::int64_t lead_ns = 0;
    std::int64_t part_ns = 0;              // between two parts of shapes
    std::int64_t resend_ns = 0;            // time to send a lost part again: motions begin this much later while parts get lost
    std::int64_t stage_ns_per_vertex = 0;  // time that the hub took lately to make a shape ready; 0: not known
  };
  void set_pace(const Pace& pace) noexcept { pace_ = pace; }
  // The next message to the hub, if one is due. When this returns a ShapeStart, its motion has begun or waits in `step` already.
  std::optional<Message> take_due(HapticsStep& step, std::int64_t now_ns = 0) noexcept;

  // Number of objects, and the newest start of each, to be sent again to those who missed it. ShapeStart::serial 0: the object is at rest.
  std::size_t count() const noexcept { return objects_.size(); }
  const ShapeStart& newest(std::size_t n) const noexcept { return objects_[n]->start; }
  // The start announced last, of any object; null: none.
  const ShapeStart* newest() const noexcept { return newest_start_; }

  struct Counts {
    std::uint64_t shapes = 0;      // announced
    std::uint64_t incomplete = 0;  // not complete before the next one was, or before the one after that began
    std::uint64_t rejected = 0;    // parts that were rejected, and shapes that the surface cannot take
  };
  const Counts& counts() const noexcept { return counts_; }
  std::string_view name_of(std::int32_t object) const noexcept;

 private:
  static constexpr std::size_t kMaxAnnounced = StreamedMethod::kMaxWaiting + 1;
  static constexpr std::size_t kMaxResends = 32;  // requests to send vertices again that are kept

  struct Object {
    Object(std::int32_t number, const SceneObject& object, StreamedMethod& streamed, std::uint32_t source);

    std::string name;
    bool has_unique_name = false;  // no other object of the scene has that name
    StreamedMethod* method;
    ShapeMaker maker;
    ShapeParts parts;
    ShapeParts previous_parts;         // of the shape before, if it was not complete when the newer one began
    std::uint32_t previous_shape = 0;  // number of that shape
    std::uint32_t stream = 0;          // of the program that deforms it; 0: none yet
    std::uint32_t shape = 0;           // the shape whose parts arrive
    bool is_passed_on = false;         // all parts of `shape` have arrived, and the maker has it
    std::int64_t last_part_ns = 0;     // when the last part arrived
    ShapeStart start;                  // of the newest shape
    // The shapes announced last, of which parts can be sent again; the last one is that of `start`.
    struct Announced {
      std::uint32_t serial = 0;  // 0: none
      std::unique_ptr<MadeShape> made = nullptr;
    };
    std::array<Announced, kMaxAnnounced> announced = {};
    std::size_t announced_count = 0;  // since the start
    const Announced& present() const noexcept { return announced[(announced_count + kMaxAnnounced - 1) % kMaxAnnounced]; }
    std::unique_ptr<MadeShape> next;  // the shape that is being sent
    std::uint32_t sent_until = 0;     // of next: vertices before this one have been sent
    std::uint32_t resend_from = 0;    // of present(): vertices from here on are sent again
    ShapeReply reply;                 // to the last shape
  };

  Object* find(const ShapeRequest& part) noexcept;
  void begin_shape(Object& object, std::uint32_t shape) noexcept;
  void add_overtaken(Object& object, const ShapeRequest& part) noexcept;
  void drop_previous_shape(Object& object) noexcept;
  void pass_on(Object& object, const ShapeRequest& part, const ShapeParts& parts) noexcept;
  std::string_view explain(const ShapeRequest& part) const noexcept;
  void reject(const ShapeRequest& part, std::int32_t object, std::string_view why, std::int64_t now_ns) noexcept;
  void push_reply(const ShapeReply& reply) noexcept;
  void take_rejection(Object& object) noexcept;
  bool begin_sending(Object& object, std::int64_t scene_time_ns) noexcept;
  Message begin_motion(Object& object, HapticsStep& step) noexcept;
  std::int64_t find_stage_ns(const Object& object) const noexcept;
  std::int64_t find_lead_ns(const Object& object) const noexcept;
  double find_min_duration_s(const Object& object) const noexcept;
  bool has_room(const Object& object) const noexcept;
  Message make_part(const Object& object, std::uint32_t serial, const WantedShape& shape, std::uint32_t first,
                    std::int64_t now_ns) noexcept;
  std::optional<Message> take_resend(std::int64_t now_ns) noexcept;
  void run();

  static constexpr std::size_t kMaxReplies = 16;  // replies that wait to be sent; a program repeats a shape that gets no reply

  std::vector<std::unique_ptr<Object>> objects_;
  std::vector<std::string> names_;                    // of all objects of the scene
  std::array<ShapeReply, kMaxReplies> replies_ = {};  // replies to be sent: a ring buffer
  std::size_t first_reply_ = 0;
  std::size_t reply_count_ = 0;
  Object* sending_ = nullptr;    // the object whose shape is being sent; null: none
  std::size_t next_object_ = 0;  // the object that is served first
  std::uint32_t serial_ = 0;
  // Vertices of an announced shape that are to be sent again.
  struct Resend {
    const Object* object = nullptr;
    std::uint32_t serial = 0;
    std::uint32_t first = 0;
    std::uint32_t end = 0;
  };
  std::array<Resend, kMaxResends> resends_ = {};
  std::size_t resends_begin_ = 0;
  std::size_t resends_end_ = 0;
  std::int64_t lossy_until_ns_ = 0;
  bool is_lossy_ = false;
  Pace pace_;
  std::int64_t next_part_ns_ = 0;
  std::int64_t next_rejection_ns_ = 0;
  const ShapeStart* newest_start_ = nullptr;
  Counts counts_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace hapton
