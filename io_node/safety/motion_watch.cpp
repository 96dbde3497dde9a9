#include "io_node/safety/motion_watch.h"

#include <cmath>

namespace hapton {
namespace {

constexpr double kFarthestM = 1e6;
constexpr double kUnit = 1e-3;

// NaN fails every comparison.
bool is_pose(const DeviceSample& sample) {
  return sample.p_WD.cwiseAbs().maxCoeff() <= kFarthestM && sample.p_WD.allFinite() &&
         std::abs(sample.q_WT.squaredNorm() - 1.0) <= 2.0 * kUnit;
}

}  // namespace

MotionWatch::Verdict MotionWatch::look(const DeviceSample& sample, std::int64_t time_ns, double max_speed_m_per_s) noexcept {
  moved_m_ = Vec3::Zero();
  q_WT_before_ = q_WT_;
  if (!is_pose(sample)) return Verdict::no_pose;
  const std::int64_t passed_ns = time_ns - time_ns_;
  const bool is_new = !has_begun_ || passed_ns > kGapNs;
  const bool knows_motion = has_begun_;
  const double passed_s = 1e-9 * static_cast<double>(passed_ns);
  const Vec3 moved_m = sample.p_WD - p_WD_;
  p_WD_ = sample.p_WD;
  q_WT_ = sample.q_WT;
  time_ns_ = time_ns;
  has_begun_ = true;
  if (!knows_motion) q_WT_before_ = q_WT_;
  if (is_new) {
    if (knows_motion) moved_m_ = moved_m;
    velocity_m_per_s_ = Vec3::Zero();
    speed_m_per_s_ = 0.0;
    return Verdict::fine;
  }
  if (moved_m.norm() > max_speed_m_per_s * passed_s + kJumpM) {
    q_WT_before_ = q_WT_;
    velocity_m_per_s_ = Vec3::Zero();
    speed_m_per_s_ = 0.0;
    return Verdict::jump;
  }
  moved_m_ = moved_m;
  velocity_m_per_s_ += (moved_m - velocity_m_per_s_ * passed_s) / (kSmoothS + passed_s);
  speed_m_per_s_ = velocity_m_per_s_.norm();
  return Verdict::fine;
}

// Small turns between two samples: 2 sin(angle / 2) for the angle.
Vec3 MotionWatch::turned_rad() const noexcept {
  const Quat turn = q_WT_ * q_WT_before_.conjugate();
  return std::copysign(2.0, turn.w()) * turn.vec();
}

}  // namespace hapton
