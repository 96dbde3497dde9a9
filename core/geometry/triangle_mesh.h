#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// Three vertex indices, counter-clockwise seen from outside.
using Triangle = std::array<std::uint32_t, 3>;

// An indexed triangle set.
// Units: metres. Frame: the owner's (static scene S once posed).
// Pre: every index < vertices.size(), every coordinate finite; scene/ checks both when it loads.
// Zero-area triangles, duplicates, cracks and flipped faces are allowed: real meshes have them.
struct TriangleMesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;

  const Vec3& corner(std::size_t triangle, int k) const { return vertices[triangles[triangle][k]]; }
};

}  // namespace hapton
