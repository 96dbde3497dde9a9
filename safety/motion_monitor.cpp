#include "safety/motion_monitor.h"

#include <cmath>
#include <utility>

namespace hapton {
namespace {

constexpr double kFarthestM = 1e6;  // farther than any device reaches; its square is finite
constexpr double kUnit = 1e-3;      // tolerance of the length of a unit quaternion, as on the link (kUnitTolerance)

// False if a number is NaN, which fails every comparison.
bool is_pose(const DeviceSample& sample) {
  return sample.p_WD.cwiseAbs().maxCoeff() <= kFarthestM && sample.p_WD.allFinite() &&
         std::abs(sample.q_WT.squaredNorm() - 1.0) <= 2.0 * kUnit;
}

// Rotation vector; its length is 2 sin(angle / 2), which is the angle for small rotations.
Vec3 turn_between(const Quat& from, const Quat& to) {
  const Quat turn = to * from.conjugate();
  return std::copysign(2.0, turn.w()) * turn.vec();
}

}  // namespace

void MotionMonitor::set_at_rest() noexcept {
  velocity_m_per_s_ = Vec3::Zero();
  speed_m_per_s_ = 0.0;
}

MotionMonitor::Verdict MotionMonitor::update(const DeviceSample& sample, std::int64_t time_ns, double max_speed_m_per_s,
                                             bool has_torque) noexcept {
  moved_m_ = turned_rad_ = Vec3::Zero();
  if (!is_pose(sample)) return Verdict::invalid_pose;
  const bool knows_motion = std::exchange(has_begun_, true);
  const std::int64_t passed_ns = time_ns - std::exchange(time_ns_, time_ns);
  const double passed_s = 1e-9 * static_cast<double>(passed_ns);
  const Vec3 moved_m = sample.p_WD - std::exchange(p_WD_, sample.p_WD);
  const Quat before = std::exchange(q_WT_, sample.q_WT);
  if (!knows_motion) {
    set_at_rest();
    return Verdict::fine;
  }
  const Vec3 turned_rad = has_torque ? turn_between(before, q_WT_) : Vec3(Vec3::Zero());
  if (passed_ns >= kGapNs) {
    set_at_rest();
  } else if (moved_m.norm() > max_speed_m_per_s * passed_s + kJumpM || turned_rad.norm() > kFastestTurnRadPerS * passed_s + kJumpRad) {
    set_at_rest();
    return Verdict::jump;
  } else {
    velocity_m_per_s_ += (moved_m - velocity_m_per_s_ * passed_s) / (kSmoothS + passed_s);
    speed_m_per_s_ = velocity_m_per_s_.norm();
  }
  moved_m_ = moved_m;
  turned_rad_ = turned_rad;
  return Verdict::fine;
}

}  // namespace hapton
