#include "tools/live/corner_touch.h"

#include <algorithm>

namespace hapton {
namespace {

constexpr std::int64_t kHoldNs = static_cast<std::int64_t>(1e9 * CornerTouch::kHoldS);
constexpr std::int64_t kPressNs = static_cast<std::int64_t>(1e9 * CornerTouch::kPressS);
// After a longer gap between samples the tip may be anywhere, so the touch of a corner begins again.
constexpr std::int64_t kCornerGapNs = 100'000'000;

}  // namespace

CornerTouch::Event CornerTouch::add(const ProbeState& probe) {
  const std::int64_t now_ns = probe.sample_time_ns;
  if (!probe.p_WD.allFinite() || (has_started_ && now_ns <= last_sample_ns_)) return Event::none;
  if (!has_started_) {
    p_WB_ = probe.p_WD;
    last_buttons_ = probe.buttons;
  }
  if (has_started_ && now_ns - last_sample_ns_ > kCornerGapNs) {
    samples_.clear();
    press_ns_ = 0;
  }
  has_started_ = true;
  last_sample_ns_ = now_ns;
  if ((probe.buttons & ~last_buttons_) != 0) press_ns_ = now_ns;
  last_buttons_ = probe.buttons;
  samples_.push_back({now_ns, probe.p_WD});
  // One sample at or before the beginning of the hold period remains, so that decide() sees that the whole period is covered.
  while (samples_.size() > 1 && now_ns - samples_[1].time_ns >= kHoldNs) samples_.pop_front();
  has_moved_away_ = has_moved_away_ || (probe.p_WD - p_WB_).norm() >= kMinTravelM;
  return decide(now_ns);
}

CornerTouch::Event CornerTouch::decide(std::int64_t now_ns) {
  if (press_ns_ != 0) {
    if (now_ns - press_ns_ < kPressNs) return Event::none;
    measure(press_ns_);
    return finish(moved_m_ <= kPressStillM ? Event::touched : Event::moved);
  }
  if (!has_moved_away_ || now_ns - samples_.front().time_ns < kHoldNs) return Event::none;
  measure(now_ns - kHoldNs);
  return moved_m_ <= kHoldStillM ? finish(Event::touched) : Event::none;
}

void CornerTouch::measure(std::int64_t from_ns) {
  const auto from = std::find_if(samples_.begin(), samples_.end(), [&](const Sample& each) { return each.time_ns >= from_ns; });
  Vec3 sum = Vec3::Zero();
  std::for_each(from, samples_.end(), [&](const Sample& each) { sum += each.p_WD; });
  p_W_ = sum / static_cast<double>(samples_.end() - from);
  moved_m_ = 0.0;
  std::for_each(from, samples_.end(), [&](const Sample& each) { moved_m_ = std::max(moved_m_, (each.p_WD - p_W_).norm()); });
}

CornerTouch::Event CornerTouch::finish(Event event) {
  samples_.clear();
  press_ns_ = 0;
  if (event == Event::touched) {
    p_WB_ = p_W_;
    has_moved_away_ = false;
  }
  return event;
}

}  // namespace hapton
