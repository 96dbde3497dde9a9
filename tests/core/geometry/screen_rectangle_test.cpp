#include "core/geometry/screen_rectangle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace hapton {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

Quat turn(double degrees, const Vec3& axis) { return Quat(Eigen::AngleAxisd(degrees * kDegree, axis)); }

ScreenRectangle make_screen(const Vec3& p_WR, const Quat& q_WR, double width_m = 0.24, double height_m = 0.15) {
  return {Eigen::Translation3d(p_WR) * q_WR, width_m, height_m};
}

// Screens like a wall, a drawing board and a table, one that is seen from the side, and one that leans forward.
std::vector<ScreenRectangle> screens() {
  return {make_screen({0.0, 0.0, 0.0}, Quat::Identity()), make_screen({0.03, 0.05, -0.12}, turn(-30.0, Vec3::UnitX())),
          make_screen({-0.02, -0.1, 0.04}, turn(-90.0, Vec3::UnitX()), 0.15, 0.15),
          make_screen({0.2, 0.1, -0.3}, turn(-60.0, Vec3::UnitY()) * turn(10.0, Vec3::UnitZ()), 0.09, 0.16),
          make_screen({0.0, 0.3, -0.2}, turn(30.0, Vec3::UnitX()), 1.6, 0.9)};
}

double sum_of_squares(const ScreenRectangle& screen, const ScreenCorners& touched) {
  const ScreenCorners corners = find_corners(screen);
  double sum = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) sum += (corners[i] - touched[i]).squaredNorm();
  return sum;
}

ScreenCorners touched_corners(const ScreenRectangle& screen, double sigma_m, std::mt19937_64& random) {
  std::normal_distribution<double> error(0.0, sigma_m);
  ScreenCorners corners = find_corners(screen);
  for (Vec3& p_W : corners) p_W += Vec3(error(random), error(random), error(random));
  return corners;
}

std::string error_of(const ScreenCorners& corners) {
  const auto fit = fit_screen(corners);
  return fit ? std::string("none") : fit.error().what;
}

TEST(ScreenRectangle, ExactCornersGiveTheScreenBack) {
  for (const ScreenRectangle& screen : screens()) {
    const auto fit = fit_screen(find_corners(screen));
    ASSERT_TRUE(fit) << fit.error().what;
    EXPECT_LT((fit->screen.X_WR.matrix() - screen.X_WR.matrix()).norm(), 1e-12);
    EXPECT_NEAR(fit->screen.width_m, screen.width_m, 1e-13);
    EXPECT_NEAR(fit->screen.height_m, screen.height_m, 1e-13);
    for (const double residual_m : fit->residuals_m) EXPECT_LT(residual_m, 1e-13);
  }
}

TEST(ScreenRectangle, CornersAreInTheOrderOfTheirNames) {
  const ScreenCorners corners = find_corners(make_screen({1.0, 2.0, 3.0}, Quat::Identity(), 0.4, 0.2));
  EXPECT_LT((corners[0] - Vec3(0.8, 1.9, 3.0)).norm(), 1e-15);
  EXPECT_LT((corners[1] - Vec3(1.2, 1.9, 3.0)).norm(), 1e-15);
  EXPECT_LT((corners[2] - Vec3(1.2, 2.1, 3.0)).norm(), 1e-15);
  EXPECT_LT((corners[3] - Vec3(0.8, 2.1, 3.0)).norm(), 1e-15);
}

// Derived by hand: if one corner is lifted out of the plane by e, the fitted plane tilts, and each corner has a residual of e / 4.
TEST(ScreenRectangle, OneCornerThatIsLiftedLeavesAQuarterAtEachCorner) {
  const ScreenRectangle screen = make_screen({0.0, 0.0, 0.0}, Quat::Identity());
  for (std::size_t lifted = 0; lifted < 4; ++lifted) {
    ScreenCorners corners = find_corners(screen);
    corners[lifted].z() += 1e-4;
    const auto fit = fit_screen(corners);
    ASSERT_TRUE(fit);
    for (const double residual_m : fit->residuals_m) EXPECT_NEAR(residual_m, 0.25e-4, 1e-8);
  }
}

