#include "core/collision/object_geometry.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/geometry/corner_normals.h"
#include "core/geometry/touch_resolution.h"

namespace hapton {
namespace {

constexpr double kGrid = 0x1p-51;  // local units; the difference of two coordinates on this grid is exact (decision 4)

Vec3 rounded_to_grid(const Vec3& p) { return (p / kGrid).array().round() * kGrid; }

}  // namespace

ObjectGeometry::ObjectGeometry(const TriangleMesh& mesh, const LocalFrame& frame, std::optional<double> shading_crease_rad,
                               std::vector<std::uint32_t>* new_vertex_numbers) {
  LargeVector<Vec3> vertices;
  vertices.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) vertices.push_back(rounded_to_grid(frame.to_local(v)));
  auto surface = std::make_shared<Surface>();
  surface->tree = WideBvh(mesh.triangles.size(), [&](std::size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    return Box::around(vertices[a], vertices[b], vertices[c]);
  });

  // Triangles in tree order, vertices in the order of their first use: what is near in space is near in memory.
  const LargeVector<std::uint32_t> order = surface->tree.items_in_tree_order();
  std::vector<std::uint32_t> new_vertex(vertices.size(), kUnused);
  LargeVector<std::uint32_t> new_triangle(mesh.triangles.size());
  surface->vertices.reserve(vertices.size());
  surface->triangles.reserve(mesh.triangles.size());
  for (const std::uint32_t old : order) {
    new_triangle[old] = static_cast<std::uint32_t>(surface->triangles.size());
    Triangle t = mesh.triangles[old];
    for (std::uint32_t& v : t) {
      if (new_vertex[v] == kUnused) {
        new_vertex[v] = static_cast<std::uint32_t>(surface->vertices.size());
        surface->vertices.push_back(vertices[v]);
      }
      v = new_vertex[v];
    }
    surface->triangles.push_back(t);
  }
  surface->vertices.shrink_to_fit();
  if (new_vertex_numbers != nullptr) *new_vertex_numbers = std::move(new_vertex);
  if (shading_crease_rad) {
    std::vector<std::uint32_t> source(mesh.triangles.size());
    std::iota(source.begin(), source.end(), 0U);
    CornerNormalReport report;
    ShadedMesh shaded = fill_corner_normals(mesh, source, *shading_crease_rad, report);
    use_authored_normals(mesh, shaded);
    repair_corner_normals(shaded);
    for (const Vec3& normal : shaded.normals) surface->normals.push_back(normal.cast<float>());
    for (const std::uint32_t old : order) surface->corner_normals.push_back(shaded.corner_normals[old]);
  }
  surface->tree.renumber_items(new_triangle);
  *this = ObjectGeometry(std::move(surface));
  adjacency_ = SurfaceAdjacency(surface_->vertices.size(), surface_->triangles);
  adjacency_.find_walkable(surface_->vertices, surface_->triangles, surface_->tree, kWalkableMargin);
}

ObjectGeometry::ObjectGeometry(std::shared_ptr<Surface> surface)
    : surface_(std::move(surface)), vertices_(surface_->vertices.data()), triangles_(surface_->triangles.data()) {}

ObjectGeometry ObjectGeometry::make(const TriangleMesh& mesh, const LocalFrame& frame, std::size_t most_triangles,
                                    std::optional<double> shading_crease_rad) {
  ObjectGeometry geometry(mesh, frame, shading_crease_rad);
  if (geometry.is_walkable()) return geometry;
  const std::optional<TriangleMesh> resolved =
      resolve_for_touch(mesh, kResolution * frame.unit_m, SurfaceAdjacency::kMinHeight * frame.unit_m);
  const bool fits = resolved && resolved->triangles.size() <= most_triangles;
  return fits ? ObjectGeometry(*resolved, frame, shading_crease_rad) : std::move(geometry);
}

