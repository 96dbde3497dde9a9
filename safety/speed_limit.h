#pragma once

#include <algorithm>

#include "safety/motion_monitor.h"

namespace hapton {

// Prevents forces from accelerating a fast device: above kSoftShare of max_speed, force along the motion fades and damping rises. At
// max_speed there is no force along the motion; a device above it is out of control (is_exceeded). RT: yes.
class SpeedLimit {
 public:
  // A choice: max_speed is about twice what an arm does in earnest (model_a.h), so ordinary motion stays below it.
  static constexpr double kSoftShare = 0.6;

  static bool is_exceeded(const DeviceLimits& limits, double speed_m_per_s) noexcept { return speed_m_per_s >= limits.max_speed_m_per_s; }
  static bool is_soft(const DeviceLimits& limits, double speed_m_per_s) noexcept { return excess(limits, speed_m_per_s) > 0.0; }

  // 0 below the soft limit, 1 at max_speed.
  static double excess(const DeviceLimits& limits, double speed_m_per_s) noexcept {
    const double soft = kSoftShare * limits.max_speed_m_per_s;
    return std::clamp((speed_m_per_s - soft) / (limits.max_speed_m_per_s - soft), 0.0, 1.0);
  }

  static Vec3 limit_force(const DeviceLimits& limits, double damping_n_s_per_m, const Vec3& force_n, const MotionMonitor& motion) noexcept {
    const double share = excess(limits, motion.speed_m_per_s());
    if (share == 0.0) return force_n;
    const Vec3 along = motion.velocity_m_per_s() / motion.speed_m_per_s();
    const double pushing_n = std::max(0.0, force_n.dot(along));
    return force_n - (share * pushing_n) * along - (share * damping_n_s_per_m) * motion.velocity_m_per_s();
  }
};

}  // namespace hapton
