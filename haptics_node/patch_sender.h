#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/mailbox.h"
#include "core/force/touch_scene.h"
#include "core/math/commanded_motion.h"
#include "link/messages.h"
#include "patch/move_table.h"
#include "patch/patch_source.h"

namespace hapton {

// Offers the scene to the hub in parts, when it asks for them: a thread of its own parts the scene, once, and decides what goes next; the
// reply loop sends it. Nothing is done before the hub asks.
//
// An object that the stylus picks up leaves its place. Before it does, the parts are withdrawn: the hub gets an epoch without any, and
// is_withdrawn() says when it has confirmed that, so that nobody feels the object where it no longer is. Each epoch replies to one request
// of the hub, which takes no other: what is late on the network is of no use after the hub has dropped its parts.
//
// RT: all but set_scene and set_materials yes; making one and ending it is set-up only. Threads: one caller, where nothing else is said.
class PatchSender {
 public:
  // What can be felt from parts of the scene alone, to the same force: a method as HapticsSetup names it.
  static bool can_offer(std::string_view method_text) noexcept;

  PatchSender(TouchScene scene, double probe_radius_m, std::uint64_t scene_hash, bool is_offered, const PatchSource::Options& options = {});
  ~PatchSender();
  PatchSender(const PatchSender&) = delete;
  PatchSender& operator=(const PatchSender&) = delete;

  // session: of the hub.
  void accept(const PatchStatus& status, std::int64_t now_ns, std::uint64_t session = 0) noexcept;
  // Frames: W, and the scene in it, at that scene time.
  void note_hand(const DeviceState& state, const std::array<float, 12>& X_WS, std::int64_t scene_time_ns = 0) noexcept;
  // A move that has just been sent: it is sent again until the hub confirms it.
  void note_move(const ObjectMove& move, std::int64_t now_ns) noexcept;
  // A shape of an object that programs deform was announced.
  void note_shape(const ShapeStart& start) noexcept;
  double bits_per_s() const noexcept { return options_.bits_per_s; }
  // As the hub measures it.
  std::int64_t round_trip_ns() const noexcept;
  // That the hub took lately to make a shape of a program ready, at most 1 ms; 0: not known.
  std::int64_t shape_ns_per_vertex() const noexcept {
    return static_cast<std::int64_t>(1e9 * std::min(static_cast<double>(shape_s_per_vertex_.load(std::memory_order_relaxed)), 1e-3));
  }
  // How much later than the last reply moves have to begin, so that the hub knows of them before: 0 while it does not compute the force,
  // also because the parts are withdrawn.
  std::int64_t find_lead_ns(std::int64_t now_ns) const noexcept;
  // Another method is in use: parts of the scene are as good as it, or not. A scene with objects that can be carved is never offered.
  void set_offered(bool is_offered) noexcept { is_served_.store(is_offered, std::memory_order_release); }
  // True: the hub is to have no parts until this is called with false; then it gets those of the scene anew, and no patch begins where a
  // reply before method_serial had the probe (ForceCommand). What was not sent before a change is never sent.
  void set_withdrawn(bool is_withdrawn, std::uint32_t method_serial) noexcept;
  // Since set_withdrawn(true) no hub computes forces from parts: the one of this session, in which the client is, has confirmed the epoch
  // without any, or said that it wants none, or was sent none. False while parts are offered.
  bool is_withdrawn(std::uint64_t session) const noexcept {
    return withdrawals_.load(std::memory_order_relaxed) % 2 == 1 && !(is_requested(session) && has_sent_parts_);
  }
  // The hub of this session may have parts, or get some.
  bool is_requested(std::uint64_t session) const noexcept { return hub_ == session && hub_wants_; }
  // The hub says which request it takes parts for (PatchStatus::request). An older hub takes parts however late they come. Before the first
  // status: yes.
  bool has_numbered_requests() const noexcept { return is_numbered_; }
  // The hub gets parts when it asks. False: it keeps to the force of this node. Threads: any.
  bool is_offered() const noexcept { return is_served_.load(std::memory_order_acquire) && obstacle().empty(); }
  // Why not, whatever the method: a clause; empty: the method decides. Threads: any.
  std::string_view obstacle() const noexcept { return scene_obstacle_.load(std::memory_order_acquire); }
  // Another scene is felt from now on: its parts are offered, as an epoch of its own. scene_hash: 0: not known. revision: of NewScene. RT:
  // no. Threads: any.
  void set_scene(TouchScene scene, std::uint64_t scene_hash, std::uint32_t revision = 0);
  // Of the scene. Threads: any.
  std::uint32_t revision() const noexcept { return revision_.load(std::memory_order_acquire); }
  // The scene's materials have changed: the hub gets those of the objects that have others. Pre: one for each object. RT: no. Threads: any.
  void set_materials(const std::vector<Material>& materials);
  // The hub asked for parts a moment ago. Threads: any.
  bool is_wanted(std::int64_t now_ns) const noexcept { return now_ns < wanted_until_ns_.load(std::memory_order_relaxed); }