// Derived by hand: the fit of a square sheared by s is turned by s / 2, as its sides are equal; this gives the residuals of its corners.
TEST(ScreenRectangle, ASquareThatIsShearedIsTurnedByHalfTheShear) {
  const double shear = 1e-3;
  ScreenCorners corners = find_corners(make_screen({0.0, 0.0, 0.0}, Quat::Identity(), 0.2, 0.2));
  for (Vec3& p_W : corners) p_W.x() += shear * p_W.y();
  const auto fit = fit_screen(corners);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->screen.X_WR.linear()(0, 1), 0.5 * shear, 1e-7);
  for (const double residual_m : fit->residuals_m) EXPECT_NEAR(residual_m, 0.5 * shear * 0.1 * std::numbers::sqrt2, 1e-7);
}

TEST(ScreenRectangle, NoRectangleNearbyIsCloserToTouchedCorners) {
  constexpr std::uint64_t kSeed = 3;
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  for (const ScreenRectangle& screen : screens()) {
    for (int i = 0; i < 50; ++i) {
      const ScreenCorners touched = touched_corners(screen, 0.0005, random);
      const auto fit = fit_screen(touched);
      ASSERT_TRUE(fit) << fit.error().what;
      const double fitted_sum = sum_of_squares(fit->screen, touched);
      for (const double step : {1e-3, 1e-5}) {
        for (int k = 0; k < 20; ++k) {
          ScreenRectangle other = fit->screen;
          const auto n = [&] { return step * normal(random); };
          other.X_WR.translation() += Vec3(n(), n(), n());
          other.X_WR.rotate(Eigen::AngleAxisd(n(), Vec3(normal(random), normal(random), normal(random)).normalized()));
          other.width_m += n();
          other.height_m += n();
          EXPECT_GE(sum_of_squares(other, touched), fitted_sum - 1e-16) << "seed " << kSeed << ", fit " << i;
        }
      }
      EXPECT_TRUE(fit->screen.X_WR.linear().isUnitary(1e-12));
      EXPECT_NEAR(fit->screen.X_WR.linear().determinant(), 1.0, 1e-12);
    }
  }
}

// The errors of touches are averaged: the centre has half the error of one corner, the length of a side has the error of one corner.
TEST(ScreenRectangle, ErrorsOfTouchesAreAveraged) {
  constexpr std::uint64_t kSeed = 4;
  constexpr int kFits = 20'000;
  constexpr double kSigmaM = 0.0005;
  std::mt19937_64 random(kSeed);
  const ScreenRectangle screen = screens()[1];
  double centre_variance = 0.0;
  double width_variance = 0.0;
  double turn_variance = 0.0;
  for (int i = 0; i < kFits; ++i) {
    const auto fit = fit_screen(touched_corners(screen, kSigmaM, random));
    ASSERT_TRUE(fit) << "seed " << kSeed << ", fit " << i;
    centre_variance += (fit->screen.X_WR.translation() - screen.X_WR.translation()).squaredNorm() / 3.0 / kFits;
    width_variance += std::pow(fit->screen.width_m - screen.width_m, 2) / kFits;
    turn_variance += std::pow((screen.X_WR.linear().transpose() * fit->screen.X_WR.linear())(2, 0), 2) / kFits;  // about y
  }
  EXPECT_NEAR(std::sqrt(centre_variance), 0.5 * kSigmaM, 0.01 * kSigmaM);
  EXPECT_NEAR(std::sqrt(width_variance), kSigmaM, 0.02 * kSigmaM);
  EXPECT_NEAR(std::sqrt(turn_variance), kSigmaM / screen.width_m, 0.02 * kSigmaM / screen.width_m);
}

