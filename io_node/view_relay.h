#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "io_node/probe_history.h"
#include "io_node/servo_stats.h"
#include "link/hub_peers.h"
#include "link/messages.h"

namespace hapton {

// Keeps the newest view transform and relays it to the haptics node and to the other vision nodes, so that all show the scene as it is
// felt: at once, when one of them joins, and again every kRepeatNs, in case a datagram was lost.
//
// Several vision nodes may turn the scene. Every view of the node whose view is in use is taken; a view of another node is taken only if
// its revision is ahead, so that node must know the view in use: a node that has just joined does not turn the scene under the hand. If it
// is not taken, the node is sent the view in use. Once the node whose view is in use has left, the next view of any node is taken.
// Units: ns of the hub's clock. RT: yes. Threads: the network side's.
class ViewRelay {
 public:
  static constexpr std::int64_t kRepeatNs = 250 * kNanosecondsPerMillisecond;  // longest use of an old pose after a lost datagram

  // Pre: both outlive this.
  ViewRelay(HubPeers& peers, ServoStats& stats) noexcept : peers_(peers), stats_(stats) {}

  void start(std::int64_t now_ns) noexcept { next_repeat_ns_ = now_ns; }
  // Takes a pose from a vision node. True: the scene has moved; false: only the revision is new, or the view does not count.
  bool accept(const ViewTransform& view, std::size_t peer, std::int64_t now_ns) noexcept;
  // Takes the view that the haptics node has if the hub knows none, as after a restart without a vision node. True: it was taken.
  bool accept(const HapticsSetup& setup) noexcept;
  // A haptics or a vision node has joined, maybe in the place of another one.
  void on_joined(std::size_t peer, std::int64_t now_ns) noexcept;
  void on_left(std::size_t peer) noexcept;
  void repeat_if_due(std::int64_t now_ns) noexcept;

  const std::optional<ViewTransform>& view() const noexcept { return view_; }
  // Revision of the view that the forces are computed with; see ProbeState::view_revision.
  std::uint32_t revision_in_use(const ProbeHistory& history) const noexcept;

 private:
  void show_others() noexcept;

  HubPeers& peers_;
  ServoStats& stats_;
  static constexpr std::size_t kNobody = HubPeers::kCapacity;

  std::optional<ViewTransform> view_;
  std::size_t owner_ = kNobody;  // the peer that sent the view in use
  std::int64_t next_repeat_ns_ = 0;
};

}  // namespace hapton
