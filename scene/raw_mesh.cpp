#include "scene/raw_mesh.h"

#include <numeric>
#include <utility>

#include "scene/polygon.h"

namespace hapton {

void RawMesh::begin_part(std::string name) {
  end_parts();
  parts.push_back({.name = std::move(name), .first_triangle = mesh.triangles.size(), .triangle_count = 0});
}

void RawMesh::end_parts() {
  if (parts.empty()) return;
  parts.back().triangle_count = mesh.triangles.size() - parts.back().first_triangle;
  if (parts.back().triangle_count == 0) parts.pop_back();
}

namespace {

const std::array<Eigen::Vector3f, 3> kNoNormals = {Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};

}  // namespace

bool RawMesh::add_polygon(std::span<const std::uint32_t> corners, std::span<const Eigen::Vector3f> normals,
                          const PolygonAppearance* appearance_of) {
  if (normals.empty() && appearance_of == nullptr) return triangulate_polygon(corners, mesh.vertices, mesh.triangles);
  // Triangulates indices of the polygon's own corners, because one vertex may occur in it twice, with two normals.
  std::vector<std::uint32_t> own(corners.size());
  std::iota(own.begin(), own.end(), 0U);
  std::vector<Vec3> points;
  for (const std::uint32_t corner : corners) points.push_back(mesh.vertices[corner]);
  std::vector<Triangle> triangles;
  if (!triangulate_polygon(own, points, triangles)) return false;
  for (const auto& [a, b, c] : triangles) {
    const Triangle triangle = {corners[a], corners[b], corners[c]};
    if (appearance_of != nullptr) {
      appearance.resize(mesh.triangles.size());
      const auto& seen = appearance_of->corners;
      appearance.triangles.push_back({appearance_of->material, appearance_of->has_colours, {seen[a], seen[b], seen[c]}});
    }
    if (normals.empty()) {
      mesh.triangles.push_back(triangle);
    } else {
      add_triangle(triangle, {normals[a], normals[b], normals[c]});
    }
  }
  return true;
}

void RawMesh::add_triangle(const Triangle& triangle, const std::array<Eigen::Vector3f, 3>& normals) {
  mesh.authored_normals.resize(mesh.triangles.size(), kNoNormals);
  mesh.triangles.push_back(triangle);
  mesh.authored_normals.push_back(normals);
}

void RawMesh::end_normals() {
  if (!mesh.authored_normals.empty()) mesh.authored_normals.resize(mesh.triangles.size(), kNoNormals);
}

void RawMesh::complete_appearance() {
  if (!appearance.triangles.empty()) appearance.resize(mesh.triangles.size());
  if (haptics.any()) haptics.maps.resize(mesh.triangles.size());
}

}  // namespace hapton
