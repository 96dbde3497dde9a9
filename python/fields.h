#pragma once

#include <cstddef>
#include <variant>
#include <vector>

#include "core/effects/bounded_force.h"
#include "core/effects/constant_effect.h"
#include "core/effects/mass_effect.h"
#include "core/effects/sampled_motion.h"
#include "core/effects/spring_effect.h"
#include "core/effects/viscous_effect.h"
#include "core/effects/wave_effect.h"
#include "python/expression_field.h"

namespace hapton::python {

// A wall: the half-space behind a plane pushes out, F = (k depth - b v . n) n, never inwards. Frame: W. Units: SI. RT: yes. Bound:
// max_force_n.
struct WallField {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitY();  // unit, to the free side
  double stiffness_n_per_m = 800.0;
  double damping_ns_per_m = 0.0;
  double max_force_n = 5.0;

  Vec3 force(const EffectSample& hand) const noexcept {
    const double depth_m = (point - hand.p_SD).dot(normal);
    if (!(depth_m > 0.0)) return Vec3::Zero();
    return std::clamp(stiffness_n_per_m * depth_m - damping_ns_per_m * hand.v_SD.dot(normal), 0.0, max_force_n) * normal;
  }
};

// A channel along a line: a spring and a damper act across the line, none along it. Frame: W. Units: SI. RT: yes. Bound: max_force_n.
struct ChannelField {
  Vec3 point = Vec3::Zero();
  Vec3 direction = Vec3::UnitX();  // unit
  double stiffness_n_per_m = 400.0;
  double damping_ns_per_m = 0.0;
  double max_force_n = 5.0;

  Vec3 force(const EffectSample& hand) const noexcept {
    const auto aside = [&](const Vec3& v) { return Vec3(v - v.dot(direction) * direction); };
    return bounded_force(-stiffness_n_per_m * aside(hand.p_SD - point) - damping_ns_per_m * aside(hand.v_SD), max_force_n);
  }
};

// A perturbation: a half sine of force that begins delay_s after the fields were set. Frame: W. Units: SI. RT: yes. Bound: |force_n|.
struct PulseField {
  Vec3 force_n = Vec3::Zero();
  double duration_s = 0.1;
  double delay_s = 0.0;

  Vec3 force(const EffectSample& hand) const noexcept {
    const double share = (hand.time_s - delay_s) / duration_s;
    if (!(share > 0.0 && share < 1.0)) return Vec3::Zero();
    return std::sin(3.14159265358979323846 * share) * force_n;
  }
};

// A virtual mass (core/effects/mass_effect.h), which remembers its velocity: at rest when the fields are set. RT: yes.
struct MassField {
  MassEffect law;
  MassEffect::State state = {};

  Vec3 force(const EffectSample& hand) noexcept { return law.force(hand, state); }
};

using Field =
    std::variant<SpringEffect, ViscousEffect, ConstantEffect, WaveEffect, WallField, ChannelField, PulseField, MassField, ExpressionField>;

// The sum of several fields at each sample of a device, with the time and the velocity that they need. RT: step yes. Threads: one.
class FieldLaw {
 public:
  FieldLaw() = default;
  explicit FieldLaw(std::vector<Field> fields) : fields_(std::move(fields)) {}

  // A sample that is not finite gives no force; time goes on. dt_s: as in SampledMotion::add; when the clock steps back, time stands still.
  Vec3 step(const Vec3& p_WD, double dt_s) noexcept;
  const Vec3& velocity_m_per_s() const noexcept { return motion_.velocity(); }
  // Takes over the motion so far of the law before. The time of this law begins now.
  void take_motion(const FieldLaw& before) noexcept { motion_ = before.motion_; }

 private:
  std::vector<Field> fields_;
  SampledMotion motion_;
  double time_s_ = 0.0;
};

}  // namespace hapton::python
