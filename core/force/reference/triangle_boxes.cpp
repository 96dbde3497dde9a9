#include "core/force/reference/triangle_boxes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/math/float8.h"

namespace hapton {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr double kRelativeError =
    1e-6;  // above the relative error of a squared distance: 12 roundings of 2^-24 (centre, difference, square and sum of each axis)

float float_below(double x) { return std::nextafter(static_cast<float>(x), -std::numeric_limits<float>::infinity()); }
float float_above(double x) { return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity()); }

}  // namespace

TriangleBoxes::TriangleBoxes(std::span<const Vec3> vertices, std::span<const Triangle> triangles)
    : count_(static_cast<std::uint32_t>(triangles.size())) {
  near_triangles_.reserve(triangles.size());
  boxes_.resize((triangles.size() + 7) / 8);
  for (Boxes8& boxes : boxes_) {
    for (int axis = 0; axis < 3; ++axis) {
      boxes.low[axis].fill(kInfinity);
      boxes.high[axis].fill(-kInfinity);
    }
  }
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto& [a, b, c] = triangles[i];
    for (int axis = 0; axis < 3; ++axis) {
      const auto [least, most] = std::minmax({vertices[a][axis], vertices[b][axis], vertices[c][axis]});
      boxes_[i / 8].low[axis][i % 8] = float_below(least);
      boxes_[i / 8].high[axis][i % 8] = float_above(most);
      largest_coordinate_ = std::max({largest_coordinate_, std::fabs(least), std::fabs(most)});
    }
  }
}

std::span<const std::uint32_t> TriangleBoxes::find_near(const Vec3& p, double bound) noexcept {
  const std::array<Float8, 3> centre = {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
  const double farthest = bound + kRelativeError * (2.0 * largest_coordinate_ + p.norm() + bound);
  const Float8 limit = float_above(farthest * farthest * (1.0 + kRelativeError));
  near_triangles_.clear();
  std::uint32_t first = 0;
  for (const Boxes8& boxes : boxes_) {
    Float8 distance2 = 0.0F;
    for (int axis = 0; axis < 3; ++axis) {
      const Float8 below = Float8::load(boxes.low[axis].data()) - centre[axis];
      const Float8 above = centre[axis] - Float8::load(boxes.high[axis].data());
      const Float8 beside = max(max(below, above), 0.0F);
      distance2 = distance2 + beside * beside;
    }
    for (unsigned bits = sign_bits(distance2 <= limit); bits != 0; bits &= bits - 1) {
      const std::uint32_t i = first + static_cast<std::uint32_t>(std::countr_zero(bits));
      if (i < count_) near_triangles_.push_back(i);
    }
    first += 8;
  }
  return near_triangles_;
}

}  // namespace hapton