// Which errors of touches the limit of the residuals accepts, which it rejects, and how wrong an accepted rectangle can be.
TEST(ScreenRectangle, CarefulTouchesAreAcceptedAndAWrongCornerIsNot) {
  constexpr std::uint64_t kSeed = 5;
  constexpr int kFits = 50'000;
  std::mt19937_64 random(kSeed);
  const ScreenRectangle screen = make_screen({0.0, 0.0, 0.0}, Quat::Identity(), 0.2, 0.15);  // diagonal 250 mm
  int rejected = 0;
  for (int i = 0; i < kFits; ++i) rejected += fit_screen(touched_corners(screen, 0.001, random)) ? 0 : 1;
  EXPECT_LE(rejected, 4 * kFits / 1000) << "seed " << kSeed;

  // The residuals may be 1 % of the diagonal. That of a single wrong corner is a quarter of its error; the fit leaves three quarters.
  std::normal_distribution<double> normal;
  double largest_error_m = 0.0;
  for (int i = 0; i < kFits; ++i) {
    ScreenCorners corners = find_corners(screen);
    const double e_m = 0.02 * std::uniform_real_distribution<double>()(random);
    const std::size_t wrong_corner = random() % 4;
    corners[wrong_corner] += e_m * Vec3(normal(random), normal(random), normal(random)).normalized();
    const auto fit = fit_screen(corners);
    EXPECT_TRUE(fit || e_m > 0.01 * 0.25) << e_m;
    EXPECT_FALSE(fit && e_m > 1.02 * 0.04 * 0.25) << "seed " << kSeed << ", " << e_m;
    if (!fit) continue;
    const ScreenCorners fitted = find_corners(fit->screen);
    const ScreenCorners true_corners = find_corners(screen);
    for (std::size_t k = 0; k < 4; ++k) largest_error_m = std::max(largest_error_m, (fitted[k] - true_corners[k]).norm());
  }
  EXPECT_LE(largest_error_m, 1.03 * 0.03 * 0.25) << "seed " << kSeed;
}

TEST(ScreenRectangle, AWrongCornerIsOneLineWithNumbers) {
  ScreenCorners corners = find_corners(make_screen({0.0, 0.0, 0.0}, Quat::Identity(), 0.2, 0.15));
  corners[2] += Vec3(0.0, 0.0, 0.04);
  EXPECT_EQ(error_of(corners),
            "the touched points are up to 10.2 mm from the nearest rectangle, 201.0 x 151.3 mm: 4.0 % of its diagonal, and 1 % is allowed; "
            "touch all corners again, exactly, and move neither screen nor device meanwhile");
}

TEST(ScreenRectangle, CornersInAnotherOrderAreReportedAsSuch) {
  for (const ScreenRectangle& screen : screens()) {
    const auto [ll, lr, ur, ul] = find_corners(screen);
    EXPECT_EQ(error_of({ll, lr, ur, ul}), "none");
    for (const ScreenCorners& turned : {ScreenCorners{lr, ur, ul, ll}, {ur, ul, ll, lr}, {ul, ll, lr, ur}}) {
      EXPECT_NE(
          error_of(turned).find("another order (the first one is not the lower left): touch the lower left, lower right, upper right"),
          std::string::npos)
          << error_of(turned);
    }
    for (const ScreenCorners& mirrored : {ScreenCorners{ll, ul, ur, lr}, {lr, ll, ul, ur}, {ur, lr, ll, ul}, {ul, ur, lr, ll}}) {
      EXPECT_NE(error_of(mirrored).find("another order (they go round the other way)"), std::string::npos) << error_of(mirrored);
    }
    for (const ScreenCorners& crossed : {ScreenCorners{ll, ur, lr, ul}, {ll, lr, ul, ur}}) {
      EXPECT_NE(error_of(crossed).find("do not span a rectangle"), std::string::npos) << error_of(crossed);
    }
  }
}

TEST(ScreenRectangle, PointsThatSpanNoRectangleAreRejected) {
  const Vec3 x(0.1, 0.0, 0.0);
  EXPECT_NE(error_of({x, x, x, x}).find("do not span a rectangle: only 0.0 x 0.0 mm"), std::string::npos);
  EXPECT_NE(error_of({-x, x, x, -x}).find("only 200.0 x 0.0 mm"), std::string::npos);
  EXPECT_NE(error_of({-x, x, 2.0 * x, -2.0 * x}).find("do not span a rectangle"), std::string::npos);
  EXPECT_NE(error_of(find_corners(make_screen({0, 0, 0}, Quat::Identity(), 0.019, 0.1))).find("only 19.0 x 100.0 mm"), std::string::npos);
  EXPECT_EQ(error_of(find_corners(make_screen({0, 0, 0}, Quat::Identity(), 0.021, 0.1))), "none");
  EXPECT_NE(error_of(find_corners(make_screen({0, 0, 0}, Quat::Identity(), 1.0, 0.04))).find("only 1000.0 x 40.0 mm"), std::string::npos);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(error_of({x, Vec3(nan, 0, 0), x, x}).find("the lower right corner is not a position"), std::string::npos);
}

}  // namespace
}  // namespace hapton
