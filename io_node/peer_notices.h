#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "io_node/event_ring.h"
#include "link/hub_peers.h"
#include "link/seal_counts.h"
#include "runtime/clock.h"

namespace hapton {

// A peer without the right key, protocol version or role gets no reply; the person at the hub gets a notice, at most every ten seconds. RT:
// yes. Threads: one.
class UnknownPeerNotices {
 public:
  static constexpr std::int64_t kEveryNs = 10 * kNanosecondsPerSecond;

  // Calls notify(kind) for each kind that occurred since the last check.
  template <class Notify>
  void check(const SealCounts& seal, const HubCounts& hub, std::int64_t now_ns, Notify&& notify) noexcept {
    if (now_ns < next_ns_) return;
    const auto notify_if = [&](std::uint64_t count, std::uint64_t& notified, ServoEvent::Kind kind) {
      if (count == notified) return;
      notified = count;
      next_ns_ = now_ns + kEveryNs;
      notify(kind);
    };
    notify_if(seal.wrong_key, wrong_key_, ServoEvent::Kind::wrong_key);
    notify_if(seal.wrong_version, wrong_version_, ServoEvent::Kind::wrong_version);
    notify_if(hub.role_violations, role_violations_, ServoEvent::Kind::role_violation);
  }

 private:
  std::uint64_t wrong_key_ = 0;
  std::uint64_t wrong_version_ = 0;
  std::uint64_t role_violations_ = 0;
  std::int64_t next_ns_ = 0;
};

// A node rejected because its slot is taken retries ten times a second. The log has one line, and another when the node returns after a
// pause. RT: yes. Threads: one.
class RejectionNotices {
 public:
  static constexpr std::int64_t kPauseNs = 10 * kNanosecondsPerSecond;

  // Whether a rejection of that role at that time is worth a notice.
  bool is_due(NodeRole role, std::int64_t now_ns) noexcept {
    std::int64_t& last_ns = last_ns_[static_cast<std::size_t>(role) % last_ns_.size()];
    const bool is_due = last_ns == kNever || now_ns - last_ns > kPauseNs;
    last_ns = now_ns;
    return is_due;
  }

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();
  std::array<std::int64_t, 8> last_ns_ = {kNever, kNever, kNever, kNever, kNever, kNever, kNever, kNever};  // by NodeRole
};

// Log lines about the peers: joined, left, rejected, or flooding. RT: yes. Threads: one.
class PeerNotices {
 public:
  // Pre: both outlive this.
  PeerNotices(EventRing& events, HubPeers& peers) noexcept : events_(events), peers_(peers) {}

  // Logs that a node has joined, left or was rejected; ignores other events.
  void note(const PeerEvent& event) noexcept;
  // Call periodically: logs unknown peers and floods.
  void check(std::int64_t now_ns) noexcept;

 private:
  void push(ServoEvent::Kind kind, NodeRole role, const Address& address) noexcept { events_.push({kind, role, address, 0.0, {}, {}}); }

  EventRing& events_;
  HubPeers& peers_;
  UnknownPeerNotices unknown_;
  RejectionNotices rejections_;
};

}  // namespace hapton
