#include "core/force/force_fade.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace hapton {
namespace {

constexpr double kStepS = 1e-3;
const Vec3 kBefore(1.0, -2.0, 3.0);
const Vec3 kAfter(-1.0, 0.5, 4.0);

TEST(ForceFade, WithoutASwitchForcesPassToTheLastBit) {
  ForceFade fade;
  EXPECT_EQ(fade.step(kBefore, true, kStepS), kBefore);
  EXPECT_EQ(fade.step(kAfter, true, kStepS), kAfter);
  EXPECT_FALSE(fade.is_active());
}

TEST(ForceFade, TheDifferenceOnlyDecreasesAndIsZeroAfterItsTime) {
  for (const double step_s : {1e-4, kStepS, 4e-3, 0.05}) {
    SCOPED_TRACE(step_s);
    const double dt_s = std::min(step_s, ForceFade::kMaxStepS);
    ForceFade fade;
    fade.step(kBefore, true, step_s);
    fade.begin();
    Vec3 last = kBefore;
    const Vec3 difference = kBefore - kAfter;
    const int steps = static_cast<int>(ForceFade::kInContactS / dt_s) + 1;
    for (int i = 0; i < steps; ++i) {
      const Vec3 force = fade.step(kAfter, true, step_s);
      EXPECT_NEAR((last - force).dot(difference), (last - force).norm() * difference.norm(), 1e-12) << "straight towards the new force";
      EXPECT_LE((last - force).norm(), difference.norm() * dt_s / ForceFade::kInContactS + 1e-12);
      last = force;
    }
    EXPECT_EQ(last, kAfter);
    EXPECT_FALSE(fade.is_active());
  }
}

TEST(ForceFade, InTheAirItFadesTenTimesFasterAndContactDoesNotBringItBack) {
  ForceFade fade;
  fade.step(kBefore, true, kStepS);
  fade.begin();
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR((fade.step(Vec3::Zero(), false, kStepS) - (0.9 - 0.1 * i) * kBefore).norm(), 0.0, 1e-12);
    EXPECT_TRUE(fade.is_active());
  }
  // Half of the difference is left, and 0.01 of it fades in a step in contact.
  EXPECT_NEAR((fade.step(kAfter, true, kStepS) - kAfter - 0.49 * kBefore).norm(), 0.0, 1e-12);
  for (int i = 0; i < 6; ++i) fade.step(Vec3::Zero(), false, kStepS);
  EXPECT_EQ(fade.step(Vec3::Zero(), false, kStepS), Vec3::Zero());
  EXPECT_FALSE(fade.is_active());
}

TEST(ForceFade, AnotherSwitchWhileItFadesStartsAtThePresentForce) {
  ForceFade fade;
  fade.step(kBefore, true, kStepS);
  fade.begin();
  Vec3 last;
  for (int i = 0; i < 40; ++i) last = fade.step(kAfter, true, kStepS);
  fade.begin();
  EXPECT_NEAR((fade.step(kBefore, true, kStepS) - last).norm(), 0.01 * (kBefore - last).norm(), 1e-12);
}

TEST(ForceFade, ADifferenceThatIsNotFiniteIsLeftOut) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {inf, std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::max()}) {
    ForceFade fade;
    fade.step({bad, 0.0, 0.0}, true, kStepS);
    fade.begin();
    EXPECT_EQ(fade.step({std::numeric_limits<double>::max(), 0.0, 0.0}, true, kStepS), Vec3(std::numeric_limits<double>::max(), 0.0, 0.0));
    EXPECT_EQ(fade.step(kAfter, true, kStepS), kAfter);
  }
}

TEST(ForceFade, AKnownDifferenceFadesAndWhatTheMotionChangedDoesNot) {
  ForceFade fade;
  fade.step(kBefore, true, kStepS);
  const Vec3 difference(0.1, 0.0, -0.2);
  fade.begin_from(difference);
  EXPECT_NEAR((fade.step(kAfter, true, kStepS) - kAfter - 0.99 * difference).norm(), 0.0, 1e-12);
  // The rest of a fade that has not ended is kept.
  fade.begin_from(difference);
  EXPECT_NEAR((fade.step(kAfter, true, kStepS) - kAfter - 0.99 * 1.99 * difference).norm(), 0.0, 1e-12);
  for (int i = 0; i < 100; ++i) fade.step(kAfter, true, kStepS);
  fade.begin_from(Vec3::Zero());
  EXPECT_EQ(fade.step(kBefore, true, kStepS), kBefore);
}

TEST(ForceFade, AForgottenFadeAddsNoForce) {
  ForceFade fade;
  fade.step(kBefore, true, kStepS);
  fade.begin();
  fade.step(kAfter, true, kStepS);
  fade.forget();
  EXPECT_EQ(fade.step(kAfter, true, kStepS), kAfter);
}

}  // namespace
}  // namespace hapton
