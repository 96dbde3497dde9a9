#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// A mesh with a unit normal at every corner of every triangle. Triangles that meet smoothly at a vertex share one normal there; across a
// sharp edge they have different ones. Frame and units: those of the mesh. RT: yes for reading.
struct ShadedMesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  std::vector<Vec3> normals;
  std::vector<Triangle> corner_normals;  // indices into normals, one for each corner
  std::vector<std::uint32_t> source;     // for each triangle, the triangle of the original mesh that it is (a part of)

  // The last vertices of the list, and the normals from first_middle_normal on, are each midway between two earlier ones, which these lists
  // name. Normals that repair_corner_normals adds later come after those.
  std::vector<std::array<std::uint32_t, 2>> middle_vertices;
  std::vector<std::array<std::uint32_t, 2>> middle_normals;
  std::uint32_t first_middle_normal = 0;

  const Vec3& corner(std::size_t t, int k) const { return vertices[triangles[t][k]]; }
  const Vec3& normal(std::size_t t, int k) const { return normals[corner_normals[t][k]]; }
};

}  // namespace hapton
