#include "core/collision/object_geometry.h"

namespace hapton {
namespace {

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

ObjectGeometry::ObjectGeometry(const TriangleMesh& mesh, const LocalFrame& frame) : tree_(std::span<const Box>{}) {
  constexpr double kGrid = 0x1p-51;
  std::vector<Vec3> vertices;
  vertices.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) vertices.push_back((frame.to_local(v) / kGrid).array().round() * kGrid);
  tree_ = WideBvh(triangle_boxes(vertices, mesh.triangles));

  // Tree order for triangles, first-use order for vertices: what is near in space is near in memory.
  const std::vector<std::uint32_t> order = tree_.items_in_tree_order();
  constexpr std::uint32_t kUnset = 0xFFFFFFFFU;
  std::vector<std::uint32_t> new_vertex(vertices.size(), kUnset);
  std::vector<std::uint32_t> new_triangle(mesh.triangles.size());
  vertices_.reserve(vertices.size());
  triangles_.reserve(mesh.triangles.size());
  for (const std::uint32_t old : order) {
    new_triangle[old] = static_cast<std::uint32_t>(triangles_.size());
    Triangle t = mesh.triangles[old];
    for (std::uint32_t& v : t) {
      if (new_vertex[v] == kUnset) {
        new_vertex[v] = static_cast<std::uint32_t>(vertices_.size());
        vertices_.push_back(vertices[v]);
      }
      v = new_vertex[v];
    }
    triangles_.push_back(t);
  }
  vertices_.shrink_to_fit();
  tree_.renumber_items(new_triangle);
}

std::size_t ObjectGeometry::bytes() const {
  return tree_.bytes() + vertices_.size() * sizeof(Vec3) + triangles_.size() * sizeof(Triangle);
}

}  // namespace hapton
