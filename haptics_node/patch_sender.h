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

// Gives the hub the scene in parts, when the hub requests them: a thread of its own divides the scene, once, and decides which part is sent
// next; the reply loop sends it. Nothing is done before the hub's first request. An epoch is one set of parts with its number.
//
// An object that the stylus picks up leaves its place. Before it does, the parts are withdrawn: the hub gets an epoch without parts, and
// is_withdrawn() says when the hub has confirmed it, so that nobody feels the object where it no longer is. Each epoch replies to one
// request of the hub, and the hub accepts no other epoch: parts that arrive late are ignored once the hub has dropped its parts.
//
// RT: all except set_scene and set_materials yes; construction and destruction set-up only. Threads: one caller, except as noted below.
class PatchSender {
 public:
  // Whether the hub can compute the same force from parts of the scene alone. method_text: HapticsSetup::method.
  static bool can_offer(std::string_view method_text) noexcept;

  PatchSender(TouchScene scene, double probe_radius_m, std::uint64_t scene_hash, bool is_offered, const PatchSource::Options& options = {});
  ~PatchSender();
  PatchSender(const PatchSender&) = delete;
  PatchSender& operator=(const PatchSender&) = delete;

  // session: HubClient::session() when the status arrived.
  void accept(const PatchStatus& status, std::int64_t now_ns, std::uint64_t session = 0) noexcept;
  // To be called for each device state while is_wanted(), with the view transform and the scene time of that sample.
  void note_hand(const DeviceState& state, const std::array<float, 12>& X_WS, std::int64_t scene_time_ns = 0) noexcept;
  // To be called when a move has just been sent: it is sent again until the hub confirms it.
  void note_move(const ObjectMove& move, std::int64_t now_ns) noexcept;
  // To be called when a shape of an object that programs deform was announced.
  void note_shape(const ShapeStart& start) noexcept;
  double bits_per_s() const noexcept { return options_.bits_per_s; }
  // Round trip as the hub measures it, at most 2 s.
  std::int64_t round_trip_ns() const noexcept;
  // Time for each vertex that the hub took lately to make a program's shape ready, at most 1 ms; 0: not known.
  std::int64_t shape_ns_per_vertex() const noexcept {
    return static_cast<std::int64_t>(1e9 * std::min(static_cast<double>(shape_s_per_vertex_.load(std::memory_order_relaxed)), 1e-3));
  }
  // How much later than the last reply moves have to begin, so that the hub knows of them before they begin. 0 while the hub does not
  // compute the force, also because the parts are withdrawn.
  std::int64_t find_lead_ns(std::int64_t now_ns) const noexcept;
  // To be called when another method is in use, with its can_offer(). A scene with objects that can be carved is never offered.
  void set_offered(bool is_offered) noexcept { can_offer_method_.store(is_offered, std::memory_order_release); }
  // True: withdraws all parts, until this is called with false; then the hub gets the parts of the scene again, and starts no patch at the
  // probe of a reply from before method_serial (ForceCommand). Parts that were not sent before a change are never sent.
  void set_withdrawn(bool is_withdrawn, std::uint32_t method_serial) noexcept;
  // True if since set_withdrawn(true) no hub computes forces from parts: the hub of `session`, which the client has joined, has confirmed
  // the epoch without parts, or has said that it wants none, or was sent none. False while parts are not withdrawn.
  bool is_withdrawn(std::uint64_t session) const noexcept {
    return withdrawals_.load(std::memory_order_relaxed) % 2 == 1 && !(is_requested(session) && has_sent_parts_);
  }
  // Whether the hub of this session requests parts, so that it may have some.
  bool is_requested(std::uint64_t session) const noexcept { return hub_session_ == session && hub_requests_parts_; }
  // Whether the hub numbers its requests (PatchStatus::request) and accepts only parts that reply to the newest one. A hub of an earlier
  // version accepts parts however late they arrive. True before the first status.
  bool has_numbered_requests() const noexcept { return numbers_requests_; }
  // Whether the hub gets parts when it requests them; otherwise the force of this node is used. Threads: any.
  bool is_offered() const noexcept { return can_offer_method_.load(std::memory_order_acquire) && obstacle().empty(); }
  // Why the scene cannot be offered with any method, as a clause; empty: it depends on the method. Threads: any.
  std::string_view obstacle() const noexcept { return scene_obstacle_.load(std::memory_order_acquire); }
  // To be called when another scene is felt: its parts are offered, in an epoch of their own. scene_hash 0: not known. revision:
  // NewScene::revision. RT: no. Threads: any.
  void set_scene(TouchScene scene, std::uint64_t scene_hash, std::uint32_t revision = 0);
  // NewScene::revision of the scene that was set last. Threads: any.
  std::uint32_t revision() const noexcept { return revision_.load(std::memory_order_acquire); }
  // To be called when materials of the scene have changed: the hub gets the changed ones. Pre: one for each object. RT: no. Threads: any.
  void set_materials(const std::vector<Material>& materials);
  // Whether the hub requested parts within the last second. Threads: any.
  bool is_wanted(std::int64_t now_ns) const noexcept { return now_ns < wanted_until_ns_.load(std::memory_order_relaxed); }

