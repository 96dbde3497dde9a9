#pragma once

#include <cmath>

#include "core/effects/bounded_force.h"
#include "core/effects/effect_sample.h"

namespace hapton {

// A surface that holds on to the device, like a magnet or wet glue: once it has been touched, F = -k h n, h the height of the device above
// the plane of the last contact and n its normal, until h exceeds range_m or the device is kReach ranges away along the plane. The surface
// must be touched again before it pulls again. Frame: S. Units: SI. RT: yes. Bound: stiffness_n_per_m range_m. Passivity: dissipative: a
// spring that begins without tension and loses it where it releases.
struct SurfaceSnap {
  static constexpr Passivity kPassivity = Passivity::dissipative;
  // A hand that slides just above the surface comes into contact again within a few milliseconds, because the snap pulls it down. This
  // reach gives it room for that; farther away the plane says little about a curved surface. A free choice.
  static constexpr double kReach = 4.0;

  struct State {
    bool holds = false;
    Vec3 p_SP = Vec3::Zero();
    Vec3 normal = Vec3::Zero();  // unit
  };

  double stiffness_n_per_m = 300.0;
  double range_m = 0.0;  // 0: off

  bool is_on() const noexcept { return range_m > 0.0; }
  double bound_n() const noexcept { return stiffness_n_per_m * range_m; }

  // To be called while the surface is touched: sets the plane that attracts.
  static void touch(const Vec3& p_SP, const Vec3& normal, State& state) noexcept {
    state = {.holds = true, .p_SP = p_SP, .normal = normal};
  }

  // The force on a device that has left the surface.
  Vec3 force(const EffectSample& sample, State& state) const noexcept {
    if (!state.holds) return Vec3::Zero();
    const Vec3 from = sample.p_SD - state.p_SP;
    const double height = from.dot(state.normal);
    const double along_squared = from.squaredNorm() - height * height;
    state.holds = height <= range_m && along_squared <= kReach * kReach * range_m * range_m;
    if (!state.holds || !(height > 0.0)) return Vec3::Zero();
    return bounded_force(-stiffness_n_per_m * height * state.normal, bound_n());
  }
};

}  // namespace hapton
