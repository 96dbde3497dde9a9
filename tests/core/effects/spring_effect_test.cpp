#include "core/effects/spring_effect.h"

#include <gtest/gtest.h>

#include "tests/core/effects/effect_paths.h"

namespace hapton {
namespace {

TEST(SpringEffect, FollowsHooke) {
  const SpringEffect spring = {.centre = {0.01, 0, 0}, .stiffness_n_per_m = 50, .max_force_n = 2};
  EXPECT_LT((spring.force({.p_SD = {0.03, 0.01, -0.02}}) - Vec3(-1.0, -0.5, 1.0)).norm(), 1e-12);
  EXPECT_EQ(spring.force({.p_SD = {0.01, 0, 0}}), Vec3::Zero());
  EXPECT_LT((spring.force({.p_SD = {1.01, 0, 0}}) - Vec3(-2.0, 0, 0)).norm(), 1e-12) << "at its largest force";
}

TEST(SpringEffect, GivesNoEnergyOverAClosedPath) {
  const SpringEffect spring = {.centre = {0.01, 0, 0}, .stiffness_n_per_m = 50, .max_force_n = 0.6};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const paths::Work work =
        paths::work_along(paths::closed(seed, 20000, {0.0, 0.01, 0}, 0.04), [&](const Vec3& p) { return spring.force({.p_SD = p}); });
    EXPECT_LT(std::abs(work.net_j), 1e-5 * work.absolute_j) << "seed " << seed;
  }
}

}  // namespace
}  // namespace hapton
