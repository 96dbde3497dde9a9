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

// Deforms the objects with `deformed_by = "program"` as programs request. A shape comes in parts; once it is whole, a task of its own makes
// it ready; then its vertices are sent on, and then it is announced from which scene time on the surface moves there: after the last reply,
// so that nothing that was felt changes, and not before the surface has arrived at the shape before. No vertex is faster than
// kMaxSurfaceSpeed. Source: decision 201.
//
// A flood costs little: a part is copied, and a shape takes its place only after the one before. RT: all but the construction. Threads:
// one.
class ObjectShaper {
 public:
  // The present motion ends no later than this when the next one is sent on.
  static constexpr std::int64_t kAheadNs = 20'000'000;
  // A program that is silent for so long may be replaced by another one.
  static constexpr std::int64_t kSilentNs = 1'000'000'000;
  // The time that the hub gets to make a shape ready: twice what it took lately, within these. The first is 15 us a vertex of large meshes
  // (decision 191), and as much to spare; the other the same at an eighth of the speed.
  static constexpr std::int64_t kMinStageNsPerVertex = 30'000;
  static constexpr std::int64_t kMaxStageNsPerVertex = 240'000;
  // Between two replies that reject parts.
  static constexpr std::int64_t kRejectEveryNs = 100'000'000;

  // source: as in ObjectShape. Pre: the method of the step was made for the scene, and lives as long as this.
  ObjectShaper(const Scene& scene, const TouchStep& touch, std::uint32_t source);
  ~ObjectShaper();
  ObjectShaper(const ObjectShaper&) = delete;
  ObjectShaper& operator=(const ObjectShaper&) = delete;

  bool has_objects() const noexcept { return !objects_.empty(); }
  // The task, in a thread of its own from now on; without it, work() of each maker has to be called.
  void start();
  bool work();

  void accept(const ShapeRequest& part, std::int64_t now_ns) noexcept;
  // The newest shape of an object is sent again, or some parts of one that was announced a moment ago. Of another process or shape: left
  // out.
  void accept(const ShapeStatus& status, std::int64_t now_ns) noexcept;

  // While the hub computes the force: motions begin so much later than the last reply that it knows of them before (PatchSender::
  // find_lead_ns), and as many as can be under way wait for their start. part_ns: between two parts of shapes. 0: it does not.
  struct Pace {
    std::int64_t lead_ns = 0;
    std::int64_t part_ns = 0;
    std::int64_t again_ns = 0;             // that a lost part takes to be sent again: motions begin so much later while parts get lost
    std::int64_t stage_ns_per_vertex = 0;  // that the hub took lately to make a shape ready; 0: not known
  };
  void set_pace(const Pace& pace) noexcept { pace_ = pace; }
  // The next message to the hub, if one is due. A ShapeStart has begun in the step, or waits there, before this returns it.
  std::optional<Message> take_due(HapticsStep& step, std::int64_t now_ns = 0) noexcept;

  // For whoever missed it: where each object is, in their order. serial 0: at rest.
  std::size_t count() const noexcept { return objects_.size(); }
  const ShapeStart& newest(std::size_t n) const noexcept { return objects_[n]->start; }
  // That started last; null: none.
  const ShapeStart* newest() const noexcept { return newest_; }

  struct Counts {
    std::uint64_t shapes = 0;      // taken
    std::uint64_t incomplete = 0;  // not whole before the next one was, or before the one after that began
    std::uint64_t rejected = 0;    // parts that were rejected, and shapes that the surface cannot take
  };
  const Counts& counts() const noexcept { return counts_; }
  std::string_view name_of(std::int32_t object) const noexcept;

 private:
  static constexpr std::size_t kMaxAnnounced = StreamedMethod::kMaxWaiting + 1;
  static constexpr std::size_t kMaxAgain = 32;  // parts that are to be sent again ahead

