#include "io_node/vision_pace.h"

#include <algorithm>
#include <cmath>

#include "core/base/period_ns.h"

namespace hapton {
namespace {

// True: the states differ in nothing that a person sees; the sample and its time do not count.
bool looks_same(const ProbeState& a, const ProbeState& b) noexcept {
  return a.p_WD == b.p_WD && a.q_WT.coeffs() == b.q_WT.coeffs() && a.visual_offset_m == b.visual_offset_m && a.force_n == b.force_n &&
         a.contact == b.contact && a.buttons == b.buttons && a.servo_rate_hz == b.servo_rate_hz &&
         a.round_trip_p50_us == b.round_trip_p50_us && a.round_trip_p99_us == b.round_trip_p99_us && a.view_revision == b.view_revision &&
         a.status == b.status && a.energy_percent == b.energy_percent && a.object == b.object && a.torque_nm == b.torque_nm &&
         a.visual_turn == b.visual_turn && a.scene_time_ns == b.scene_time_ns && a.haptons == b.haptons;
}

}  // namespace

VisionPace::VisionPace(double rate_hz, std::uint32_t ignored_buttons) noexcept
    : period_ns_(rate_hz > 0.0 ? period_ns(rate_hz) : 0), ignored_buttons_(ignored_buttons) {}

void VisionPace::on_frame_ack(std::size_t peer, const FrameAck& frame, std::int64_t now_ns) noexcept {
  Slot& slot = slots_[peer];
  if (frame.echo_sample < slot.sent.sample || (frame.unchanged && !slot.is_waiting)) return;  // about an older state, or repeated
  slot.is_waiting = false;
  slot.wants_every_sample = frame.every_sample;
  const std::int64_t rest_ns = std::min<std::int64_t>(frame.rest_ns, kRepeatNs);
  if ((slot.sent.buttons & ~ignored_buttons_) != 0) return;
  slot.next_ns = std::max(slot.next_ns, now_ns + std::max(rest_ns, frame.unchanged ? kUnchangedPauseNs : 0));
}

VisionPace::Decision VisionPace::decide(std::size_t peer, const ProbeState& probe, std::int64_t now_ns) noexcept {
  Slot& slot = slots_[peer];
  const bool is_pressed = (probe.buttons & ~ignored_buttons_) != 0;
  const bool repeats = now_ns >= slot.repeat_ns;
  if (period_ns_ == 0 || now_ns < slot.next_ns || (slot.is_waiting && !repeats && !is_pressed)) return Decision::wait;
  slot.next_ns = std::max(slot.next_ns + period_ns_, now_ns);
  if (!repeats && !slot.wants_every_sample && looks_same(probe, slot.sent)) return Decision::skip;
  slot.sent = probe;
  slot.repeat_ns = now_ns + kRepeatNs;
  slot.is_waiting = true;
  return Decision::send;
}

}  // namespace hapton