  // The next part to send; null: there is none now. The part stays the next one until pop().
  const Message* front() noexcept;
  void pop() noexcept {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    has_sent_parts_ = has_sent_parts_ || ring_[begin % kRingSlots].is_offered;
    begin_.store(begin + 1, std::memory_order_release);
  }

  PatchSource::Counts counts() noexcept {
    counts_.take();
    return counts_.value();
  }

 private:
  static constexpr std::size_t kRingSlots = 16;  // parts that wait for the reply loop, which sends four after each state
  struct Status {
    PatchStatus status;
    std::int64_t time_ns = 0;
  };
  struct Part {
    Message message;
    std::uint32_t withdrawals = 0;  // withdrawals_ when the part was made
    bool is_offered = false;        // the part's epoch has parts of the scene
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

  // The newest shape of each object, in any order; object below 0: an unused place.
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
  SentMoves sent_moves_;  // used by the caller only
  Mailbox<SentMoves> moves_;
  SentShapes sent_shapes_;  // used by the caller only
  Mailbox<SentShapes> shapes_;
  Mailbox<Status> statuses_;
  Mailbox<Hand> hands_;
  Mailbox<PatchSource::Counts> counts_;
  std::atomic<bool> can_offer_method_;  // can_offer() of the method in use
  std::mutex scene_mutex_;
  std::optional<std::pair<TouchScene, std::uint64_t>> next_scene_;  // the scene set last, with its hash, until the thread takes it over
  std::vector<Material> next_materials_;                            // materials set last, until the thread takes them over; empty: none
  std::atomic<std::uint32_t> revision_ = 0;
  std::atomic<std::uint32_t> withdrawals_ = 0;    // counts the changes of set_withdrawn: odd while parts are withdrawn
  std::atomic<std::uint32_t> method_serial_ = 0;  // from set_withdrawn; stored before withdrawals_
  std::atomic<std::uint64_t> empty_epoch_ = 0;    // newest epoch without parts; its upper 32 bits: withdrawals_ when it was made
  std::uint64_t hub_session_ = 0;                 // session of the newest status; this and the next three: used by the caller only
  bool hub_requests_parts_ = false;               // the hub requests parts, by the newest status
  bool numbers_requests_ = true;                  // the hub numbers its requests, by the newest status
  bool has_sent_parts_ = false;                   // parts were sent since a hub confirmed that it has none
  std::array<Part, kRingSlots> ring_;
  alignas(64) std::atomic<std::size_t> begin_{0};
  alignas(64) std::atomic<std::size_t> end_{0};

  // Used by the object's own thread only.
  std::unique_ptr<TiledScene> tiles_;
  std::unique_ptr<PatchSource> source_;
  bool was_offered_ = false;
  bool wants_parts_ = false;        // the hub requests parts, by its newest status
  bool hub_knows_effects_ = false;  // likewise: the hub can compute effects
  bool has_warned_of_effects_ = false;
  std::uint32_t request_ = 0;  // PatchStatus::request of the newest status
  std::uint32_t source_request_ = 0;
  std::uint32_t source_withdrawals_ = 0;
  std::uint32_t epoch_ = 0;
  std::vector<HandMotion> hand_motions_;            // by body
  std::vector<CommandedMotion> commanded_motions_;  // by body
  std::int64_t last_hand_ns_ = 0;

  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace hapton
