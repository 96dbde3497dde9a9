#include "core/geometry/touch_resolution.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/seal_cracks.h"
#include "core/geometry/seam_mesh.h"

namespace hapton {
namespace {

bool is_higher_than(const TriangleMesh& mesh, std::size_t t, double height) {
  const Vec3 ab = mesh.corner(t, 1) - mesh.corner(t, 0);
  const Vec3 ac = mesh.corner(t, 2) - mesh.corner(t, 0);
  const double longest = std::max({ab.norm(), ac.norm(), (ac - ab).norm()});
  return ab.cross(ac).norm() > height * longest;
}

// The triangle with its lowest-numbered vertex first, in the same cyclic order.
Triangle rotated_to_lowest(const Triangle& triangle) {
  Triangle turned = triangle;
  std::rotate(turned.begin(), std::min_element(turned.begin(), turned.end()), turned.end());
  return turned;
}

// Which triangles are copies of an earlier one.
std::vector<bool> find_copies(const std::vector<Triangle>& triangles) {
  std::vector<std::pair<Triangle, std::uint32_t>> sorted;
  sorted.reserve(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) sorted.emplace_back(rotated_to_lowest(triangles[t]), t);
  std::sort(sorted.begin(), sorted.end());
  std::vector<bool> copies(triangles.size(), false);
  for (std::size_t i = 1; i < sorted.size(); ++i) copies[sorted[i].second] = sorted[i].first == sorted[i - 1].first;
  return copies;
}

// Removes copies, and triangles no higher than `height` over the longest edge. Adds the vertices of the latter to `at_dropped`.
bool drop_triangles(TriangleMesh& mesh, double height, std::vector<std::uint32_t>& at_dropped) {
  const std::vector<bool> copies = find_copies(mesh.triangles);
  const bool has_normals = mesh.has_authored_normals();
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (copies[t]) continue;
    if (!is_higher_than(mesh, t, height)) {
      at_dropped.insert(at_dropped.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
      continue;
    }
    mesh.triangles[kept] = mesh.triangles[t];
    if (has_normals) mesh.authored_normals[kept] = mesh.authored_normals[t];
    ++kept;
  }
  if (kept == mesh.triangles.size() || kept == 0) return false;
  mesh.triangles.resize(kept);
  if (has_normals) mesh.authored_normals.resize(kept);
  return true;
}

struct Resolved {
  TriangleMesh mesh;
  bool has_changed = false;
  bool is_closed = true;  // no boundary remains where a triangle was dropped
};

Resolved resolve(const TriangleMesh& mesh, double extent, double width, double height) {
  std::vector<std::uint32_t> at_dropped;
  Resolved resolved{.mesh = mesh};
  resolved.has_changed = drop_triangles(resolved.mesh, height, at_dropped);
  SealReport sealed;
  resolved.mesh = seal_cracks(std::move(resolved.mesh), sealed, width / extent);
  resolved.has_changed |= sealed.has_sealed();
  if (at_dropped.empty()) return resolved;
  const std::vector<std::uint8_t> boundary = find_boundary_vertices(resolved.mesh);
  if (boundary.empty()) return resolved;
  resolved.is_closed = boundary.size() == mesh.vertices.size() &&
                       std::none_of(at_dropped.begin(), at_dropped.end(), [&](std::uint32_t v) { return boundary[v] != 0; });
  return resolved;
}

}  // namespace

std::optional<TriangleMesh> resolve_for_touch(const TriangleMesh& mesh, double width, double negligible_height) {
  const double extent = compute_bounds(mesh).extent();
  if (!(extent > 0.0)) return std::nullopt;
  Resolved resolved = resolve(mesh, extent, width, width);
  if (!resolved.is_closed) resolved = resolve(mesh, extent, width, negligible_height);
  if (!resolved.has_changed) return std::nullopt;
  return std::move(resolved.mesh);
}

}  // namespace hapton
