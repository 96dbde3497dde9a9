#include "core/geometry/screen_rectangle.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace hapton {
namespace {

// Coordinates s_x and s_y of each corner along the sides, in units of half a side.
constexpr std::array<double, 4> kSideX = {-1.0, 1.0, 1.0, -1.0};
constexpr std::array<double, 4> kSideY = {-1.0, -1.0, 1.0, 1.0};

constexpr std::string_view kTouchInOrder =
    "touch the lower left, lower right, upper right and upper left corner of the picture, in this order";

// Coefficients of four points p_i in the orthogonal functions 1, s_x, s_y, s_x s_y of the corner: p_i = m + s_x a + s_y b + s_x s_y t.
struct CornerMeans {
  Vec3 m = Vec3::Zero();
  Vec3 a = Vec3::Zero();
  Vec3 b = Vec3::Zero();
};

CornerMeans average(const ScreenCorners& corners) {
  CornerMeans means;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    means.m += 0.25 * corners[i];
    means.a += 0.25 * kSideX[i] * corners[i];
    means.b += 0.25 * kSideY[i] * corners[i];
  }
  return means;
}

// The sum of squared distances to a rectangle with centre c, axes x, y and half sides u, v is 4 (|m - c|^2 + |a - u x|^2 + |b - v y|^2 +
// |t|^2). So c = m, u = a.x, v = b.y, and S = (a.x)^2 + (b.y)^2 has to be as large as possible. S is a convex function of the projections
// of x and y onto the plane of a and b. These form a matrix of norm at most 1, so S is largest where it is orthogonal: x and y lie in that
// plane. With the plane's vectors as complex numbers and x = e^(i angle), y = i x, S is half of |a|^2 + |b|^2 + Re((a^2 - b^2) / x^2). It
// is largest for angle = arg(a^2 - b^2) / 2. The sides u and v are then not negative.
ScreenRectangle find_closest(const CornerMeans& means) {
  const auto& [m, a, b] = means;
  const Vec3 e1 = a.norm() > 0.0 ? a.normalized() : Vec3(Vec3::UnitX());
  const Vec3 across = b - e1.dot(b) * e1;
  const Vec3 e2 = across.norm() > 0.0 ? across.normalized() : Vec3(e1.unitOrthogonal());
  const std::complex<double> a_plane(a.norm(), 0.0);
  const std::complex<double> b_plane(e1.dot(b), e2.dot(b));
  const double angle = 0.5 * std::arg(a_plane * a_plane - b_plane * b_plane);
  ScreenRectangle screen;
  auto R = screen.X_WR.linear();
  R.col(0) = (std::cos(angle) * e1 + std::sin(angle) * e2).normalized();
  R.col(2) = e1.cross(e2).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  screen.X_WR.translation() = m;
  screen.width_m = 2.0 * a.dot(R.col(0));
  screen.height_m = 2.0 * b.dot(R.col(1));
  return screen;
}

Result<void> check_sides(const ScreenRectangle& screen) {
  const auto [least, most] = std::minmax(screen.width_m, screen.height_m);
  if (least >= std::max(kMinSideM, kMinSideShare * most)) return {};
  return fail("the touched points do not span a rectangle: only {:.1f} x {:.1f} mm: {}", 1e3 * screen.width_m, 1e3 * screen.height_m,
              kTouchInOrder);
}

Result<void> check_order(const ScreenRectangle& screen) {
  const auto R = screen.X_WR.linear();
  const bool faces_user = R.col(2).y() + R.col(2).z() > 0.0;
  if (faces_user && R(0, 0) > std::abs(R(0, 1))) return {};
  return fail("the corners were touched in another order ({}): {}",
              faces_user ? "the first one is not the lower left" : "they go round the other way", kTouchInOrder);
}

Result<void> check_residuals(const ScreenFit& fit) {
  const double most_m = *std::max_element(fit.residuals_m.begin(), fit.residuals_m.end());
  const double diagonal_m = std::hypot(fit.screen.width_m, fit.screen.height_m);
  if (most_m <= kMaxResidualShare * diagonal_m) return {};
  return fail(
      "the touched points are up to {:.1f} mm from the nearest rectangle, {:.1f} x {:.1f} mm: {:.1f} % of its diagonal, and {:g} % is "
      "allowed; touch all corners again, exactly, and move neither screen nor device meanwhile",
      1e3 * most_m, 1e3 * fit.screen.width_m, 1e3 * fit.screen.height_m, 100.0 * most_m / diagonal_m, 100.0 * kMaxResidualShare);
}

}  // namespace

ScreenCorners find_corners(const ScreenRectangle& screen) {
  ScreenCorners corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i] = screen.X_WR * Vec3(0.5 * kSideX[i] * screen.width_m, 0.5 * kSideY[i] * screen.height_m, 0.0);
  }
  return corners;
}

Result<ScreenFit> fit_screen(const ScreenCorners& corners_W) {
  for (std::size_t i = 0; i < corners_W.size(); ++i) {
    if (!corners_W[i].allFinite()) return fail("the {} corner is not a position: {}", kCornerNames[i], kTouchInOrder);
  }
  ScreenFit fit{.screen = find_closest(average(corners_W))};
  if (const auto sides = check_sides(fit.screen); !sides) return tl::unexpected(sides.error());
  if (const auto order = check_order(fit.screen); !order) return tl::unexpected(order.error());
  const ScreenCorners fitted = find_corners(fit.screen);
  for (std::size_t i = 0; i < corners_W.size(); ++i) fit.residuals_m[i] = (corners_W[i] - fitted[i]).norm();
  if (const auto close = check_residuals(fit); !close) return tl::unexpected(close.error());
  return fit;
}

}  // namespace hapton
