#pragma once

#include <cstdint>
#include <utility>

#include "io_node/force_exchange.h"
#include "io_node/local_patch.h"
#include "io_node/patch_thread.h"
#include "io_node/touch_chooser.h"
#include "link/hub_peers.h"
#include "link/messages.h"

namespace hapton {

// The network side of touch by patches: requests parts of the scene from the haptics node while they are wanted, passes on those that come,
// acknowledges those that came, and notifies the device side from when and until when it may use them.
//
//   remote ---- wanted ----> patch ---- no longer wanted ----> leaving ---- haptics has replied from where the probe is ----> remote
//
// The remote force is used until a patch reaches the hand, also when patches start again after an interruption. Until then the device side
// is notified repeatedly where the haptics node has the probe: the first patch takes over from there. Parts that came before patches were
// wanted again are not used: the haptics node may have another scene by then. Without any datagram of the haptics node, the force from
// patches ends kMaxSilenceNs after the last one. If the scene moves, the device side also gets the moves of objects as they are announced,
// and each status names the moves that have come.
//
// Each epoch of parts replies to one request: once parts were dropped, an epoch that replies to an earlier request is not used, however
// late it comes (PatchStatus::request). Where an object was put down, the first patch waits for a position of the probe from a haptics node
// that knows of it (PatchBegin::method_serial). A haptics node that begins to send parts while they are not wanted gets a status that says
// so. Units: ns of the hub's clock. RT: yes. Threads: the network side's.
class PatchLink {
 public:
  // A choice: the force outlasts a silence of the network of this length, and no longer: the haptics node may be gone.
  static constexpr std::int64_t kMaxSilenceNs = 1000 * kNanosecondsPerMillisecond;
  static constexpr std::int64_t kStatusNs = 100 * kNanosecondsPerMillisecond;  // between two statuses without news
  static constexpr std::int64_t kProbeNs = 200 * kNanosecondsPerMillisecond;   // several times what a patch needs to catch up with the hand
  static constexpr std::int64_t kMinStatusNs = 50 * kNanosecondsPerMillisecond;  // between two statuses when there is news

  // Pre: all outlive this.
  PatchLink(HubPeers& peers, LocalPatch& local, PatchThread& thread, TouchChoice choice) noexcept
      : peers_(peers), local_patch_(local), thread_(thread), chooser_(choice) {}

  // Takes a part of the scene.
  void accept(const Message& part) noexcept;
  // Takes a move of an object that programs move; it is kept whether parts are wanted or not.
  void accept(const ObjectMove& move) noexcept;
  // Takes a part of the shape of an object that programs deform, or the start of that shape.
  void accept_shape(const Message& shape, Arrival arrival) noexcept;
  void on_haptics_joined() noexcept;
  // Call once a cycle, after the force. view: gives the pose of the scene; none: the identity.
  void update(ForceExchange& forces, const std::optional<ViewTransform>& view, std::int64_t now_ns) noexcept;

  bool is_wanted() const noexcept { return state_ != State::remote; }
  // The session ends: the device side computes no force from patches any more, so that the command timeout releases it.
  void finish() noexcept;
  // Median round trip from which the source of the force was chosen, s; below 0: not known.
  double round_trip_s() const noexcept { return round_trip_s_; }
  const PatchThreadCounts& thread_counts() noexcept { return thread_.counts(); }
  const PatchTouch::Counts& touch_counts() noexcept { return local_patch_.counts(); }

 private:
  enum class State : std::uint8_t { remote, patch, leaving };

  std::uint32_t request() const noexcept;
  bool note_begin(const PatchBegin& begin) noexcept;
  bool is_new_enough(std::uint32_t method_serial) const noexcept;
  bool needs_start() const noexcept { return min_method_serial_ != 0 && !(has_start_ && is_new_enough(start_method_serial_)); }
  void note_start(std::uint32_t method_serial) noexcept;
  void drop_parts() noexcept;
  void choose_source(ForceExchange& forces, std::int64_t now_ns) noexcept;
  void follow_source(const ForceExchange& forces) noexcept;
  void note_probe(const ForceExchange& forces, std::uint32_t view_revision, std::int64_t now_ns) noexcept;
  bool start_at_rest(const ForceExchange& forces) noexcept;
  void send_status(double round_trip_s, std::int64_t now_ns) noexcept;

  HubPeers& peers_;
  LocalPatch& local_patch_;
  PatchThread& thread_;
  TouchChooser chooser_;
  State state_ = State::remote;
  PatchOrders orders_;
  MoveTable moves_;
  bool must_clear_ = false;
  bool may_begin_ = true;                  // as PatchOrders::may_begin, but apart from needs_start()
  std::uint32_t begin_epoch_ = 0;          // of the newest PatchBegin; 0: none since parts were dropped
  std::uint32_t min_method_serial_ = 0;    // ... its method_serial, the least that a start must have; 0: any start will do
  std::uint32_t start_method_serial_ = 0;  // method_serial of the reply that gave the last start
  bool has_start_ = false;                 // ... which this haptics node sent
  bool is_reply_due_ = false;              // parts came while they were not wanted
  bool was_local_ = false;                 // the force of the cycle before came from a patch
  std::int64_t probe_noted_ns_ = 0;        // when the device side got the probe's position
  bool has_news_ = false;
  std::int64_t last_status_ns_ = 0;  // time of the last status
  std::int64_t next_round_trip_check_ns_ = 0;
  double round_trip_s_ = -1.0;
};

}  // namespace hapton
