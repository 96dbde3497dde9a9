#pragma once

#include <algorithm>

#include "safety/motion_monitor.h"

namespace hapton {

// Keeps forces from accelerating a fast device. Above kSoftShare of max_speed, the part of the force that pushes along the motion decreases
// and damping increases, both linearly; at max_speed that part is zero. From max_speed on (is_exceeded) the governor latches a fault. Frame
// W, SI units. RT: yes.
class SpeedLimit {
 public:
  // A choice: max_speed is about twice the speed of fast arm movements (model_a.h), so ordinary motion stays below the soft limit.
  static constexpr double kSoftShare = 0.6;

  static bool is_exceeded(const DeviceLimits& limits, double speed_m_per_s) noexcept { return speed_m_per_s >= limits.max_speed_m_per_s; }
  static bool is_soft(const DeviceLimits& limits, double speed_m_per_s) noexcept { return excess(limits, speed_m_per_s) > 0.0; }

  // 0 below the soft limit, 1 at max_speed.
  static double excess(const DeviceLimits& limits, double speed_m_per_s) noexcept {
    const double soft = kSoftShare * limits.max_speed_m_per_s;
    return std::clamp((speed_m_per_s - soft) / (limits.max_speed_m_per_s - soft), 0.0, 1.0);
  }

  // The force after both measures. damping_n_s_per_m: the damping at max_speed.
  static Vec3 limit_force(const DeviceLimits& limits, double damping_n_s_per_m, const Vec3& force_n, const MotionMonitor& motion) noexcept {
    const double share = excess(limits, motion.speed_m_per_s());
    if (share == 0.0) return force_n;
    const Vec3 along = motion.velocity_m_per_s() / motion.speed_m_per_s();
    const double pushing_n = std::max(0.0, force_n.dot(along));
    return force_n - (share * pushing_n) * along - (share * damping_n_s_per_m) * motion.velocity_m_per_s();
  }
};

}  // namespace hapton