ObjectGeometry ObjectGeometry::with_origin_at(const Vec3& p) const {
  auto surface = std::make_shared<Surface>();
  const Vec3 origin = rounded_to_grid(p);
  surface->vertices.reserve(vertices().size());
  for (const Vec3& v : vertices()) surface->vertices.push_back(v - origin);
  surface->triangles = surface_->triangles;
  surface->normals = surface_->normals;
  surface->corner_normals = surface_->corner_normals;
  ObjectGeometry other(std::move(surface));
  other.adjacency_ = adjacency_;
  return other;
}

// Rounds to the grid: the doubles in [2, 4) are the multiples of 2^-51.
void ObjectGeometry::move_vertex(std::uint32_t vertex, const Vec3& local) noexcept { vertices_[vertex] = (local.array() + 3.0) - 3.0; }

// The margin of the search exceeds that of the pair test by far more than the rounding of single-precision trees, so no pair is missed.
std::vector<std::uint32_t> ObjectGeometry::find_near(const ObjectGeometry& other, const Box& bounds) const {
  constexpr double kTreeRounding = 0x1p-18;  // 64 times the 2^-24 of single precision
  std::vector<std::uint32_t> near;
  if (bounds.is_empty()) return near;
  const double size = std::max({1.0, bounds.low.cwiseAbs().maxCoeff(), bounds.high.cwiseAbs().maxCoeff()});
  std::vector<bool> is_near(triangle_count());
  other.tree().for_each_overlapping(bounds.inflated(kWalkableMargin + kTreeRounding * size), [&](std::uint32_t t) {
    const Corners other_corners = other.corners(t);
    tree().for_each_overlapping(
        Box::around(other_corners.a, other_corners.b, other_corners.c).inflated(kWalkableMargin), [&](std::uint32_t u) {
          if (!adjacency_.is_walkable(u) || is_near[u]) return;
          if (are_apart({corner(u, 0), corner(u, 1), corner(u, 2)}, {other_corners.a, other_corners.b, other_corners.c}, kWalkableMargin))
            return;
          is_near[u] = true;
          near.push_back(u);
        });
  });
  return near;
}

void ObjectGeometry::mark_unwalkable(std::span<const std::uint32_t> triangles) {
  for (const std::uint32_t t : triangles) adjacency_.mark_unwalkable(t);
}

void ObjectGeometry::mark_unwalkable_near(const Box& other) {
  tree().for_each_overlapping(other.inflated(kWalkableMargin), [&](std::uint32_t u) { adjacency_.mark_unwalkable(u); });
}

Vec3 ObjectGeometry::smooth_normal(std::uint32_t t, const Vec3& on_triangle) const noexcept {
  if (surface_->corner_normals.empty()) return Vec3::Zero();
  const Vec3& a = corner(t, 0);
  const Vec3& b = corner(t, 1);
  const Vec3& c = corner(t, 2);
  const Vec3 normal = accurate_cross(b - a, c - a);
  const double area_squared = normal.squaredNorm();
  if (!(area_squared > 0.0)) return Vec3::Zero();
  const double v = std::clamp(normal.dot((on_triangle - a).cross(c - a)) / area_squared, 0.0, 1.0);
  const double w = std::clamp(normal.dot((b - a).cross(on_triangle - a)) / area_squared, 0.0, 1.0 - v);
  const auto& [i, j, k] = surface_->corner_normals[t];
  const auto& normals = surface_->normals;
  const Vec3 mixed = (1.0 - v - w) * normals[i].cast<double>() + v * normals[j].cast<double>() + w * normals[k].cast<double>();
  const double length = mixed.norm();
  return length > 0.0 ? Vec3(mixed / length) : Vec3::Zero();
}

std::size_t ObjectGeometry::bytes() const {
  const Surface& s = *surface_;
  return s.tree.bytes() + adjacency_.bytes() + s.vertices.size() * sizeof(Vec3) + s.triangles.size() * sizeof(Triangle) +
         s.normals.size() * sizeof(Eigen::Vector3f) + s.corner_normals.size() * sizeof(Triangle);
}

}  // namespace hapton
