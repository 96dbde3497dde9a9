#pragma once

#include <cstdint>

#include "core/effects/bounded_force.h"
#include "core/effects/effect_sample.h"

namespace hapton {

// Pulls onto a point (a magnet), a line or a plane from within range_m. With q from the target's nearest point to the device and
// u = |q| / range: F = -max_force 4 u (1 - u) q / |q| for u < 1, else zero. It is continuous, zero on the target and at the range, and
// largest at half the range. Near the target it is a spring of 4 max_force / range. Frame: S. Units: SI. RT: yes. Bound: max_force_n.
// Passivity: conservative: the force depends on the distance to the target alone and points along the gradient of this distance.
struct SnapEffect {
  static constexpr Passivity kPassivity = Passivity::conservative;
  enum class Target : std::uint8_t { point, line, plane };

  Target target = Target::point;
  Vec3 position = Vec3::Zero();    // on the target
  Vec3 direction = Vec3::UnitZ();  // unit: along the line, or normal to the plane; a point has none
  double range_m = 0.02;           // > 0
  double max_force_n = 2.0;

  double bound_n() const noexcept { return max_force_n; }
  // The stiffness near the target, where it is largest.
  double stiffness_n_per_m() const noexcept { return 4.0 * max_force_n / range_m; }

  Vec3 force(const EffectSample& sample) const noexcept {
    const Vec3 q = from_target(sample.p_SD - position);
    const double u = q.norm() / range_m;
    if (!(u < 1.0)) return Vec3::Zero();
    return bounded_force((-stiffness_n_per_m() * (1.0 - u)) * q, max_force_n);
  }

 private:
  Vec3 from_target(const Vec3& from_position) const noexcept {
    if (target == Target::point) return from_position;
    const Vec3 along = from_position.dot(direction) * direction;
    return target == Target::plane ? along : Vec3(from_position - along);
  }
};

}  // namespace hapton
