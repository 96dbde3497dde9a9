#include "core/math/keyframe_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapton {

// Between two equal keyframes the result stays the same to the last bit.
Keyframe keyframe_between(const Keyframe& from, const Keyframe& to, double share) noexcept {
  Keyframe between;
  between.p_S = from.p_S + share * (to.p_S - from.p_S);
  between.turn = from.turn.coeffs() == to.turn.coeffs() ? from.turn : from.turn.slerp(share, to.turn).normalized();
  return between;
}

Pose pose_of(const Keyframe& keyframe, const Vec3& pivot_S) noexcept {
  Pose X_SO = Pose::Identity();
  X_SO.linear() = keyframe.turn.toRotationMatrix();
  X_SO.translation() = keyframe.p_S - X_SO.linear() * pivot_S;
  return X_SO;
}

double most_travel_m(const Keyframe& from, const Keyframe& to, double radius_m) noexcept {
  return (to.p_S - from.p_S).norm() + radius_m * from.turn.angularDistance(to.turn);
}

KeyframeMotion::KeyframeMotion(const Vec3& pivot_S, std::vector<Keyframe> keyframes, bool loops)
    : pivot_S_(pivot_S), keyframes_(std::move(keyframes)), loops_(loops) {}

Pose KeyframeMotion::pose_at(double time_s) const noexcept {
  const double time = loops_ && time_s > 0.0 ? std::fmod(time_s, duration_s()) : time_s;
  const auto later = [](double t, const Keyframe& one) { return t < one.time_s; };
  const auto after = std::upper_bound(keyframes_.begin(), keyframes_.end(), time, later);
  if (after == keyframes_.begin()) return pose_of(keyframes_.front(), pivot_S_);
  if (after == keyframes_.end()) return pose_of(keyframes_.back(), pivot_S_);
  const Keyframe& from = *(after - 1);
  return pose_of(keyframe_between(from, *after, (time - from.time_s) / (after->time_s - from.time_s)), pivot_S_);
}

double KeyframeMotion::fastest_m_per_s(std::size_t i, double radius_m) const {
  const Keyframe& from = keyframes_[i];
  const Keyframe& to = keyframes_[i + 1];
  return most_travel_m(from, to, radius_m) / (to.time_s - from.time_s);
}

}  // namespace hapton
