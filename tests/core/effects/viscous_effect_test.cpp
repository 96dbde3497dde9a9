#include "core/effects/viscous_effect.h"

#include <gtest/gtest.h>

#include "core/effects/smooth_velocity.h"
#include "tests/core/effects/effect_paths.h"

namespace hapton {
namespace {

TEST(ViscousEffect, OpposesTheVelocityWithinItsVolume) {
  const ViscousEffect honey = {.damping_ns_per_m = 4, .max_force_n = 1, .volume = EffectVolume::ball(Vec3::Zero(), 0.01)};
  EXPECT_LT((honey.force({.p_SD = Vec3::Zero(), .v_SD = {0.1, 0, -0.05}}) - Vec3(-0.4, 0, 0.2)).norm(), 1e-15);
  EXPECT_LT((honey.force({.p_SD = Vec3::Zero(), .v_SD = {0, 7, 0}}) - Vec3(0, -1, 0)).norm(), 1e-15) << "at its largest force";
  EXPECT_EQ(honey.force({.p_SD = {0.02, 0, 0}, .v_SD = {0.1, 0, 0}}), Vec3::Zero());
}

// Sampled at 1 kHz, with the velocity that EffectStep gives the effect (SmoothVelocity).
TEST(ViscousEffect, TakesEnergyOverAClosedPath) {
  const ViscousEffect honey = {.damping_ns_per_m = 4, .max_force_n = 50};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto path = paths::closed(seed, 1000, Vec3::Zero(), 0.04);
    SmoothVelocity velocity;
    double energy_to_hand_j = 0.0;
    Vec3 last = path[0];
    velocity.add(last, 1e-3);
    for (std::size_t i = 1; i <= path.size(); ++i) {
      const Vec3& p = path[i % path.size()];
      velocity.add(p, 1e-3);
      energy_to_hand_j += honey.force({.p_SD = p, .v_SD = velocity.mean()}).dot(p - last);
      last = p;
    }
    EXPECT_LT(energy_to_hand_j, 0.0) << "seed " << seed;
  }
}

}  // namespace
}  // namespace hapton
