#include "core/collision/touch_geometry.h"

#include <cmath>
#include <utility>

namespace hapton {
namespace {

Box bounds_of(const std::vector<const TriangleMesh*>& meshes) {
  Box box;
  for (const TriangleMesh* mesh : meshes) {
    for (const Vec3& v : mesh->vertices) box.grow(v);
  }
  return box;
}

std::vector<Box> triangle_boxes(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles) {
  std::vector<Box> boxes;
  boxes.reserve(triangles.size());
  for (const Triangle& t : triangles) {
    const Vec3& a = vertices[t[0]];
    const Vec3& b = vertices[t[1]];
    const Vec3& c = vertices[t[2]];
    boxes.push_back({a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)});
  }
  return boxes;
}

}  // namespace

TouchGeometry::TouchGeometry(const std::vector<const TriangleMesh*>& meshes) : tree_(std::span<const Box>{}) {
  const Box bounds = bounds_of(meshes);
  if (!(bounds.low.array() <= bounds.high.array()).all()) return;
  origin_ = bounds.center();
  const double diagonal = bounds.diagonal();
  if (diagonal > 0.0) unit_m_ = std::ldexp(1.0, std::ilogb(diagonal));
  constexpr double kGrid = 0x1p-51;

  std::size_t vertex_count = 0;
  std::size_t count = 0;
  for (const TriangleMesh* mesh : meshes) {
    vertex_count += mesh->vertices.size();
    count += mesh->triangles.size();
  }
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  vertices.reserve(vertex_count);
  triangles.reserve(count);
  std::vector<std::uint16_t> owner;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (const Vec3& v : meshes[m]->vertices) vertices.push_back((to_local(v) / kGrid).array().round() * kGrid);
    for (const Triangle& t : meshes[m]->triangles) triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    if (meshes.size() > 1) owner.resize(triangles.size(), static_cast<std::uint16_t>(m));
  }
  tree_ = WideBvh(triangle_boxes(vertices, triangles));

  // Tree order for triangles, first-use order for vertices: what is near in space is near in memory.
  const std::vector<std::uint32_t> order = tree_.items_in_tree_order();
  constexpr std::uint32_t kUnset = 0xFFFFFFFFU;
  std::vector<std::uint32_t> new_vertex(vertices.size(), kUnset);
  std::vector<std::uint32_t> new_triangle(triangles.size());
  vertices_.reserve(vertices.size());
  triangles_.reserve(triangles.size());
  for (const std::uint32_t old : order) {
    new_triangle[old] = static_cast<std::uint32_t>(triangles_.size());
    Triangle t = triangles[old];
    for (std::uint32_t& v : t) {
      if (new_vertex[v] == kUnset) {
        new_vertex[v] = static_cast<std::uint32_t>(vertices_.size());
        vertices_.push_back(vertices[v]);
      }
      v = new_vertex[v];
    }
    triangles_.push_back(t);
    if (!owner.empty()) mesh_of_.push_back(owner[old]);
  }
  tree_.renumber_items(new_triangle);
}

std::uint32_t TouchGeometry::mesh_of(std::uint32_t triangle) const { return mesh_of_.empty() ? 0 : mesh_of_[triangle]; }

std::size_t TouchGeometry::bytes() const {
  return tree_.bytes() + vertices_.size() * sizeof(Vec3) + triangles_.size() * sizeof(Triangle) + mesh_of_.size() * sizeof(std::uint16_t);
}

}  // namespace hapton
