#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// Three vertex indices, counter-clockwise seen from outside.
using Triangle = std::array<std::uint32_t, 3>;

// An indexed set of triangles. Units: metres. Frame: that of its owner (frame S once it is placed in the static scene). Pre: every index <
// vertices.size(), every coordinate finite; scene/ checks both when it loads a mesh. Triangles without area, duplicates, cracks and flipped
// faces are allowed: real meshes have them.
struct TriangleMesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  // The normals that the file gives for the corners of each triangle, unchanged: zero where it gives none, length and side not checked
  // (corner_normals.h does that). Empty if the mesh has none; otherwise one entry for each triangle.
  std::vector<std::array<Eigen::Vector3f, 3>> authored_normals = {};

  bool has_authored_normals() const { return !authored_normals.empty() && authored_normals.size() == triangles.size(); }
  const Vec3& corner(std::size_t triangle, int k) const { return vertices[triangles[triangle][k]]; }
};

}  // namespace hapton
