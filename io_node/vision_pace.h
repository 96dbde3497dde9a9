#pragma once

#include <array>
#include <cstdint>

#include "link/hub_peers.h"
#include "link/messages.h"
#include "runtime/clock.h"

namespace hapton {

// When each vision node is due a state of the probe. It gets no more than it draws: the next one goes out when it has said Drawn for the
// last and is about to draw again, and then only if anything has changed. What is lost on the way is sent again after kRepeatNs, and so is
// what has not changed.
// RT: yes.
class VisionPace {
 public:
  static constexpr std::int64_t kRepeatNs = 100 * kNanosecondsPerMillisecond;
  // After a state that gave the same picture: as long as a frame of an ordinary screen.
  static constexpr std::int64_t kUnseenNs = 16 * kNanosecondsPerMillisecond;

  enum class Decision : std::uint8_t { wait, skip, send };

  // rate_hz: states a second to each node, at most; 0: none.
  explicit VisionPace(double rate_hz) noexcept;

  void on_joined(std::size_t peer) noexcept { places_[peer] = {}; }
  void on_drawn(std::size_t peer, const Drawn& drawn, std::int64_t now_ns) noexcept;

  // Pre: the peer is a vision node. spare: it is its turn, and it knows this state already. send: the caller sends it now.
  Decision decide(std::size_t peer, const ProbeState& probe, std::int64_t now_ns) noexcept;

 private:
  struct Place {
    ProbeState told;
    std::int64_t repeat_ns = 0;  // what was told is told again
    std::int64_t next_ns = 0;    // no sooner than that
    bool is_waiting = false;     // for its word that it has drawn
  };

  std::int64_t period_ns_;
  std::array<Place, HubPeers::kCapacity> places_ = {};
};

}  // namespace hapton
