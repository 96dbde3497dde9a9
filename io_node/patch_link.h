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

// The network side of touch by patches: asks the haptics node for parts of the scene while they are wanted, passes on those that come,
// acknowledges those that came, and notifies the device side from when and until when it may use them.
//
//   remote ---- wanted ----> patch ---- no longer wanted ----> leaving ---- haptics has replied from where the probe is ----> remote
//
// The remote force goes on until a patch reaches the hand, and where patches start again. Meanwhile the device side is notified again and
// again where the haptics node has the probe: the first patch takes over from there. Parts that came before they were wanted again are not
// used: the haptics node may have another scene by then. The force without any datagram of haptics ends
// kAloneNs after the last one. Of a scene that moves, the device side also gets the moves of objects as they are announced, and each
// status tells the haptics node which have come.
//
// An epoch replies to one request: after the parts were dropped, one that was made before is not used any more, however late it comes
// (PatchStatus::request). Where an object was put down, the first patch waits for the probe as a haptics node has it that knows of that
// (PatchBegin::method_serial). A haptics node that sends a beginning where parts are not wanted is told so. Units: ns of the hub's
// clock. RT: yes. Threads: the network side's.
class PatchLink {
 public:
  // A choice: a network may be silent for so long without an end of touch, and a force from a scene that nobody owns lasts no longer.
  static constexpr std::int64_t kAloneNs = 1000 * kNanosecondsPerMillisecond;
  static constexpr std::int64_t kStatusNs = 100 * kNanosecondsPerMillisecond;
  static constexpr std::int64_t kProbeNs = 200 * kNanosecondsPerMillisecond;  // several times as long as following the places since takes
  static constexpr std::int64_t kSoonNs = 50 * kNanosecondsPerMillisecond;    // when there is news

  // Pre: all outlive this.
  PatchLink(HubPeers& peers, LocalPatch& local, PatchThread& thread, TouchChoice choice) noexcept
      : peers_(peers), local_(local), thread_(thread), chooser_(choice) {}

  // A part of the scene.
  void accept(const Message& part) noexcept;
  // Where an object moves that programs move; kept whether parts are wanted or not.
  void accept(const ObjectMove& move) noexcept;
  // A shape of an object that programs deform, or its start.
  void accept_shape(const Message& shape, Arrival arrival) noexcept;
  void on_haptics_joined() noexcept;
  // Once a cycle, after the force. view: where the scene is; none: at W.
  void update(ForceExchange& forces, const std::optional<ViewTransform>& view, std::int64_t now_ns) noexcept;

  bool is_wanted() const noexcept { return state_ != State::remote; }
  // The session ends: the device side computes no force from patches any more, so that the command timeout releases it.
  void finish() noexcept;
  // The median by which that was chosen; below 0: not known.
  double round_trip_s() const noexcept { return round_trip_s_; }
  const PatchThreadCounts& thread_counts() noexcept { return thread_.counts(); }
  const PatchTouch::Counts& touch_counts() noexcept { return local_.counts(); }

 private:
  enum class State : std::uint8_t { remote, patch, leaving };

  std::uint32_t request() const noexcept;
  bool note_begin(const PatchBegin& begin) noexcept;
  bool is_new_enough(std::uint32_t method_serial) const noexcept;
  bool needs_start() const noexcept { return least_method_ != 0 && !(has_start_ && is_new_enough(start_method_)); }
  void note_start(std::uint32_t method_serial) noexcept;
  void drop_parts() noexcept;
  void choose(ForceExchange& forces, std::int64_t now_ns) noexcept;
  void follow_source(const ForceExchange& forces) noexcept;
  void note_probe(const ForceExchange& forces, std::uint32_t view_revision, std::int64_t now_ns) noexcept;
  bool start_at_rest(const ForceExchange& forces) noexcept;
  void send_status(double round_trip_s, std::int64_t now_ns) noexcept;

  HubPeers& peers_;
  LocalPatch& local_;
  PatchThread& thread_;
  TouchChooser chooser_;
  State state_ = State::remote;
  PatchOrders orders_;
  MoveTable moves_;
  bool must_clear_ = false;
  bool may_begin_ = true;           // as PatchOrders has it, where only the haptics node's contact matters
  std::uint32_t begin_epoch_ = 0;   // of the newest PatchBegin; 0: none since parts were dropped
  std::uint32_t least_method_ = 0;  // ... its method_serial; 0: any reply will do
  std::uint32_t start_method_ = 0;  // of the reply that the last start is from
  bool has_start_ = false;          // ... from this haptics node
  bool is_reply_due_ = false;       // parts came that are not wanted
  bool was_local_ = false;          // the force of the cycle before came from a patch
  std::int64_t told_ns_ = 0;        // when the device side got the probe's position
  bool has_news_ = false;
  std::int64_t status_ns_ = 0;      // the last one
  std::int64_t next_check_ns_ = 0;  // at the round trip
  double round_trip_s_ = -1.0;
};

}  // namespace hapton
