#include "core/effects/tilted_spring.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <random>

namespace hapton {
namespace {

double largest_eigenvalue(const Mat3& matrix) {
  return Eigen::SelfAdjointEigenSolver<Mat3>(0.5 * (matrix + matrix.transpose()), Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

TEST(TiltedSpring, IsTheLargestEigenvalueWhereGradientAndCurvatureAgree) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int n = 0; n < 1000; ++n) {
    const double scale = std::pow(10.0, 12.0 * unit(random) - 6.0);
    const TiltedSpring spring{.spring_n_per_m = scale * unit(random),
                              .slope_squared = unit(random),
                              .bending_n_per_m = scale * 3.0 * unit(random),
                              .sideways_n_per_m = scale * unit(random)};
    const Vec3 v(-std::sqrt(spring.slope_squared), 0, 1);
    Mat3 k = spring.spring_n_per_m * v * v.transpose();
    k(0, 0) += spring.bending_n_per_m + spring.sideways_n_per_m;
    k(1, 1) += spring.sideways_n_per_m;
    EXPECT_NEAR(spring.largest_n_per_m(), largest_eigenvalue(k), 1e-12 * scale) << "seed 7, sample " << n;
  }
}

TEST(TiltedSpring, WithoutBumpsItIsTheStifferOfTheTwoSprings) {
  EXPECT_DOUBLE_EQ((TiltedSpring{.spring_n_per_m = 700.0}.largest_n_per_m()), 700.0);
  EXPECT_DOUBLE_EQ((TiltedSpring{.spring_n_per_m = 700.0, .sideways_n_per_m = 900.0}.largest_n_per_m()), 900.0);
  EXPECT_EQ(TiltedSpring().largest_n_per_m(), 0.0);
}

// In the valley of a ridge almost all of the stiffness is f times the curvature 2 pi^2 height / length^2.
TEST(TiltedSpring, ShortRidgesAreAsStiffAsTheirCurvatureTimesTheForce) {
  const SurfaceBumps bumps{.pattern = SurfaceBumps::Pattern::ridges, .height_m = 0.0003, .length_m = 0.001};
  const double expected = 4.6 * 2.0 * std::numbers::pi * std::numbers::pi * 0.0003 / 1e-6;
  const double bound = largest_on_bumps(bumps, 800.0, 0.0, 4.6);
  EXPECT_GT(bound, expected);
  EXPECT_LT(bound, 1.05 * expected);
  EXPECT_NEAR(expected, 27240.0, 10.0);
}

// Compared with the formula of K (tilted_spring.h) on faces of any direction, which cut the pattern of the bumps at any angle.
TEST(TiltedSpring, BoundsTheFormulaOnAnySurface) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const auto pattern : {SurfaceBumps::Pattern::ridges, SurfaceBumps::Pattern::grid}) {
    for (const double bending : {0.0, 0.1, 0.5, 1.0, 2.0, 10.0, 100.0}) {
      for (const double scale : {1e-6, 1.0, 1e6}) {
        const SurfaceBumps bumps{.pattern = pattern, .height_m = 0.3 * scale, .length_m = scale};
        const double spring = 800.0;
        const double sideways = 100.0;
        const double pressed = bending * spring * scale / 6.0;
        const double bound = largest_on_bumps(bumps, spring, sideways, pressed);
        double largest_sampled = 0.0;
        for (int n = 0; n < 20000; ++n) {
          const Vec3 p = scale * Vec3(unit(random), unit(random), unit(random));
          // Faces normal to z, on which the pattern is whole, and faces of any direction.
          const Vec3 normal = n % 2 == 0 ? Vec3(Vec3::UnitZ()) : Vec3(unit(random), unit(random), unit(random)).normalized();
          const Mat3 projection = Mat3::Identity() - normal * normal.transpose();
          const Vec3 v = normal - projection * bumps.gradient_at(p);
          Mat3 curvature;
          const double h = 1e-4 * scale;
          for (int k = 0; k < 3; ++k) {
            const Vec3 offset = h * Vec3::Unit(k);
            curvature.col(k) = (bumps.gradient_at(p + offset) - bumps.gradient_at(p - offset)) / (2.0 * h);
          }
          largest_sampled = std::max(
              largest_sampled,
              largest_eigenvalue(spring * v * v.transpose() + pressed * projection * curvature * projection + sideways * projection));
        }
        EXPECT_GE(bound, (1.0 - 1e-6) * largest_sampled) << "seed 11, bending " << bending << ", scale " << scale;
        EXPECT_LE(bound, 1.2 * largest_sampled) << "seed 11, bending " << bending << ", scale " << scale;
      }
    }
  }
}

}  // namespace
}  // namespace hapton
