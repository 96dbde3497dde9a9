#include "core/effects/snap_effect.h"

#include <gtest/gtest.h>

#include "tests/core/effects/effect_paths.h"

namespace hapton {
namespace {

const Vec3 kAlong = Vec3(1, 2, 2) / 3.0;

SnapEffect made(SnapEffect::Target target) {
  return {.target = target, .position = {0.01, 0, 0}, .direction = kAlong, .range_m = 0.02, .max_force_n = 1.5};
}

// The device at distance `away` from the target, somewhere along it.
Vec3 away_from(SnapEffect::Target target, double away, Vec3& outward) {
  const Vec3 across = kAlong.cross(Vec3::UnitX()).normalized();
  outward = target == SnapEffect::Target::plane ? kAlong : across;
  const Vec3 along = target == SnapEffect::Target::plane ? across : target == SnapEffect::Target::line ? kAlong : Vec3(Vec3::Zero());
  return Vec3(0.01, 0, 0) + 0.3 * along + away * outward;
}

TEST(SnapEffect, PullsOntoPointLineAndPlaneByItsFormula) {
  for (const auto target : {SnapEffect::Target::point, SnapEffect::Target::line, SnapEffect::Target::plane}) {
    const SnapEffect snap = made(target);
    for (const double u : {0.0, 0.1, 0.25, 0.5, 0.9, 1.1}) {
      Vec3 outward;
      const Vec3 p = away_from(target, u * 0.02, outward);
      const double expected = u < 1.0 ? 1.5 * 4.0 * u * (1.0 - u) : 0.0;
      EXPECT_LT((snap.force({.p_SD = p}) + expected * outward).norm(), 1e-12) << u;
      EXPECT_LT((snap.force({.p_SD = away_from(target, -u * 0.02, outward)}) - expected * outward).norm(), 1e-12) << u;
    }
  }
}

TEST(SnapEffect, GivesNoEnergyOverAClosedPath) {
  for (const auto target : {SnapEffect::Target::point, SnapEffect::Target::line, SnapEffect::Target::plane}) {
    const SnapEffect snap = made(target);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const paths::Work work =
          paths::around(paths::closed(seed, 20000, {0.01, 0, 0.005}, 0.04), [&](const Vec3& p) { return snap.force({.p_SD = p}); });
      EXPECT_LT(std::abs(work.net_j), 1e-5 * work.absolute_j) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace hapton
