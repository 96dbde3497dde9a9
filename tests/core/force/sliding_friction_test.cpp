#include "core/force/sliding_friction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace hapton {
namespace {

// The definition: return mapping in many small steps.
FrictionDrag map_back(const FrictionMotion& input, int steps) {
  FrictionDrag now{input.pull, input.sliding};
  for (int i = 1; i <= steps; ++i) {
    const double pressure = input.pressure_start + (input.pressure_end - input.pressure_start) * i / steps;
    now.pull += input.motion / steps;
    const double length = now.pull.norm();
    const double limit = (now.sliding ? input.friction_dynamic : input.friction_static) * pressure;
    if (length <= limit) {
      now.sliding = now.sliding && length >= FrictionMotion::kRestick * input.friction_dynamic * pressure;
      continue;
    }
    now.pull *= input.friction_dynamic * pressure / length;
    now.sliding = true;
  }
  return now;
}

TEST(FrictionDrag, SticksInsideTheCone) {
  const FrictionDrag dragged = drag_by_friction({.pull = Vec3(0.1, 0, 0),
                                                 .motion = Vec3(0.2, 0.1, 0),
                                                 .pressure_start = 1.0,
                                                 .pressure_end = 2.0,
                                                 .friction_static = 0.5,
                                                 .friction_dynamic = 0.4,
                                                 .sliding = false});
  EXPECT_NEAR((dragged.pull - Vec3(0.3, 0.1, 0)).norm(), 0.0, 1e-15);
  EXPECT_FALSE(dragged.sliding);
}

TEST(FrictionDrag, StraightAheadThePullIsTheCone) {
  const FrictionDrag dragged = drag_by_friction({.pull = Vec3::Zero(),
                                                 .motion = Vec3(3, 0, 0),
                                                 .pressure_start = 1.0,
                                                 .pressure_end = 1.0,
                                                 .friction_static = 0.5,
                                                 .friction_dynamic = 0.3,
                                                 .sliding = false});
  EXPECT_NEAR((dragged.pull - Vec3(0.3, 0, 0)).norm(), 0.0, 1e-15);
  EXPECT_TRUE(dragged.sliding);
}

// The classical tractrix: a pull of length 1 perpendicular to the motion has turned by tan(psi / 2) = exp(-s) after a distance s.
TEST(FrictionDrag, AcrossTheMotionItIsTheTractrix) {
  for (const double distance : {0.001, 0.1, 1.0, 5.0}) {
    const FrictionDrag dragged = drag_by_friction({.pull = Vec3(0, 1, 0),
                                                   .motion = Vec3(distance, 0, 0),
                                                   .pressure_start = 1.0,
                                                   .pressure_end = 1.0,
                                                   .friction_static = 1.0,
                                                   .friction_dynamic = 1.0,
                                                   .sliding = true});
    EXPECT_NEAR(dragged.pull.x(), std::tanh(distance), 1e-14);
    EXPECT_NEAR(dragged.pull.y(), 1.0 / std::cosh(distance), 1e-14);
  }
}

TEST(FrictionDrag, IsTheLimitOfReturnMapping) {
  const std::uint64_t seed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::normal_distribution<double> normal;
  int sliding_trials = 0, sticking_trials = 0;
  double sum_coarse = 0.0, sum_fine = 0.0;
  for (int trial = 0; trial < 400; ++trial) {
    FrictionMotion input;
    input.pressure_start = 0.2 + share(random);
    input.pressure_end = 0.2 + share(random);
    input.friction_dynamic = 0.05 + 0.6 * share(random);
    input.friction_static = trial % 2 == 0 ? input.friction_dynamic : input.friction_dynamic * (1.0 + share(random));
    input.sliding = trial % 3 == 0;
    const double cone = input.pressure_start * (input.sliding ? input.friction_dynamic : input.friction_static);
    input.pull = Vec3(normal(random), normal(random), 0.0).normalized() * cone * (input.sliding ? 1.0 : share(random));
    input.motion = 0.5 * Vec3(normal(random), normal(random), 0.0);
    const FrictionDrag exact = drag_by_friction(input);
    const double coarse = (map_back(input, 2000).pull - exact.pull).norm();
    const double fine = (map_back(input, 20000).pull - exact.pull).norm();
    EXPECT_LT(fine, 2e-4) << trial;
    sum_coarse += coarse;
    sum_fine += fine;
    EXPECT_EQ(exact.sliding, map_back(input, 20000).sliding) << trial;
    sliding_trials += exact.sliding ? 1 : 0;
    sticking_trials += exact.sliding ? 0 : 1;
  }
  EXPECT_LT(sum_fine, 0.11 * sum_coarse);  // first order: ten times the steps, a tenth of the error
  EXPECT_GT(sliding_trials, 100);
  EXPECT_GT(sticking_trials, 40);
}

TEST(FrictionDrag, IsTheSameInAnyUnit) {
  const FrictionMotion input{.pull = Vec3(0.1, 0.2, 0),
                             .motion = Vec3(0.7, -0.3, 0),
                             .pressure_start = 1.0,
                             .pressure_end = 1.5,
                             .friction_static = 0.4,
                             .friction_dynamic = 0.3,
                             .sliding = false};
  FrictionMotion small = input;
  small.pull *= 0x1p-40;
  small.motion *= 0x1p-40;
  small.pressure_start *= 0x1p-40;
  small.pressure_end *= 0x1p-40;
  EXPECT_EQ(drag_by_friction(small).pull, Vec3(0x1p-40 * drag_by_friction(input).pull));
}

TEST(FrictionDrag, WithoutDynamicFrictionASlidingProxyHasNoPull) {
  const FrictionDrag dragged = drag_by_friction({.pull = Vec3::Zero(),
                                                 .motion = Vec3(3, 0, 0),
                                                 .pressure_start = 1.0,
                                                 .pressure_end = 1.0,
                                                 .friction_static = 0.5,
                                                 .friction_dynamic = 0.0,
                                                 .sliding = false});
  EXPECT_TRUE(dragged.pull.isZero(0.0));
}

}  // namespace
}  // namespace hapton
