#include "core/math/keyframe_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapton {

KeyframeMotion::KeyframeMotion(const Vec3& pivot_S, std::vector<Keyframe> keyframes, bool loops)
    : pivot_S_(pivot_S), keyframes_(std::move(keyframes)), loops_(loops) {}

Pose KeyframeMotion::pose_at(double time_s) const noexcept {
  const double time = loops_ && time_s > 0.0 ? std::fmod(time_s, duration_s()) : time_s;
  const auto later = [](double t, const Keyframe& one) { return t < one.time_s; };
  const auto after = std::upper_bound(keyframes_.begin(), keyframes_.end(), time, later);
  const Keyframe& to = after == keyframes_.end() ? keyframes_.back() : *after;
  const Keyframe& from = after == keyframes_.begin() ? keyframes_.front() : *(after - 1);
  const double length = to.time_s - from.time_s;
  const double share = length > 0.0 ? (time - from.time_s) / length : 0.0;
  // At rest between two equal keyframes, to the last bit.
  const Vec3 p = from.p_S + share * (to.p_S - from.p_S);
  const Quat turn = from.turn.coeffs() == to.turn.coeffs() ? from.turn : from.turn.slerp(share, to.turn).normalized();
  Pose X_SO = Pose::Identity();
  X_SO.linear() = turn.toRotationMatrix();
  X_SO.translation() = p - X_SO.linear() * pivot_S_;
  return X_SO;
}

double KeyframeMotion::fastest_m_per_s(std::size_t i, double radius_m) const {
  const Keyframe& from = keyframes_[i];
  const Keyframe& to = keyframes_[i + 1];
  const double way = (to.p_S - from.p_S).norm() + radius_m * from.turn.angularDistance(to.turn);
  return way / (to.time_s - from.time_s);
}

}  // namespace hapton
