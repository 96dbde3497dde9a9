#include "core/effects/snap_effect.h"

#include <gtest/gtest.h>

#include "tests/core/effects/effect_paths.h"

namespace hapton {
namespace {

const Vec3 kSnapDirection = Vec3(1, 2, 2) / 3.0;

SnapEffect snap_to(SnapEffect::Target target) {
  return {.target = target, .position = {0.01, 0, 0}, .direction = kSnapDirection, .range_m = 0.02, .max_force_n = 1.5};
}

// The device point at `distance` from the target, somewhere along it; `outward` is the direction away from the target.
Vec3 device_point_at(SnapEffect::Target target, double distance, Vec3& outward) {
  const Vec3 across = kSnapDirection.cross(Vec3::UnitX()).normalized();
  outward = target == SnapEffect::Target::plane ? kSnapDirection : across;
  const Vec3 along = target == SnapEffect::Target::plane  ? across
                     : target == SnapEffect::Target::line ? kSnapDirection
                                                          : Vec3(Vec3::Zero());
  return Vec3(0.01, 0, 0) + 0.3 * along + distance * outward;
}

TEST(SnapEffect, PullsOntoPointLineAndPlaneByItsFormula) {
  for (const auto target : {SnapEffect::Target::point, SnapEffect::Target::line, SnapEffect::Target::plane}) {
    const SnapEffect snap = snap_to(target);
    for (const double u : {0.0, 0.1, 0.25, 0.5, 0.9, 1.1}) {
      Vec3 outward;
      const Vec3 p = device_point_at(target, u * 0.02, outward);
      const double expected = u < 1.0 ? 1.5 * 4.0 * u * (1.0 - u) : 0.0;
      EXPECT_LT((snap.force({.p_SD = p}) + expected * outward).norm(), 1e-12) << u;
      EXPECT_LT((snap.force({.p_SD = device_point_at(target, -u * 0.02, outward)}) - expected * outward).norm(), 1e-12) << u;
    }
  }
}

TEST(SnapEffect, GivesNoEnergyOverAClosedPath) {
  for (const auto target : {SnapEffect::Target::point, SnapEffect::Target::line, SnapEffect::Target::plane}) {
    const SnapEffect snap = snap_to(target);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const paths::Work work =
          paths::work_along(paths::closed(seed, 20000, {0.01, 0, 0.005}, 0.04), [&](const Vec3& p) { return snap.force({.p_SD = p}); });
      EXPECT_LT(std::abs(work.net_j), 1e-5 * work.absolute_j) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace hapton
