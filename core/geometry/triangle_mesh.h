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
  // The normals that the mesh's author gave the corners of each triangle, as they came: zero where there was none, not checked for length
  // or side (corner_normals.h does). Empty when the mesh has none; else as long as triangles.
  std::vector<std::array<Eigen::Vector3f, 3>> authored_normals = {};

  bool has_authored_normals() const { return !authored_normals.empty() && authored_normals.size() == triangles.size(); }
  const Vec3& corner(std::size_t triangle, int k) const { return vertices[triangles[triangle][k]]; }
};

}  // namespace hapton
