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

// Carries out what tools and vision nodes request: servo rate, force method, material, moves and shapes of objects, report, reset of a
// latched fault, hand target. RT: yes. Threads: all the network side's, except take_report_request, which one other thread calls.
class RequestHandler {
 public:
  // Pre: all outlive this. rate_hz: the initial servo rate.
  RequestHandler(DeviceLoop& loop, HubPeers& peers, const Clock& clock, EventRing& events, ServoStats& stats, double rate_hz) noexcept
      : loop_(loop), peers_(peers), clock_(clock), events_(events), stats_(stats), rate_hz_(rate_hz) {
    move_buckets_.fill(TokenBucket(kMovesPerSecond, kMovesAtOnce));
    shape_buckets_.fill(TokenBucket(kShapePartsPerSecond, kShapePartsAtOnce));
  }

  void accept(const Settings& settings, const PeerEvent& event) noexcept;
  // Passed on to the haptics node, which checks it and replies.
  void accept(const MaterialRequest& request, const PeerEvent& event) noexcept;
  // Passed on to the haptics node, kMovesPerSecond of each sender at most; more are dropped and counted (ServoStats::moves_rejected).
  void accept(const MoveRequest& request, const PeerEvent& event) noexcept;
  // A reply of the haptics node: passed on to the peer that sent the request.
  void accept(const MoveReply& reply) noexcept;
  // A part of a shape: passed on to the haptics node, kShapePartsPerSecond of each sender at most, and kAllShapePartsPerSecond of all; more
  // are dropped and counted (ServoStats::shape_parts_rejected).
  void accept(const ShapeRequest& part, const PeerEvent& event) noexcept;
  // A reply of the haptics node: passed on to the peer that sent parts of that stream last.
  void accept(const ShapeReply& reply) noexcept;
  // The peer that set an active target last controls the simulated hand, until it sends an inactive one or leaves.
  void accept(const HandTarget& target, std::size_t peer) noexcept;
  // The node in this slot has left, or another node has taken the slot.
  void on_peer_gone(std::size_t peer) noexcept;

  double rate_hz() const noexcept { return rate_hz_; }
  // Number of denied requests to reset faults: the sender has no right to, or no person is known to be at the device (check_reset).
  std::uint64_t resets_denied() const noexcept { return resets_denied_; }
  // Called by the other thread: true if a report was requested since the last call.
  bool take_report_request() noexcept { return is_report_requested_.exchange(false, std::memory_order_acq_rel); }

  static constexpr std::int64_t kMovesPerSecond = 250;  // of one sender: hapton dynamics sends 200
  static constexpr std::int64_t kMovesAtOnce = 32;      // a burst of one sender
  // 30 shapes a second of 8,500 vertices. Each part takes the haptics node some microseconds.
  static constexpr std::int64_t kShapePartsPerSecond = 4000;
  static constexpr std::int64_t kAllShapePartsPerSecond = 6000;
  static constexpr std::int64_t kShapePartsAtOnce = 2 * ShapePart::kMaxParts;

 private:
  static constexpr std::size_t kNobody = HubPeers::kCapacity;
  static constexpr std::size_t kMovesAwaited = 64;  // replies to the newest requests are passed on, others dropped

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
  std::array<TokenBucket, HubPeers::kCapacity> move_buckets_;  // by sender
  std::array<AwaitedMove, kMovesAwaited> awaited_moves_ = {};  // the newest, a ring
  std::size_t next_awaited_ = 0;
  std::array<TokenBucket, HubPeers::kCapacity> shape_buckets_;  // by sender
  TokenBucket all_shapes_bucket_{kAllShapePartsPerSecond, kShapePartsAtOnce};
  std::array<std::uint32_t, HubPeers::kCapacity> shape_streams_ = {};  // stream of the last part of each sender; 0: none
  std::uint64_t resets_denied_ = 0;
  std::int64_t next_denial_notice_ns_ = 0;
  std::atomic<bool> is_report_requested_{false};
};

}  // namespace hapton
