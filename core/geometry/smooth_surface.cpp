#include "core/geometry/smooth_surface.h"

#include <algorithm>
#include <limits>
#include <numbers>

namespace hapton {
namespace {

double diagonal_of(const TriangleMesh& mesh) {
  Vec3 low = mesh.corner(0, 0);
  Vec3 high = low;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      low = low.cwiseMin(mesh.corner(t, k));
      high = high.cwiseMax(mesh.corner(t, k));
    }
  }
  return (high - low).norm();
}

void set_middles(ShadedMesh& mesh) {
  const std::size_t first = mesh.vertices.size() - mesh.middle_vertices.size();
  for (std::size_t i = 0; i < mesh.middle_vertices.size(); ++i) {
    const auto& [a, b] = mesh.middle_vertices[i];
    mesh.vertices[first + i] = 0.5 * mesh.vertices[a] + 0.5 * mesh.vertices[b];
  }
}

}  // namespace

Result<SmoothSurface> make_smooth_surface(const TriangleMesh& mesh, const SmoothSurfaceSettings& settings, SmoothSurfaceReport& report) {
  report = {};
  if (!(settings.crease_angle_rad >= 0.0 && settings.crease_angle_rad <= std::numbers::pi)) {
    return fail("smooth surface: the crease angle {:g} is not from 0 to 180 degrees", settings.crease_angle_rad * 180.0 / std::numbers::pi);
  }
  if (!(settings.longest_edge >= 0.0) || !(settings.growth >= 1.0)) {
    return fail("smooth surface: longest edge {:g} must be 0 or more, growth {:g} 1 or more", settings.longest_edge, settings.growth);
  }
  std::vector<std::uint32_t> source;
  std::vector<std::uint32_t> vertex_source;
  TriangleMesh clean = repair_mesh(mesh, report.repair, &source, &vertex_source);
  if (clean.triangles.empty()) return fail("smooth surface: none of the mesh's {} triangles has an area", mesh.triangles.size());
  auto simplified = simplify_small(clean, settings.simplify_error_m);
  if (!simplified) return tl::unexpected(simplified.error());
  report.simplify = *simplified;
  // Once triangles have been merged, no triangle has a source.
  if (report.simplify.after != report.simplify.before) source.assign(clean.triangles.size(), std::numeric_limits<std::uint32_t>::max());

  SmoothSurface surface;
  surface.vertex_source = std::move(vertex_source);
  surface.mesh = fill_corner_normals(clean, source, settings.crease_angle_rad, report.normals);
  report.check = repair_corner_normals(surface.mesh);
  const auto limit = static_cast<std::size_t>(settings.growth * static_cast<double>(clean.triangles.size())) + 100000;
  report.split = split_large(surface.mesh, settings.longest_edge * diagonal_of(clean), limit);
  surface.face_count = surface.mesh.triangles.size();
  report.fans = add_normal_fans(surface.mesh);
  report.final_check = repair_corner_normals(surface.mesh, surface.face_count);
  return surface;
}

void SmoothSurface::move_vertices(std::span<const Vec3> vertices) {
  for (std::size_t i = 0; i < vertex_source.size(); ++i) mesh.vertices[i] = vertices[vertex_source[i]];
  set_middles(mesh);
  update_corner_normals(mesh, face_count);
}

std::vector<std::string> SmoothSurfaceReport::lines() const {
  return {repair.describe(),
          simplify.describe(),
          normals.describe(),
          check.describe(),
          split.describe(),
          fans.describe(),
          "final " + final_check.describe()};
}

}  // namespace hapton
