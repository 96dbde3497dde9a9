#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "io_node/probe_history.h"
#include "io_node/servo_stats.h"
#include "link/hub_peers.h"
#include "link/messages.h"

namespace hapton {

// Keeps the newest view transform and relays it to the haptics node: at once, when a haptics node joins, and again every kRepeatNs, in case
// a datagram was lost.
// Units: ns of the hub's clock. RT: yes. Threads: the servo's.
class ViewRelay {
 public:
  static constexpr std::int64_t kRepeatNs = 250 * kNanosecondsPerMillisecond;  // longest use of an old pose after a lost datagram

  // Pre: both outlive this.
  ViewRelay(HubPeers& peers, ServoStats& stats) noexcept : peers_(peers), stats_(stats) {}

  void start(std::int64_t now_ns) noexcept { next_repeat_ns_ = now_ns; }
  // Takes a pose from a vision node. True: the scene has moved; false: only the revision is new, as when a vision node joins.
  bool accept(const ViewTransform& view, std::int64_t now_ns) noexcept;
  void on_haptics_joined(std::size_t peer, std::int64_t now_ns) noexcept;
  void repeat_if_due(std::int64_t now_ns) noexcept;

  const std::optional<ViewTransform>& view() const noexcept { return view_; }
  // Revision of the view that the forces are computed with; see ProbeState::view_revision.
  std::uint32_t revision_in_use(const ProbeHistory& history) const noexcept;

 private:
  HubPeers& peers_;
  ServoStats& stats_;
  std::optional<ViewTransform> view_;
  std::int64_t next_repeat_ns_ = 0;
};

}  // namespace hapton
