#include "vision_node/teach_shapes.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_curvature.h"
#include "vision_node/hull_edges.h"

namespace hapton {
namespace {

constexpr TeachColour kTouched = {255, 190, 40};
constexpr TeachColour kPlane = {120, 200, 255};
constexpr TeachColour kNormal = {90, 230, 120};
constexpr TeachColour kPenetration = {240, 80, 70};
constexpr TeachColour kSet = {120, 200, 255};
constexpr TeachColour kFan = {255, 120, 220};  // triangles of the local set that carry normals across an edge
constexpr TeachColour kHull = {255, 200, 90};
constexpr TeachColour kCell = {120, 200, 255};
constexpr TeachColour kHere = {255, 255, 255};  // the hull or cell that contains the proxy
constexpr TeachColour kNotKnown = {230, 210, 60};
// Share of the scene's diagonal: a triangle counts as in contact up to this distance from the probe. The gap that methods keep is smaller.
constexpr double kContactShare = 2e-4;
// Share of the scene's diagonal: half the side of the square that stands for a plane, and the length of a normal. A free choice.
constexpr double kPlaneShare = 0.03;
// Cosine between the normals of two triangles of one flat face: they differ by at most 0.8 degrees. A free choice.
constexpr double kFlatCosine = 0.9999;
// A hull is enlarged by this share of its extents before its edges are found, as a flat hull would have none. A free choice.
constexpr double kHullShare = 1e-6;
// Share of the known curvatures within the colour scale: the curvature computed at a sharp edge is arbitrary (decision 163).
constexpr double kScaleShare = 0.95;

void add_triangle(TeachShapes& shapes, const std::array<Vec3, 3>& corner, const TeachColour& colour) {
  // The interior is darker, so that the edges are visible.
  TeachColour inside = colour;
  for (std::uint8_t& part : inside) part = static_cast<std::uint8_t>(part * 3 / 5);
  shapes.triangles.push_back({corner, {inside, inside, inside}});
  for (std::size_t k = 0; k < 3; ++k) shapes.lines.push_back({corner[k], corner[(k + 1) % 3], colour});
}

void add_plane(TeachShapes& shapes, const Vec3& at, const Vec3& normal, double size) {
  const Vec3 u = size * normal.unitOrthogonal();
  const Vec3 v = size * normal.cross(u / size);
  const std::array<Vec3, 4> corner = {at + u + v, at - u + v, at - u - v, at + u - v};
  for (std::size_t k = 0; k < 4; ++k) shapes.lines.push_back({corner[k], corner[(k + 1) % 4], kPlane});
  shapes.lines.push_back({at, at + size * normal, kNormal});
}

void add_box(TeachShapes& shapes, const Vec3& low, const Vec3& high, const TeachColour& colour) {
  for (const auto& [from, to] :
       find_hull_edges({{Vec3::UnitX(), low.x(), high.x()}, {Vec3::UnitY(), low.y(), high.y()}, {Vec3::UnitZ(), low.z(), high.z()}})) {
    shapes.lines.push_back({from, to, colour});
  }
}

struct Contact {
  SetTriangle triangle;
  ClosestPoint closest;
};

std::vector<Contact> find_contacts(const SmoothScene& scene, const TeachProbe& probe) {
  const double within = probe.radius_m + kContactShare * scene.diagonal();
  std::vector<Contact> found;
  scene.for_each_near(FdhBall{probe.p_SP, within}, [&](const SetTriangle& triangle) {
    if (!is_face(triangle)) return;
    const ClosestPoint closest = closest_point(triangle.corner[0], triangle.corner[1], triangle.corner[2], probe.p_SP);
    if (closest.distance <= within) found.push_back({triangle, closest});
  });
  std::sort(found.begin(), found.end(), [](const Contact& a, const Contact& b) { return a.triangle.before(b.triangle); });
  return found;
}

// The normal of the face, on the side to which the force points; without a force, the penetration vector takes its place.
Vec3 normal_of(const Contact& contact, const TeachProbe& probe) {
  const Vec3 away = probe.force_S_n.squaredNorm() > 0.0 ? probe.force_S_n : Vec3(probe.p_SP - probe.p_SD);
  return away.dot(contact.triangle.face_normal) < 0.0 ? Vec3(-contact.triangle.face_normal) : contact.triangle.face_normal;
}

}  // namespace

TeachShapes make_contact_shapes(const SmoothScene& scene, const TeachProbe& probe) {
  TeachShapes shapes;
  if (!probe.is_contact) {
    shapes.caption = "contact: none";
    return shapes;
  }
  const double size = kPlaneShare * scene.diagonal();
  std::vector<Vec3> normals;
  const std::vector<Contact> contacts = find_contacts(scene, probe);
  for (const Contact& contact : contacts) {
    add_triangle(shapes, contact.triangle.corner, kTouched);
    // Triangles of one flat face are one constraint.
    const Vec3 normal = normal_of(contact, probe);
    if (std::any_of(normals.begin(), normals.end(), [&](const Vec3& known) { return known.dot(normal) > kFlatCosine; })) continue;
    normals.push_back(normal);
    add_plane(shapes, contact.closest.point, normal, size);
  }
  shapes.lines.push_back({probe.p_SP, probe.p_SD, kPenetration});
  shapes.caption =
      fmt::format("contact: {} triangle{}, {} plane{}, penetration {:.2f} mm", contacts.size(), contacts.size() == 1 ? "" : "s",
                  normals.size(), normals.size() == 1 ? "" : "s", 1e3 * (probe.p_SP - probe.p_SD).norm());
  return shapes;
}

TeachShapes make_local_set_shapes(const SmoothScene& scene, const TeachProbe& probe) {
  TeachShapes shapes;
  LocalSet set;
  const auto count = static_cast<std::uint32_t>(std::clamp(probe.set_size, 1, static_cast<int>(LocalSet::kCapacity)));
  scene.select({probe.p_SP, probe.p_SP}, count, set);
  for (std::uint32_t i = 0; i < set.count; ++i) add_triangle(shapes, set.triangles[i].corner, is_face(set.triangles[i]) ? kSet : kFan);
  shapes.caption =
      fmt::format("local set: {} triangles, complete within {:.2f} mm", set.count, 1e3 * std::max(0.0, set.radius_at(probe.p_SP)));
  return shapes;
}

TeachShapes make_tree_shapes(const SmoothScene& scene, const TeachProbe& probe, int level) {
  struct Near {
    double distance_squared;
    std::vector<HullSlab> slabs;
  };
  std::vector<Near> hulls;
  std::size_t count = 0;
  const auto is_nearer = [](const Near& a, const Near& b) { return a.distance_squared < b.distance_squared; };
  scene.for_each_hull(level, [&]<int K>(std::uint32_t, const FdhHull<K>& hull, std::span<const std::uint32_t>) {
    ++count;
    double distance_squared = 0.0;
    double extents = 0.0;  // sum along the three axes
    for (int i = 0; i < 3; ++i) {
      const double out = std::max({hull.low[i] - probe.p_SP[i], probe.p_SP[i] - hull.high[i], 0.0});
      distance_squared += out * out;
      extents += hull.high[i] - hull.low[i];
    }
    std::vector<HullSlab> slabs;
    for (int i = 0; i < K / 2; ++i) {
      const auto& axis = FdhDirections<K>::kAxis[i];
      slabs.push_back({Vec3(axis[0], axis[1], axis[2]), hull.low[i] - kHullShare * extents, hull.high[i] + kHullShare * extents});
    }
    hulls.push_back({distance_squared, std::move(slabs)});
    if (hulls.size() < 2 * kMaxTeachHulls) return;
    std::nth_element(hulls.begin(), hulls.begin() + kMaxTeachHulls, hulls.end(), is_nearer);
    hulls.resize(kMaxTeachHulls);
  });
  if (hulls.size() > kMaxTeachHulls) {
    std::nth_element(hulls.begin(), hulls.begin() + kMaxTeachHulls, hulls.end(), is_nearer);
    hulls.resize(kMaxTeachHulls);
  }
  TeachShapes shapes;
  for (const Near& hull : hulls) {
    const TeachColour colour = hull.distance_squared > 0.0 ? kHull : kHere;
    for (const auto& [from, to] : find_hull_edges(hull.slabs)) shapes.lines.push_back({from, to, colour});
  }
  shapes.caption = fmt::format("tree: level {}, {} hulls{}", level, count,
                               count > hulls.size() ? fmt::format(", the {} nearest are drawn", hulls.size()) : std::string());
  return shapes;
}

Result<UniformGrid> make_teach_grid(const TouchScene& scene) {
  std::vector<std::array<Vec3, 3>> triangles;
  for (const TouchObject& object : scene.objects) {
    for (std::size_t t = 0; t < object.mesh->triangles.size(); ++t) {
      triangles.push_back({object.mesh->corner(t, 0), object.mesh->corner(t, 1), object.mesh->corner(t, 2)});
    }
  }
  return UniformGrid::make(triangles, {kTeachCells, kTeachCells, kTeachCells});
}

TeachShapes make_grid_shapes(const UniformGrid& grid, const TeachProbe& probe) {
  const auto& cells = grid.division();
  const Vec3 size = (grid.high() - grid.low()).cwiseQuotient(Vec3(cells[0], cells[1], cells[2]));
  const auto is_occupied = [&](int x, int y, int z) {
    const bool is_inside = x >= 0 && y >= 0 && z >= 0 && x < cells[0] && y < cells[1] && z < cells[2];
    return is_inside && !grid.triangles_in(x, y, z).empty();
  };
  const auto corner = [&](int x, int y, int z) { return Vec3(grid.low() + size.cwiseProduct(Vec3(x, y, z))); };
  TeachShapes shapes;
  // The edge from a corner along an axis belongs to four cells.
  for (int z = 0; z <= cells[2]; ++z) {
    for (int y = 0; y <= cells[1]; ++y) {
      for (int x = 0; x <= cells[0]; ++x) {
        const Vec3 from = corner(x, y, z);
        if (is_occupied(x, y, z) || is_occupied(x, y - 1, z) || is_occupied(x, y, z - 1) || is_occupied(x, y - 1, z - 1)) {
          if (x < cells[0]) shapes.lines.push_back({from, corner(x + 1, y, z), kCell});
        }
        if (is_occupied(x, y, z) || is_occupied(x - 1, y, z) || is_occupied(x, y, z - 1) || is_occupied(x - 1, y, z - 1)) {
          if (y < cells[1]) shapes.lines.push_back({from, corner(x, y + 1, z), kCell});
        }
        if (is_occupied(x, y, z) || is_occupied(x - 1, y, z) || is_occupied(x, y - 1, z) || is_occupied(x - 1, y - 1, z)) {
          if (z < cells[2]) shapes.lines.push_back({from, corner(x, y, z + 1), kCell});
        }
      }
    }
  }
  const GridOccupancy& full = grid.occupancy();
  shapes.caption = fmt::format("grid: {} of {} cells occupied, {:.1f} triangles a cell, at most {}", full.occupied_cells, full.cells,
                               full.mean_triangles_a_cell(), full.max_triangles_a_cell);
  const CellBox here = grid.find_cells(probe.p_SP, probe.p_SP);
  if (here.begin[0] < here.end[0] && here.begin[1] < here.end[1] && here.begin[2] < here.end[2]) {
    const auto& [x, y, z] = here.begin;
    add_box(shapes, corner(x, y, z), corner(x + 1, y + 1, z + 1), kHere);
    shapes.caption += fmt::format("; the probe's cell: {}", grid.triangles_in(x, y, z).size());
  }
  return shapes;
}

TeachCurvature find_curvature(const TouchScene& scene) {
  TeachCurvature found;
  std::vector<double> sizes;
  for (const TouchObject& object : scene.objects) {
    found.by_object.push_back(compute_mean_curvature(*object.mesh));
    for (const double curvature : found.by_object.back()) {
      if (std::isfinite(curvature)) sizes.push_back(std::abs(curvature));
    }
  }
  if (sizes.empty()) return found;
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(kScaleShare * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  found.limit = *at;
  return found;
}

TeachColour curvature_colour(double curvature, double limit) {
  if (!std::isfinite(curvature)) return kNotKnown;
  const double share = limit > 0.0 ? std::clamp(curvature / limit, -1.0, 1.0) : 0.0;
  const TeachColour& end = share < 0.0 ? TeachColour{40, 80, 230} : TeachColour{220, 40, 40};
  TeachColour colour = {222, 222, 222};
  for (std::size_t k = 0; k < 3; ++k) {
    colour[k] = static_cast<std::uint8_t>(std::lround(colour[k] + std::abs(share) * (static_cast<double>(end[k]) - colour[k])));
  }
  return colour;
}

TeachShapes make_curvature_shapes(const TouchScene& scene, const TeachCurvature& curvature, const TeachProbe& probe) {
  struct Near {
    double distance_squared;
    std::size_t object;
    std::size_t triangle;
  };
  std::vector<Near> all;
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const TriangleMesh& mesh = *scene.objects[o].mesh;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) all.push_back({(mesh.corner(t, 0) - probe.p_SP).squaredNorm(), o, t});
  }
  const std::size_t count = all.size();
  if (count > kMaxTeachTriangles) {
    std::nth_element(all.begin(), all.begin() + kMaxTeachTriangles, all.end(),
                     [](const Near& a, const Near& b) { return a.distance_squared < b.distance_squared; });
    all.resize(kMaxTeachTriangles);
  }
  TeachShapes shapes;
  for (const Near& near : all) {
    const TriangleMesh& mesh = *scene.objects[near.object].mesh;
    TeachTriangle triangle;
    for (int k = 0; k < 3; ++k) {
      triangle.corner[static_cast<std::size_t>(k)] = mesh.corner(near.triangle, k);
      triangle.colour[static_cast<std::size_t>(k)] =
          curvature_colour(curvature.by_object[near.object][mesh.triangles[near.triangle][static_cast<std::size_t>(k)]], curvature.limit);
    }
    shapes.triangles.push_back(triangle);
  }
  shapes.legend = TeachLegend{curvature.limit, "1/m"};
  shapes.caption = fmt::format("mean curvature: red convex, blue concave, yellow not known{}",
                               count > all.size() ? fmt::format("; the {} triangles nearest to the probe", all.size()) : std::string());
  return shapes;
}

}  // namespace hapton