  // The next part to send, null: none now. It stays until pop.
  const Message* front() noexcept;
  void pop() noexcept {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    has_sent_parts_ = has_sent_parts_ || ring_[begin % kRing].is_offered;
    begin_.store(begin + 1, std::memory_order_release);
  }

  PatchSource::Counts counts() noexcept {
    counts_.take();
    return counts_.value();
  }

 private:
  static constexpr std::size_t kRing = 16;  // parts that wait for the loop that replies, which sends four after each state
  struct Status {
    PatchStatus status;
    std::int64_t time_ns = 0;
  };
  struct Part {
    Message message;
    std::uint32_t withdrawals = 0;  // when it was made
    bool is_offered = false;        // of an epoch that has parts
  };
  struct Hand {
    Vec3 p_WD = Vec3::Zero();
    std::int64_t time_ns = 0;
    std::array<float, 12> X_WS = {};
    std::int64_t scene_time_ns = 0;
  };
  struct SentMoves {
    MoveTable table;
    std::array<std::int64_t, PatchBody::kMaxBodies> sent_ns = {};  // in the order of the table
  };

  // The newest shapes, in no order; object below 0: none.
  struct SentShapes {
    struct One {
      std::int32_t object = -1;
      std::uint32_t serial = 0;
    };
    std::array<One, ShapePart::kMaxObjects> newest = {};
  };

  void run();
  void follow_shapes();
  void follow_hand(const Hand& hand);
  void follow_moves();
  void begin_moves();
  Pose pose_of(std::size_t body, double time_s) const noexcept;
  void follow_scene();
  void follow_method(std::uint32_t withdrawals);
  void follow_materials(const std::vector<Material>& materials);
  bool make_parts();
  bool must_withdraw(std::uint32_t withdrawals) const noexcept;
  bool fill(std::int64_t now_ns, std::uint32_t withdrawals);

  TouchScene scene_;
  std::atomic<const char*> scene_obstacle_;  // as obstacle()
  double probe_radius_m_;
  std::uint64_t scene_hash_;
  PatchSource::Options options_;
  std::atomic<std::int64_t> wanted_until_ns_ = 0;
  std::atomic<float> round_trip_s_ = 0.0F;
  std::atomic<float> shape_s_per_vertex_ = 0.0F;
  SentMoves sent_;  // the caller's
  Mailbox<SentMoves> moves_;
  SentShapes sent_shapes_;  // the caller's
  Mailbox<SentShapes> shapes_;
  Mailbox<Status> statuses_;
  Mailbox<Hand> hands_;
  Mailbox<PatchSource::Counts> counts_;
  std::atomic<bool> is_served_;  // what the method in use computes, parts do as well
  std::mutex scene_mutex_;
  std::optional<std::pair<TouchScene, std::uint64_t>> next_scene_;  // not followed yet, with its hash
  std::vector<Material> materials_;                                 // new ones, not followed yet; empty: none
  std::atomic<std::uint32_t> revision_ = 0;
  std::atomic<std::uint32_t> withdrawals_ = 0;    // counts the changes of set_withdrawn: odd while parts are withdrawn
  std::atomic<std::uint32_t> method_serial_ = 0;  // of set_withdrawn; set before these
  std::atomic<std::uint64_t> empty_ = 0;          // the newest epoch without parts, and above 2^32 the withdrawals when it was made
  std::uint64_t hub_ = 0;                         // the caller's: session of the newest status
  bool hub_wants_ = false;                        // ... as that said
  bool is_numbered_ = true;                       // ... as that said
  bool has_sent_parts_ = false;                   // ... since a hub confirmed that it has none
  std::array<Part, kRing> ring_;
  alignas(64) std::atomic<std::size_t> begin_{0};
  alignas(64) std::atomic<std::size_t> end_{0};

  // The thread's own.
  std::unique_ptr<TiledScene> tiles_;
  std::unique_ptr<PatchSource> source_;
  bool was_offered_ = false;
  bool wants_ = false;              // the hub, as its newest status says
  bool hub_knows_effects_ = false;  // ... likewise
  bool has_told_of_effects_ = false;
  std::uint32_t request_ = 0;  // of that
  std::uint32_t source_request_ = 0;
  std::uint32_t source_withdrawals_ = 0;
  std::uint32_t epoch_ = 0;
  std::vector<HandMotion> motions_;         // by body
  std::vector<CommandedMotion> commanded_;  // by body
  std::int64_t hand_ns_ = 0;

  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace hapton
