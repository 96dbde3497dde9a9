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

// Who lacks the key, the version or the right to a role is told nothing; the person at the hub is, every ten seconds at most.
// RT: yes. Threads: one.
class StrangerNews {
 public:
  static constexpr std::int64_t kEveryNs = 10 * kNanosecondsPerSecond;

  // Calls tell(kind) for each kind that came since the last time that this looked.
  template <class Tell>
  void look(const SealCounts& seal, const HubCounts& hub, std::int64_t now_ns, Tell&& tell) noexcept {
    if (now_ns < next_ns_) return;
    const auto tell_if = [&](std::uint64_t count, std::uint64_t& told, ServoEvent::Kind kind) {
      if (count == told) return;
      told = count;
      next_ns_ = now_ns + kEveryNs;
      tell(kind);
    };
    tell_if(seal.wrong_key, wrong_key_, ServoEvent::Kind::wrong_key);
    tell_if(seal.wrong_version, wrong_version_, ServoEvent::Kind::wrong_version);
    tell_if(hub.role_violations, role_violations_, ServoEvent::Kind::role_violation);
  }

 private:
  std::uint64_t wrong_key_ = 0;
  std::uint64_t wrong_version_ = 0;
  std::uint64_t role_violations_ = 0;
  std::int64_t next_ns_ = 0;
};

// A node that finds its place taken tries again ten times a second. A person is told once, and again when it comes back after a pause.
// RT: yes. Threads: one.
class RefusalNews {
 public:
  static constexpr std::int64_t kPauseNs = 10 * kNanosecondsPerSecond;

  // Whether a refusal of that role at that time is news.
  bool is_news(NodeRole role, std::int64_t now_ns) noexcept {
    std::int64_t& last_ns = last_ns_[static_cast<std::size_t>(role) % last_ns_.size()];
    const bool is_news = last_ns == kNever || now_ns - last_ns > kPauseNs;
    last_ns = now_ns;
    return is_news;
  }

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();
  std::array<std::int64_t, 8> last_ns_ = {kNever, kNever, kNever, kNever, kNever, kNever, kNever, kNever};  // by NodeRole
};

}  // namespace hapton
