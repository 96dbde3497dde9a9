#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "io_node/device_loop.h"
#include "io_node/event_ring.h"
#include "io_node/servo_stats.h"
#include "link/hub_peers.h"
#include "link/messages.h"
#include "link/rate_limit.h"
#include "runtime/clock.h"

namespace hapton {

// Carries out what tools and vision nodes request: servo rate, force method, material, moves of objects, report, reset of a latched fault,
// hand target. RT: yes. Threads: the servo's; take_report_request one other.
class RequestHandler {
 public:
  // Pre: all outlive this. rate_hz: of the servo, at first.
  RequestHandler(DeviceLoop& loop, HubPeers& peers, const Clock& clock, EventRing& events, ServoStats& stats, double rate_hz) noexcept
      : loop_(loop), peers_(peers), clock_(clock), events_(events), stats_(stats), rate_hz_(rate_hz) {
    move_rates_.fill(TokenBucket(kMovesPerSecond, kMovesAtOnce));
  }

  void accept(const Settings& settings, const PeerEvent& event) noexcept;
  // Passed on: the haptics node checks it and replies.
  void accept(const MaterialRequest& request, const PeerEvent& event) noexcept;
  // Passed on, kMovesPerSecond of each sender at most; the others are counted.
  void accept(const MoveRequest& request, const PeerEvent& event) noexcept;
  // Of the haptics node: passed on to who requested it.
  void accept(const MoveReply& reply) noexcept;
  // The newest vision node that sets an active target controls the simulated hand until it releases it or leaves.
  void accept(const HandTarget& target, std::size_t peer) noexcept;
  // The node in this slot has left, or another one has taken it.
  void on_peer_gone(std::size_t peer) noexcept;

  double rate_hz() const noexcept { return rate_hz_; }
  // Here, for want of the right or of a person.
  std::uint64_t resets_denied() const noexcept { return resets_denied_; }
  // The other thread: true once for each request.
  bool take_report_request() noexcept { return is_report_requested_.exchange(false, std::memory_order_acq_rel); }

  static constexpr std::int64_t kMovesPerSecond = 250;
  static constexpr std::int64_t kMovesAtOnce = 32;

 private:
  static constexpr std::size_t kNobody = HubPeers::kCapacity;
  static constexpr std::size_t kMovesAwaited = 64;

  // Who awaits the reply to a request to move an object.
  struct AwaitedMove {
    std::uint32_t request = 0;
    std::size_t peer = kNobody;
  };

  void set_rate(double rate_hz, NodeRole role) noexcept;
  void request_method(const Settings& settings, NodeRole role) noexcept;
  void reset_faults(const Peer& sender) noexcept;
  void note_denied(ServoEvent::Kind why, const Peer& sender) noexcept;

  DeviceLoop& loop_;
  HubPeers& peers_;
  const Clock& clock_;
  EventRing& events_;
  ServoStats& stats_;
  double rate_hz_;
  std::size_t hand_controller_ = kNobody;
  std::array<TokenBucket, HubPeers::kCapacity> move_rates_;    // by sender
  std::array<AwaitedMove, kMovesAwaited> awaited_moves_ = {};  // the newest, a ring
  std::size_t next_awaited_ = 0;
  std::uint64_t resets_denied_ = 0;
  std::int64_t next_denial_notice_ns_ = 0;
  std::atomic<bool> is_report_requested_{false};
};

}  // namespace hapton