  struct Object {
    Object(std::int32_t number, const SceneObject& object, StreamedMethod& streamed, std::uint32_t source);

    std::string name;
    bool is_alone = false;  // with that name
    StreamedMethod* method;
    ShapeMaker maker;
    ShapeParts parts;
    ShapeParts parts_before;         // of the shape before, if it was not whole when the newer one began
    std::uint32_t shape_before = 0;  // its number
    std::uint32_t stream = 0;        // of the program that deforms it; 0: none yet
    std::uint32_t shape = 0;         // whose parts come
    bool is_given = false;           // ... are all there, and with the maker
    std::int64_t part_ns = 0;        // the last one came
    ShapeStart start;                // newest
    // The newest, the last one of `start`: what parts are sent again of.
    struct Announced {
      std::uint32_t serial = 0;  // 0: none
      std::unique_ptr<MadeShape> made = nullptr;
    };
    std::array<Announced, kMaxAnnounced> announced = {};
    std::size_t announced_count = 0;  // so far
    const Announced& present() const noexcept { return announced[(announced_count + kMaxAnnounced - 1) % kMaxAnnounced]; }
    std::unique_ptr<MadeShape> next;  // being sent
    std::uint32_t sent_to = 0;        // of next: vertices before this one have been sent
    std::uint32_t again_from = 0;     // of present(): vertices from here on are sent again
    ShapeReply reply;                 // last
  };

  Object* find(const ShapeRequest& part) noexcept;
  void begin_shape(Object& object, std::uint32_t shape) noexcept;
  void add_overtaken(Object& object, const ShapeRequest& part) noexcept;
  void leave_out_before(Object& object) noexcept;
  void give(Object& object, const ShapeRequest& part, const ShapeParts& parts) noexcept;
  std::string_view explain(const ShapeRequest& part) const noexcept;
  void reject(const ShapeRequest& part, std::int32_t object, std::string_view why, std::int64_t now_ns) noexcept;
  void push_reply(const ShapeReply& reply) noexcept;
  void take_rejection(Object& object) noexcept;
  bool begin_sending(Object& object, std::int64_t scene_time_ns) noexcept;
  Message begin_motion(Object& object, HapticsStep& step) noexcept;
  std::int64_t find_stage_ns(const Object& object) const noexcept;
  std::int64_t find_lead_ns(const Object& object) const noexcept;
  double find_least_s(const Object& object) const noexcept;
  bool has_room(const Object& object) const noexcept;
  Message make_part(const Object& object, std::uint32_t serial, const WantedShape& shape, std::uint32_t first,
                    std::int64_t now_ns) noexcept;
  std::optional<Message> take_again(std::int64_t now_ns) noexcept;
  void run();

  static constexpr std::size_t kMaxReplies = 16;  // that wait to be sent; a program repeats what gets none

  std::vector<std::unique_ptr<Object>> objects_;
  std::vector<std::string> names_;                    // of all objects of the scene
  std::array<ShapeReply, kMaxReplies> replies_ = {};  // to be sent, a ring
  std::size_t first_reply_ = 0;
  std::size_t reply_count_ = 0;
  Object* sending_ = nullptr;    // whose shape is being sent
  std::size_t next_object_ = 0;  // the object that is served first
  std::uint32_t serial_ = 0;
  // Vertices of an announced shape.
  struct Again {
    const Object* object = nullptr;
    std::uint32_t serial = 0;
    std::uint32_t first = 0;
    std::uint32_t end = 0;
  };
  std::array<Again, kMaxAgain> again_ = {};
  std::size_t again_begin_ = 0;
  std::size_t again_end_ = 0;
  std::int64_t lossy_until_ns_ = 0;
  bool is_lossy_ = false;
  Pace pace_;
  std::int64_t next_part_ns_ = 0;
  std::int64_t next_rejection_ns_ = 0;
  const ShapeStart* newest_ = nullptr;
  Counts counts_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace hapton
