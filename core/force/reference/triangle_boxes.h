#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"

namespace hapton {

// The boxes of triangles, in single precision and rounded outwards: finds the triangles near a point by testing the box of each, several at
// a time. For code that must not depend on a search structure: the reference, and hapton stress. Threads: one.
class TriangleBoxes {
 public:
  // Pre: each triangle names vertices of the span.
  TriangleBoxes(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

  // The triangles whose box is within `bound` of p, and possibly some that are farther by a few millionths of the largest coordinate, |p|
  // and `bound`, in ascending order. Valid until the next call. In the frame and unit of the vertices. RT: yes.
  std::span<const std::uint32_t> find_near(const Vec3& p, double bound) noexcept;

 private:
  struct alignas(32) Boxes8 {
    std::array<std::array<float, 8>, 3> low, high;  // by axis; an empty box where there is no triangle
  };
  std::vector<Boxes8> boxes_;
  std::uint32_t count_ = 0;
  std::vector<std::uint32_t> near_triangles_;
  double largest_coordinate_ = 0.0;  // largest absolute coordinate
};

}  // namespace hapton
