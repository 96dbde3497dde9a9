#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// Three vertex indices, counter-clockwise seen from outside.
using Triangle = std::array<std::uint32_t, 3>;

// An indexed triangle set. Units: metres. Frame: the owner's (static scene S once posed). Pre: every index < vertices.size(), every
// coordinate finite; scene/ checks both when loading. Zero-area triangles, duplicates, cracks and flipped faces are allowed: real meshes
// have them.
struct TriangleMesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  // The authored normals of each triangle's corners, unchanged: zero if there was none, length and side not checked (corner_normals.h
  // does). Empty if the mesh has none; otherwise as long as triangles.
  std::vector<std::array<Eigen::Vector3f, 3>> authored_normals = {};

  bool has_authored_normals() const { return !authored_normals.empty() && authored_normals.size() == triangles.size(); }
  const Vec3& corner(std::size_t triangle, int k) const { return vertices[triangles[triangle][k]]; }
};

}  // namespace hapton
