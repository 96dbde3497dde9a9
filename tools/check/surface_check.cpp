#include "tools/check/surface_check.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/rounded_down.h"
#include "core/collision/wall_thickness.h"
#include "core/geometry/boundary_loops.h"
#include "core/geometry/mass_properties.h"
#include "scene/mesh_report.h"

namespace hapton {
namespace {

std::string plural(std::size_t count, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

// Recommends a smaller probe only if at least a tenth of its radius is left; otherwise a point.
std::string how_to_thicken(double thickness_m, double probe_radius_m) {
  const double fitting_m = 0.5 * thickness_m;
  if (fitting_m < 0.1 * probe_radius_m) return "thicken it, or touch it with a point (--probe-radius 0)";
  return fmt::format("thicken it, or give --probe-radius {:.2g} or less", rounded_down(fitting_m));
}

void check_walls(const SceneObject& object, double probe_radius_m, CheckFindings& findings) {
  if (!(probe_radius_m > 0.0)) return;
  const ThinWalls walls = find_thin_walls(*object.mesh, 2.0 * probe_radius_m);
  if (!walls.thinnest) return;
  findings.push_back(
      {SceneFault::thin_wall, object.name, walls.thinnest->point,
       fmt::format("a wall is {:.3g} mm thick, thinner than the ball of the probe ({:.3g} mm), so its rim feels as thick as the "
                   "ball ({})",
                   1e3 * walls.thinnest->thickness, 2e3 * probe_radius_m, plural(walls.triangles, "triangle", "triangles")),
       how_to_thicken(walls.thinnest->thickness, probe_radius_m)});
}

// The reason why sealing left these crack edges open.
std::string why_open(std::size_t cracks, const SealReport& sealed) {
  if (sealed.boundary_edges == 0) return {};
  const std::size_t narrow_edges = std::min(cracks, sealed.unsealed_edges);
  std::string why;
  if (cracks > narrow_edges)
    why += fmt::format("; {} wider than the {:.3g} mm that is sealed", cracks - narrow_edges, 1e3 * sealed.tolerance);
  if (narrow_edges == 0) return why;
  return why + fmt::format("; {} {}", narrow_edges,
                           sealed.has_given_up ? "too close to others to be sealed"
                                               : "not sealed, because that would move a vertex too far or flip a triangle");
}

// Cracks are gaps up to a thousandth of the longest side; wider gaps are openings. A probe that is narrower than a gap gets through it.
void check_openings(const SceneObject& object, const MeshFlaws& flaws, double probe_radius_m, CheckFindings& findings) {
  const double crack_m = crack_width(flaws.topology);
  const double narrow_m = std::max(crack_m, 2.0 * probe_radius_m);
  std::vector<BoundaryLoop> loops = find_boundary_loops(*object.mesh, narrow_m);
  if (loops.empty()) return;
  if (flaws.borders.cracks > 0 && 2.0 * probe_radius_m < crack_m) {
    findings.push_back({SceneFault::crack, object.name, loops.back().on_edge,
                        fmt::format("{} of cracks up to {:.3g} mm wide {} open{}: a point probe falls through",
                                    plural(flaws.borders.cracks, "edge", "edges"), 1e3 * flaws.borders.widest_crack,
                                    flaws.borders.cracks == 1 ? "is" : "are", why_open(flaws.borders.cracks, object.sealed)),
                        object.sealed.boundary_edges > 0 || object.sealed.has_given_up
                            ? "close the gaps in the mesh"
                            : "remove seal_cracks = false, or close the gaps in the mesh"});
  }
  std::erase_if(loops, [&](const BoundaryLoop& loop) { return !loop.is_opening() || loop.width <= narrow_m; });
  if (loops.empty()) return;
  findings.push_back(
      {SceneFault::opening, object.name, loops.front().centre,
       fmt::format("{} in its surface; the widest is {:.3g} mm wide ({}), and the probe gets inside",
                   plural(loops.size(), "opening", "openings"), 1e3 * loops.front().width, plural(loops.front().edges, "edge", "edges")),
       "close it in the mesh, unless the inside is to be touched"});
}

// Where a thousand triangles meet, a step of a point probe takes 0.1 ms, and a sphere probe crosses so many edges of a cone in one step
// that a part of its motion is carried into the next steps.
void check_fans(const SceneObject& object, CheckFindings& findings) {
  constexpr std::uint32_t kMaxValence = 1000;  // triangles at a vertex, as docs/checking.md says
  std::vector<std::uint32_t> valence(object.mesh->vertices.size(), 0);
  for (const Triangle& triangle : object.mesh->triangles) {
    for (const std::uint32_t vertex : triangle) ++valence[vertex];
  }
  const auto largest = std::max_element(valence.begin(), valence.end());
  if (largest == valence.end() || *largest <= kMaxValence) return;
  const auto large_fan_count =
      static_cast<std::size_t>(std::count_if(valence.begin(), valence.end(), [](std::uint32_t n) { return n > kMaxValence; }));
  findings.push_back(
      {SceneFault::large_fan, object.name, object.mesh->vertices[static_cast<std::size_t>(largest - valence.begin())],
       fmt::format("{} triangles meet in one vertex ({} of more than {}): steps there take longer, and a fast probe lags behind", *largest,
                   plural(large_fan_count, "vertex", "vertices"), kMaxValence),
       "export it with a coarser chord tolerance, or let the middle of discs and cones be meshed evenly"});
}

void check_sides(const SceneObject& object, const MeshFlaws& flaws, CheckFindings& findings) {
  const std::vector<Vec3> edges = find_inconsistent_edges(*object.mesh);
  const std::string_view effect = object.material.two_sided ? "shading and methods that use the sides go wrong there"
                                                            : "with two_sided = false they cannot be touched from outside";
  if (!edges.empty()) {
    findings.push_back({SceneFault::flipped, object.name, edges.front(),
                        fmt::format("{} between triangles that face opposite sides: {}", plural(edges.size(), "edge", "edges"), effect),
                        "make the normals consistent (\"recalculate outside\") and export again"});
  }
  if (flaws.bodies.inside_out > 0) {
    findings.push_back({SceneFault::inside_out, object.name, flaws.bodies.inside_out_at,
                        fmt::format("{} of {} inside out: {}", flaws.bodies.inside_out,
                                    plural(flaws.bodies.count, "closed body is", "closed bodies are"), effect),
                        "turn the normals round and export again"});
  }
}

}  // namespace

CheckFindings check_surface(const SceneObject& object, double probe_radius_m) {
  CheckFindings findings;
  const MeshFlaws flaws = find_flaws(*object.mesh);
  check_walls(object, probe_radius_m, findings);
  check_openings(object, flaws, probe_radius_m, findings);
  check_fans(object, findings);
  check_sides(object, flaws, findings);
  return findings;
}

CheckFindings check_inertia(const SceneObject& object) {
  if (!(object.mass_kg > 0.0) || compute_mass_properties(*object.mesh)) return {};
  return {{SceneFault::no_inertia, object.name, std::nullopt,
           "has a mass, but its surface is not closed or faces inwards: its inertia is unknown",
           "close it, turn its triangles outwards, or leave out its mass_kg"}};
}

}  // namespace hapton
