#include "core/effects/gravity_well_effect.h"

#include <gtest/gtest.h>

#include "tests/core/effects/effect_paths.h"

namespace hapton {
namespace {

TEST(GravityWellEffect, IsStrongestAtItsRadius) {
  const GravityWellEffect well = {.centre = {0, 0.01, 0}, .radius_m = 0.02, .max_force_n = 1.2};
  EXPECT_EQ(well.force({.p_SD = {0, 0.01, 0}}), Vec3::Zero());
  EXPECT_LT((well.force({.p_SD = {0.02, 0.01, 0}}) - Vec3(-1.2, 0, 0)).norm(), 1e-12);
  for (const double r : {0.015, 0.019, 0.021, 0.03}) EXPECT_LT(well.force({.p_SD = {0, 0.01, r}}).norm(), 1.2);
  // Far away the force is G / r^2, G = c max_force 2 radius^2, c = 1.5 sqrt(3).
  const double far = 100.0;
  EXPECT_NEAR(well.force({.p_SD = {far, 0.01, 0}}).x() * far * far, -1.2 * 1.5 * std::sqrt(3.0) * 2.0 * 0.02 * 0.02, 1e-9);
}

TEST(GravityWellEffect, GivesNoEnergyOverAClosedPath) {
  const GravityWellEffect well = {.centre = {0, 0.01, 0}, .radius_m = 0.02, .max_force_n = 1.2};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const paths::Work work =
        paths::work_along(paths::closed(seed, 20000, {0.01, 0, 0}, 0.05), [&](const Vec3& p) { return well.force({.p_SD = p}); });
    EXPECT_LT(std::abs(work.net_j), 1e-5 * work.absolute_j) << "seed " << seed;
  }
}

}  // namespace
}  // namespace hapton
