#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "core/collision/wide_bvh.h"
#include "core/geometry/triangle_mesh.h"
#include "core/math/float8.h"

namespace hapton {

// Tests the triangles of one tree node, eight at a time, against another triangle's plane: most pairs whose boxes overlap are separated.
// RT: yes. Units: those of the vertices, whose coordinates are about 1. Pre: vertices and triangles outlive this object.
class BeyondPlane {
 public:
  BeyondPlane(std::span<const Vec3> vertices, std::span<const Triangle> triangles) : vertices_(vertices), triangles_(triangles) {}

  // Chooses the triangles to test. Pre: bit i of `lanes` is set if items[i] is a triangle; other lanes are ignored.
  void start(const std::array<std::uint32_t, WideBvh::kWidth>& items, unsigned lanes) {
    items_ = items;
    lanes_ = lanes;
    is_loaded_ = false;
  }

  // Sets the bit of each item that is certainly on one side of the plane of triangle t, farther than `margin` away. Unused bits: undefined.
  unsigned find(std::uint32_t t, double margin) {
    constexpr double kRounding = 0x1p-44;  // of a cross product in plain doubles, and of its dot products
    if (!is_loaded_) load();
    const Triangle& corner = triangles_[t];
    const Vec3& a = vertices_[corner[0]];
    const Vec3 ab = vertices_[corner[1]] - a;
    const Vec3 ac = vertices_[corner[2]] - a;
    const Vec3 normal = ab.cross(ac);
    const double min_height = margin * normal.lpNorm<1>() + kRounding * ab.lpNorm<1>() * ac.lpNorm<1>();
    const Double4 level(normal.dot(a));
    const Double4 above = level + Double4(min_height);
    const Double4 below = level - Double4(min_height);
    unsigned beyond = 0;
    for (std::size_t half = 0; half < 2; ++half) {
      std::array<Double4, 3> height;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto at = [&](std::size_t axis) { return Double4::load(&corner_[k][axis][4 * half]); };
        height[k] = at(0) * Double4(normal.x()) + at(1) * Double4(normal.y()) + at(2) * Double4(normal.z());
      }
      const Double4 lowest = min(height[0], min(height[1], height[2]));
      const Double4 highest = max(height[0], max(height[1], height[2]));
      beyond |= (sign_bits(above < lowest) | sign_bits(highest < below)) << (4 * half);
    }
    return beyond;
  }

 private:
  void load() {
    is_loaded_ = true;
    for (std::size_t c = 0; c < WideBvh::kWidth; ++c) {
      const Triangle& triangle = triangles_[(lanes_ >> c & 1U) != 0 ? items_[c] : 0];
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t axis = 0; axis < 3; ++axis) corner_[k][axis][c] = vertices_[triangle[k]][static_cast<Eigen::Index>(axis)];
      }
    }
  }

  std::span<const Vec3> vertices_;
  std::span<const Triangle> triangles_;
  std::array<std::uint32_t, WideBvh::kWidth> items_{};
  unsigned lanes_ = 0;
  bool is_loaded_ = false;
  alignas(32) std::array<std::array<std::array<double, WideBvh::kWidth>, 3>, 3> corner_;  // by corner and axis, a lane for each item
};

}  // namespace hapton
