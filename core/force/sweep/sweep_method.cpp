#include "core/force/sweep/sweep_method.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace hapton {
namespace {

// The offset must be much larger than the rounding of coordinates: 64 times is a choice.
Result<void> check_offset(double offset_m, const UniformGrid& grid) {
  const double coordinate = std::max(grid.low().cwiseAbs().maxCoeff(), grid.high().cwiseAbs().maxCoeff());
  const double least = 64.0 * std::numeric_limits<double>::epsilon() * coordinate;
  if (!(offset_m > least) || !std::isfinite(offset_m)) {
    return fail(
        "sweep: an offset of {} m is not above {:.3g} m, the resolution of coordinates in a scene of this size; choose a greater offset",
        offset_m, least);
  }
  return {};
}

double percent_of(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

SweepMethod::Triangles SweepMethod::gather(const TouchScene& scene, std::vector<std::array<Vec3, 3>>& corners) {
  Triangles all;
  for (const TouchObject& object : scene.objects) {
    const auto id = static_cast<std::uint32_t>(all.materials.size());
    all.materials.push_back(object.material);
    for (std::size_t t = 0; t < object.mesh->triangles.size(); ++t) {
      const std::array<Vec3, 3> at = {object.mesh->corner(t, 0), object.mesh->corner(t, 1), object.mesh->corner(t, 2)};
      const auto plane = compute_triangle_plane(at[0], at[1], at[2]);
      if (!plane) {
        ++all.degenerate;
        continue;
      }
      corners.push_back(at);
      all.planes.push_back(*plane);
      all.object_of.push_back(id);
    }
  }
  return all;
}

Result<std::unique_ptr<ForceMethod>> SweepMethod::make(const MethodSettings& settings, const TouchScene& scene) {
  if (settings.probe_radius_m != 0.0) {
    return fail("sweep: its probe is a point and cannot have a radius of {} m; leave the radius at 0 or choose another method",
                settings.probe_radius_m);
  }
  std::vector<std::array<Vec3, 3>> corners;
  Triangles all = gather(scene, corners);
  if (all.planes.empty()) {
    return fail("sweep: the scene has no triangle with an area ({} without one); give a mesh that can be touched", all.degenerate);
  }
  auto grid = UniformGrid::make(corners, settings.grid_division);
  if (!grid) return tl::unexpected(grid.error());
  if (auto checked = check_offset(settings.offset_m, *grid); !checked) return tl::unexpected(checked.error());
  return std::unique_ptr<ForceMethod>(new SweepMethod(std::move(*grid), std::move(all), settings.offset_m));
}

// Clamps a device farther out than a billion scene sizes to that distance, so that products stay finite.
Vec3 SweepMethod::within_limits(const Vec3& p_SD) const noexcept {
  constexpr double kHuge = 1e300;  // replaces a coordinate that would overflow
  const Vec3 centre = 0.5 * (grid_.low() + grid_.high());
  const double farthest = 0x1p30 * (grid_.high() - grid_.low()).maxCoeff();
  const Vec3 out = p_SD.cwiseMax(-kHuge).cwiseMin(kHuge) - centre;
  const double most = out.cwiseAbs().maxCoeff();
  return most > farthest ? Vec3(centre + out * (farthest / most)) : p_SD;
}

void SweepMethod::reset(const Vec3& p_SD) noexcept {
  has_started_ = p_SD.allFinite();
  line_start_ = has_started_ ? within_limits(p_SD) : Vec3::Zero();
}

MethodOutput SweepMethod::step(const MethodInput& input) noexcept {
  if (!input.p_SD.allFinite()) return {.force_n = Vec3::Zero(), .p_SP = line_start_, .contact = false};
  if (!has_started_) reset(input.p_SD);
  const Vec3 p_SD = within_limits(input.p_SD);
  const Deepest deepest = find_deepest({.last = line_start_, .current = p_SD});
  ++steps_;
  if (!deepest.found) {
    line_start_ = p_SD;
    return {.force_n = Vec3::Zero(), .p_SP = input.p_SD};
  }

  // The probe is below the surface. The memo's figure 4: the offset vector puts the start of the next line slightly above the collision
  // point, on the side that the probe came from, so that the next line crosses the surface again as long as the probe stays below.
  const SweepCollision& hit = deepest.collision;
  line_start_ = hit.point + offset_m_ * hit.normal;
  const std::uint32_t object = triangles_.object_of[deepest.triangle];
  const Vec3 force_n = triangles_.materials[object].stiffness_n_per_m * hit.depth * hit.normal;
  const bool pushes = force_n != Vec3::Zero();
  return {.force_n = force_n, .p_SP = hit.point, .contact = pushes, .object = pushes ? static_cast<int>(object) : -1};
}

void SweepMethod::set_materials(std::span<const Material> materials) noexcept {
  std::copy_n(materials.begin(), std::min(materials.size(), triangles_.materials.size()), triangles_.materials.begin());
}

SweepMethod::Deepest SweepMethod::find_deepest(const SweepLine& line) noexcept {
  stamps_.start();
  Deepest deepest;
  const CellBox box = grid_.find_cells(line.last.cwiseMin(line.current), line.last.cwiseMax(line.current));
  for (int z = box.begin[2]; z < box.end[2]; ++z) {
    for (int y = box.begin[1]; y < box.end[1]; ++y) {
      for (int x = box.begin[0]; x < box.end[0]; ++x) {
        test_cell(line, grid_.triangles_in(x, y, z), deepest);
      }
    }
  }
  return deepest;
}

void SweepMethod::test_cell(const SweepLine& line, std::span<const std::uint32_t> triangles, Deepest& deepest) noexcept {
  ++counters_.cells_visited;
  if (triangles.empty()) {
    ++counters_.empty_cells;
    return;
  }
  for (const std::uint32_t triangle : triangles) {
    if (stamps_.first_visit(triangle)) {
      test_triangle(line, triangle, deepest);
    } else {
      ++counters_.repeated_triangles;
    }
  }
}

void SweepMethod::test_triangle(const SweepLine& line, std::uint32_t triangle, Deepest& deepest) noexcept {
  ++counters_.triangles_tested;
  SweepCollision collision;
  switch (compute_collision(line, triangles_.planes[triangle], collision)) {
    case SweepOutcome::parallel:
      ++counters_.parallel;
      return;
    case SweepOutcome::out_of_length:
      ++counters_.out_of_length;
      return;
    case SweepOutcome::out_of_triangle:
      ++counters_.out_of_triangle;
      return;
    case SweepOutcome::collision:
      break;
  }
  if (collision.from_behind && !triangles_.materials[triangles_.object_of[triangle]].two_sided) {
    ++counters_.from_behind;
    return;
  }
  ++counters_.collisions;
  // The collision with the largest part of the line beyond it is the first one on the line. Triangles that share the point (an edge, a
  // vertex) are ordered by depth along the normal, then by number, so the order of the cells does not matter.
  const auto rank = [](const SweepCollision& c, std::uint32_t id) { return std::tuple(c.t, -c.depth, id); };
  if (!deepest.found || rank(collision, triangle) < rank(deepest.collision, deepest.triangle)) {
    deepest = {.collision = collision, .triangle = triangle, .found = true};
  }
}

std::string SweepMethod::describe() const {
  const GridOccupancy& occupancy = grid_.occupancy();
  std::string text = fmt::format(
      "sweep: {} triangles of {} object{}, {} degenerate left out, offset {:.4g} m\n"
      "grid: {} x {} x {} cells of {:.4g} x {:.4g} x {:.4g} m, {:.2f} % occupied, {:.2f} triangles an occupied cell on average, {} at "
      "most\n",
      triangles_.planes.size(), triangles_.materials.size(), triangles_.materials.size() == 1 ? "" : "s", triangles_.degenerate, offset_m_,
      grid_.division()[0], grid_.division()[1], grid_.division()[2], (grid_.high()[0] - grid_.low()[0]) / grid_.division()[0],
      (grid_.high()[1] - grid_.low()[1]) / grid_.division()[1], (grid_.high()[2] - grid_.low()[2]) / grid_.division()[2],
      100.0 * occupancy.occupied_share(), occupancy.mean_triangles_a_cell(), occupancy.max_triangles_a_cell);
  if (steps_ > 0) {
    const double n = static_cast<double>(steps_);
    text += fmt::format("steps: {}, {:.2f} cells and {:.2f} triangles tested a step\n", steps_,
                        static_cast<double>(counters_.cells_visited) / n, static_cast<double>(counters_.triangles_tested) / n);
    text += fmt::format(
        "early ends: step 1 {:.1f} % of cells empty; of triangles tested: step 2 {:.1f} % parallel, step 3 {:.1f} % out of the line's "
        "length, step 4 {:.1f} % out of the triangle, step 5 {} collisions{}\n",
        percent_of(counters_.empty_cells, counters_.cells_visited), percent_of(counters_.parallel, counters_.triangles_tested),
        percent_of(counters_.out_of_length, counters_.triangles_tested), percent_of(counters_.out_of_triangle, counters_.triangles_tested),
        counters_.collisions,
        counters_.from_behind > 0 ? fmt::format(", {} more rejected: with the back of a one-sided triangle", counters_.from_behind) : "");
  }
  return text;
}

}  // namespace hapton
