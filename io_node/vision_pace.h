#pragma once

#include <array>
#include <cstdint>

#include "link/hub_peers.h"
#include "link/messages.h"
#include "runtime/clock.h"

namespace hapton {

// Paces the probe states to each vision node, so that it gets no more than it draws: the next one is sent when the node has acknowledged
// the last with FrameAck and is about to draw again, and only if anything visible has changed. A lost or unchanged state is repeated after
// kRepeatNs; an acknowledgement that is repeated as unchanged has no effect. While a button of the stylus is held down, states do not wait
// for frames, so a vision node that draws strokes gets a point from each state (docs/vision.md). A node that passes states on
// (FrameAck::every_sample) also gets those in which nothing has changed. RT: yes.
class VisionPace {
 public:
  // If a state was lost, the picture of a hand at rest is late by at most this.
  static constexpr std::int64_t kRepeatNs = 100 * kNanosecondsPerMillisecond;
  // Pause after a state that gave the same frame: one frame of a 60 Hz display.
  static constexpr std::int64_t kUnchangedPauseNs = 16 * kNanosecondsPerMillisecond;

  enum class Decision : std::uint8_t { wait, skip, send };

  // rate_hz: most states a second to each node; 0: none. ignored_buttons: not counted as held, e.g. a dead man's switch, which always is.
  explicit VisionPace(double rate_hz, std::uint32_t ignored_buttons = 0) noexcept;

  void on_joined(std::size_t peer) noexcept { slots_[peer] = {}; }
  void on_frame_ack(std::size_t peer, const FrameAck& frame, std::int64_t now_ns) noexcept;

  // Pre: the peer is a vision node. skip: a state is due, but it is unchanged and not sent. send: the caller sends it now.
  Decision decide(std::size_t peer, const ProbeState& probe, std::int64_t now_ns) noexcept;

 private:
  struct Slot {
    ProbeState sent;
    std::int64_t repeat_ns = 0;  // time at which a state is sent again, even if unchanged or not acknowledged
    std::int64_t next_ns = 0;    // no state is sent before this time
    bool is_waiting = false;     // for the acknowledgement of the state sent last
    bool wants_every_sample = false;
  };

  std::int64_t period_ns_;
  std::uint32_t ignored_buttons_;
  std::array<Slot, HubPeers::kCapacity> slots_ = {};
};

}  // namespace hapton
