#include "core/geometry/triangle_plane.h"

#include <cmath>
#include <limits>
#include <utility>

namespace hapton {
namespace {

// A plane is computed in extended precision (11 more bits), so that a needle's plane is as accurate as any other.
using Wide = Eigen::Matrix<long double, 3, 1>;

constexpr long double kEpsilon = std::numeric_limits<double>::epsilon();

TrianglePlane::Side make_side(const Wide& from, const Wide& to, int u, int v, long double turn) {
  TrianglePlane::Side side = {};
  const long double du = to[u] - from[u];
  const long double dv = to[v] - from[v];
  const long double length = std::hypot(du, dv);
  side.inward_u = static_cast<double>(-turn * dv / length);
  side.inward_v = static_cast<double>(turn * du / length);
  const Wide& low = dv < 0 ? to : from;
  const Wide& high = dv < 0 ? from : to;
  side.low_u = static_cast<double>(low[u]);
  side.low_v = static_cast<double>(low[v]);
  side.high_v = static_cast<double>(high[v]);
  side.slope = dv != 0 ? static_cast<double>(du / dv) : 0.0;
  return side;
}

}  // namespace

bool TrianglePlane::contains(double u, double v, double tolerance, double along_u, double along_v) const noexcept {
  bool inside = false;
  for (const Side& side : sides) {
    if (v >= side.low_v && v < side.high_v) {
      inside ^= u < side.low_u + (v - side.low_v) * side.slope;
    }
  }
  if (inside) {
    return true;
  }
  for (const Side& side : sides) {
    const double in = side.inward_u * (u - side.low_u) + side.inward_v * (v - side.low_v);
    if (in < -(tolerance + std::abs(side.inward_u * along_u + side.inward_v * along_v))) {
      return false;
    }
  }
  return true;
}

std::optional<TrianglePlane> compute_triangle_plane(const Vec3& a, const Vec3& b, const Vec3& c) noexcept {
  const Wide to_b = b.cast<long double>() - a.cast<long double>();
  const Wide to_c = c.cast<long double>() - a.cast<long double>();
  const long double extent = std::max(to_b.cwiseAbs().maxCoeff(), to_c.cwiseAbs().maxCoeff());
  if (!(extent > 0) || !(extent < std::numeric_limits<double>::max())) {
    return std::nullopt;
  }
  // Scaled to unit size first: the area of a triangle in nanometres would underflow.
  const Wide cross = (to_b / extent).cross(to_c / extent);
  const long double area = cross.norm();
  if (!(area > 4 * kEpsilon)) {
    return std::nullopt;
  }
  TrianglePlane plane = {};
  plane.origin = a;
  plane.normal = (cross / area).cast<double>();
  plane.extent = static_cast<double>(extent);
  int dominant = 0;
  cross.cwiseAbs().maxCoeff(&dominant);
  plane.u_axis = (dominant + 1) % 3;
  plane.v_axis = (dominant + 2) % 3;
  const long double turn = cross[dominant] > 0 ? 1 : -1;
  const std::array<Wide, 3> corners = {Wide::Zero(), to_b, to_c};
  for (std::size_t k = 0; k < 3; ++k) {
    plane.sides[k] = make_side(corners[k], corners[(k + 1) % 3], plane.u_axis, plane.v_axis, turn);
  }
  return plane;
}

}  // namespace hapton
