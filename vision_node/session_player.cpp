#include "vision_node/session_player.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace hapton {
namespace {

constexpr std::array kSpeeds = {SessionPlayer::kSlowest, 0.25, 0.5, 1.0, 2.0, 4.0, SessionPlayer::kFastest};  // play speeds; free choices

}  // namespace

SessionPlayer::SessionPlayer(double begin_s, double end_s) : begin_s_(begin_s), end_s_(end_s), moment_s_(begin_s) {}

bool SessionPlayer::advance(std::int64_t now_ns) {
  const std::int64_t before_ns = std::exchange(last_ns_, now_ns);
  if (before_ns < 0 || is_paused_ || is_held_) return false;
  const double before_s = moment_s_;
  moment_s_ = std::min(end_s_, moment_s_ + speed_ * 1e-9 * static_cast<double>(now_ns - before_ns));
  if (moment_s_ >= end_s_) is_paused_ = true;
  return moment_s_ != before_s;
}

void SessionPlayer::seek(double t_s) {
  if (std::isfinite(t_s)) moment_s_ = std::clamp(t_s, begin_s_, end_s_);
}

void SessionPlayer::toggle_pause() {
  is_paused_ = !is_paused_;
  if (!is_paused_ && moment_s_ >= end_s_) moment_s_ = begin_s_;
}

void SessionPlayer::speed_up() {
  const auto next = std::ranges::upper_bound(kSpeeds, speed_);
  if (next != kSpeeds.end()) speed_ = *next;
}

void SessionPlayer::slow_down() {
  const auto next = std::ranges::lower_bound(kSpeeds, speed_);
  if (next != kSpeeds.begin()) speed_ = *std::prev(next);
}

}  // namespace hapton
