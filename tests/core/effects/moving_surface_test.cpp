// Effects of a surface that moves with its frame, or that deforms.
#include <gtest/gtest.h>

#include "core/effects/effect_step.h"

namespace hapton {
namespace {

constexpr double kStepOfFrame = 1e-3;  // s

// Contact with the surface y = 0 of the frame F at p_FD, which pushes along +y of F with 1 kN/m.
SurfaceContact pressed_in(const Pose& X_SF, const Vec3& p_FD) {
  return {
      .force_n = X_SF.linear() * Vec3(0, -1000.0 * p_FD.y(), 0), .p_SP = X_SF * Vec3(p_FD.x(), 0, p_FD.z()), .object = 0, .contact = true};
}

Pose turned_and_moved() { return Eigen::Translation3d(0.3, -0.2, 0.1) * Pose(Eigen::AngleAxisd(1.0, Vec3(1, 2, 3).normalized())); }

TEST(MovingSurface, ANeedleIsDrawnWhereItIsInTheScene) {
  SurfaceEffects skin;
  skin.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 500, .pop_force_n = 1.0});
  skin.layers.add({.depth_m = 0.01, .stiffness_n_per_m = 2000});
  EffectStep step({skin}, {}, {0});
  const Pose X_SF = turned_and_moved();
  const auto drawn_at = [&](double depth_m) {
    const Vec3 p_FD(0.02, -depth_m, 0.01);
    step.place({&X_SF, 1});
    return Vec3(X_SF.inverse(Eigen::Isometry) * step.step(X_SF * p_FD, kStepOfFrame, pressed_in(X_SF, p_FD)).p_SP);
  };
  EXPECT_LT((drawn_at(0.0018) - Vec3(0.02, 0, 0.01)).norm(), 1e-12) << "on the skin";
  EXPECT_LT((drawn_at(0.0025) - Vec3(0.02, -0.0025, 0.01)).norm(), 1e-12) << "through it";
  EXPECT_LT((drawn_at(0.011) - Vec3(0.02, -0.01, 0.01)).norm(), 1e-12) << "on the bone";
}

// The touched point moves along with the hand by `share` of its motion: with 1, the hand rests on the surface.
TEST(MovingSurface, AHandThatGoesAlongWithWhatDeformsIsNotSlowed) {
  const SurfaceEffects thick{.viscosity = {.damping_ns_per_m = 4}};
  const Pose X_SF = turned_and_moved();
  for (const double share : {0.0, 0.5, 1.0}) {
    EffectStep step({thick}, {}, {0});
    Vec3 force_n;
    for (int n = 0; n < 40; ++n) {
      const Vec3 p_FD(1e-4 * n, -2e-3, 0.0);
      SurfacePlace place;
      place.moved = Vec3(n > 0 ? share * 1e-4 : 0.0, 0, 0);
      SurfaceContact contact = pressed_in(X_SF, p_FD);
      contact.place = &place;
      step.place({&X_SF, 1});
      force_n = X_SF.linear().transpose() * step.step(X_SF * p_FD, kStepOfFrame, contact).force_n;
    }
    EXPECT_LT((force_n - Vec3(-4.0 * (1.0 - share) * 0.1, 2.0, 0)).norm(), 1e-9) << share;
  }
}

// While a tool is held, the frames are not placed. The hand's motion until they are placed again is not a velocity relative to them.
TEST(MovingSurface, AFrameIsNotFollowedWhileNobodyPlacesIt) {
  const SurfaceEffects thick{.viscosity = {.damping_ns_per_m = 4}};
  const Pose X_SF = turned_and_moved();
  for (const bool is_placed : {true, false}) {
    EffectStep step({thick}, {}, {0});
    const auto force_at = [&](const Vec3& p_FD) {
      step.place({&X_SF, 1});
      return Vec3(X_SF.linear().transpose() * step.step(X_SF * p_FD, kStepOfFrame, pressed_in(X_SF, p_FD)).force_n);
    };
    (void)force_at({0.0, -2e-3, 0.0});
    const Vec3 moved(4e-4, -2e-3, 0.0);
    if (!is_placed) {
      for (int n = 1; n < 4; ++n) (void)step.step_in_space(X_SF * Vec3(1e-4 * n, -2e-3, 0.0), kStepOfFrame);
    }
    const double sideways_n = force_at(moved).x();
    if (is_placed) {
      EXPECT_LT(sideways_n, -0.1);
    } else {
      EXPECT_NEAR(sideways_n, 0.0, 1e-9);
    }
  }
}

}  // namespace
}  // namespace hapton
