#include "core/collision/triangle_box.h"

#include <algorithm>
#include <limits>

namespace hapton {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// Whether axis separates the triangle (corners relative to the box's middle) from the box; size bounds every coordinate.
bool separates(const Vec3& axis, const std::array<Vec3, 3>& corners, const Vec3& half, double size) {
  const double p = axis.dot(corners[0]);
  const double q = axis.dot(corners[1]);
  const double r = axis.dot(corners[2]);
  const Vec3 absolute_axis = axis.cwiseAbs();
  const double radius = absolute_axis.dot(half) + 16.0 * kEpsilon * absolute_axis.sum() * size;
  return std::min({p, q, r}) > radius || std::max({p, q, r}) < -radius;
}

}  // namespace

bool may_touch(const std::array<Vec3, 3>& triangle, const Vec3& box_low, const Vec3& box_high) noexcept {
  const Vec3 half = 0.5 * (box_high - box_low);
  const Vec3 middle = box_low + half;
  const std::array<Vec3, 3> corners = {triangle[0] - middle, triangle[1] - middle, triangle[2] - middle};
  const double size = half.maxCoeff() + box_low.cwiseAbs().maxCoeff() + box_high.cwiseAbs().maxCoeff() +
                      std::max({triangle[0].cwiseAbs().maxCoeff(), triangle[1].cwiseAbs().maxCoeff(), triangle[2].cwiseAbs().maxCoeff()});
  for (int axis = 0; axis < 3; ++axis) {
    if (separates(Vec3::Unit(axis), corners, half, size)) {
      return false;
    }
  }
  // The edges come from the given corners, not from the moved ones: each edge is then correct to its last bit, however short.
  const std::array<Vec3, 3> edges = {triangle[1] - triangle[0], triangle[2] - triangle[1], triangle[0] - triangle[2]};
  for (const Vec3& edge : edges) {
    for (int axis = 0; axis < 3; ++axis) {
      // The cross product with a unit vector only permutes and negates components: nothing rounds but the edge itself.
      if (separates(Vec3::Unit(axis).cross(edge), corners, half, size)) {
        return false;
      }
    }
  }
  // The normal has rounding errors of its own, in proportion to both edges; the bound on its dot product must include them.
  const Vec3 normal = edges[0].cross(edges[1]);
  const double edge_size = edges[0].cwiseAbs().sum() * edges[1].cwiseAbs().sum();
  const double height = normal.dot(corners[0]);
  const double radius = normal.cwiseAbs().dot(half) + 32.0 * kEpsilon * edge_size * size;
  return height <= radius && height >= -radius;
}

}  // namespace hapton
