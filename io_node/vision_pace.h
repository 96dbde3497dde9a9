#pragma once

#include <array>
#include <cstdint>

#include "link/hub_peers.h"
#include "link/messages.h"
#include "runtime/clock.h"

namespace hapton {

// Paces the probe states to each vision node, so that it gets no more than it draws: the next one is sent when the node has acknowledged
// the last with FrameAck and is about to draw again, and only if anything visible has changed. A lost or unchanged state is repeated after
// kRepeatNs; an acknowledgement that is told again changes nothing. While a button of the stylus is held down, states do not wait for
// frames: a vision node that draws strokes has a point of each (docs/vision.md). A node that passes states on (FrameAck::every_sample) gets
// those in which nothing has changed too. RT: yes.
class VisionPace {
 public:
  // The picture of a hand that rests is late by no more if a state was lost.
  static constexpr std::int64_t kRepeatNs = 100 * kNanosecondsPerMillisecond;
  // After a state that gave the same frame: one frame of a 60 Hz display.
  static constexpr std::int64_t kUnseenNs = 16 * kNanosecondsPerMillisecond;

  enum class Decision : std::uint8_t { wait, skip, send };

  // rate_hz: states a second to each node, at most; 0: none. ignored_buttons: a dead man's switch is down all the time.
  explicit VisionPace(double rate_hz, std::uint32_t ignored_buttons = 0) noexcept;

  void on_joined(std::size_t peer) noexcept { places_[peer] = {}; }
  void on_frame_ack(std::size_t peer, const FrameAck& frame, std::int64_t now_ns) noexcept;

  // Pre: the peer is a vision node. skip: a state is due, and unchanged. send: the caller sends it now.
  Decision decide(std::size_t peer, const ProbeState& probe, std::int64_t now_ns) noexcept;

 private:
  struct Place {
    ProbeState sent;
    std::int64_t repeat_ns = 0;  // interval at which a state is sent again
    std::int64_t next_ns = 0;    // no sooner than that
    bool is_waiting = false;     // for its frame acknowledgement
    bool wants_every_sample = false;
  };

  std::int64_t period_ns_;
  std::uint32_t ignored_buttons_;
  std::array<Place, HubPeers::kCapacity> places_ = {};
};

}  // namespace hapton
