#include "closed_loop/zwidth.h"

#include <numbers>

namespace hapton {

PassivityCase make_passivity_case(const ZWidthCase& loop) noexcept {
  const double amplifier_s = loop.device.amplifier_hz > 0.0 ? 1.0 / (2.0 * std::numbers::pi * loop.device.amplifier_hz) : 0.0;
  return {.period_s = 1.0 / loop.rate_hz,
          .delay_s = loop.delay_s,
          .damping_ns_per_m = loop.device.damping_ns_per_m,
          .amplifier_s = amplifier_s,
          .friction_n = loop.device.friction_n,
          .encoder_step_m = loop.device.encoder_step_m,
          .wall_damping_ns_per_m = loop.wall_damping_ns_per_m};
}

ZWidth find_zwidth(const ZWidthCase& loop) {
  const PassivityCase passivity = make_passivity_case(loop);
  const SampledPlant plant(make_axis_plant(loop.device, loop.hand), passivity.period_s, loop.delay_s);
  ZWidth width;
  width.stiffness = find_stable_stiffness(plant, loop.wall_damping_ns_per_m);
  width.damping_ns_per_m = find_stable_damping(plant, 0.0);
  width.viscosity_ns_per_m = find_stable_viscosity(plant);
  width.mass_kg = find_stable_mass(plant, loop.mass_filter_s);
  width.passive = find_passive_stiffness(passivity);
  width.passive_damping_ns_per_m = passive_damping_ns_per_m(passivity);
  width.linear_rule_n_per_m =
      linear_rule_n_per_m(loop.device.damping_ns_per_m + loop.hand.damping_ns_per_m, passivity.period_s, loop.delay_s);
  return width;
}

}  // namespace hapton
