#include "core/effects/surface_bumps.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace hapton {
namespace {

TEST(SurfaceBumps, RidgesFollowTheirFormula) {
  const SurfaceBumps ridges = {.pattern = SurfaceBumps::Pattern::ridges, .height_m = 1e-3, .length_m = 4e-3, .direction = Vec3::UnitY()};
  EXPECT_NEAR(ridges.height_at({7, 0, 9}), 0.0, 1e-15) << "the crest";
  EXPECT_NEAR(ridges.height_at({7, 1e-3, 9}), -0.5e-3, 1e-15);
  EXPECT_NEAR(ridges.height_at({7, 2e-3, 9}), -1e-3, 1e-15) << "the trough";
  EXPECT_LT((ridges.gradient_at({7, 1e-3, 9}) - Vec3(0, -ridges.slope(), 0)).norm(), 1e-12) << "steepest half way";
}

TEST(SurfaceBumps, TheGradientIsThatOfTheHeight) {
  constexpr std::uint64_t kSeed = 3;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const auto pattern : {SurfaceBumps::Pattern::ridges, SurfaceBumps::Pattern::grid}) {
    const SurfaceBumps bumps = {.pattern = pattern, .height_m = 1e-3, .length_m = 4e-3, .direction = Vec3(1, 2, 2) / 3};
    for (int trial = 0; trial < 200; ++trial) {
      const Vec3 p = 0.1 * Vec3(unit(random), unit(random), unit(random));
      const Vec3 gradient = bumps.gradient_at(p);
      constexpr double kStep = 1e-7;
      for (int k = 0; k < 3; ++k) {
        const double slope = (bumps.height_at(p + kStep * Vec3::Unit(k)) - bumps.height_at(p - kStep * Vec3::Unit(k))) / (2 * kStep);
        EXPECT_NEAR(gradient[k], slope, 1e-6) << "seed " << kSeed;
      }
      EXPECT_LE(gradient.norm(), bumps.slope() * (1 + 1e-12)) << "seed " << kSeed;
      EXPECT_LE(bumps.height_at(p), 0.0);
      EXPECT_GE(bumps.height_at(p), -1e-3);
    }
  }
}

}  // namespace
}  // namespace hapton
