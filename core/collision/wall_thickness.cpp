#include "core/collision/wall_thickness.h"

#include "core/collision/box.h"
#include "core/collision/wide_bvh.h"
#include "core/geometry/mesh_measures.h"

namespace hapton {
namespace {

// Two faces nearer than this share of the mesh's extent count as one: coordinates of mesh files are often single precision, of 24 bits.
constexpr double kSamePlaceShare = 0x1p-20;
// A ray also meets a triangle that it passes by up to this share of the triangle's size, so that none slips between two neighbours. The
// error of barycentric coordinates is a few 2^-52 times the aspect ratio, so triangles may be a million times as long as high.
constexpr double kBeyondEdge = 0x1p-30;

bool share_vertex(const Triangle& s, const Triangle& t) {
  for (const std::uint32_t v : s) {
    if (v == t[0] || v == t[1] || v == t[2]) return true;
  }
  return false;
}

// Rays through the walls of one mesh. The tree is in coordinates of about 1, as it requires.
class WallRays {
 public:
  explicit WallRays(const TriangleMesh& mesh)
      : mesh_(mesh), bounds_(compute_bounds(mesh)), tree_(mesh.triangles.size(), [&](std::size_t t) { return box_of(t); }) {}

  double extent() const { return bounds_.extent(); }

  Vec3 normal(std::size_t t) const {
    const Vec3 across = (mesh_.corner(t, 1) - mesh_.corner(t, 0)).cross(mesh_.corner(t, 2) - mesh_.corner(t, 0));
    const double length = across.norm();
    return length > 0.0 ? Vec3(across / length) : Vec3(Vec3::Zero());
  }

  // The thickness of the wall behind the point p of triangle `from`, if it is less than width. Nothing: there is no wall, or a thicker one.
  std::optional<double> measure(std::uint32_t from, const Vec3& p, const Vec3& inward, double width) const {
    double nearest = width;
    std::uint32_t hit_triangle = from;
    tree_.visit_along(to_unit(p), inward * (width / extent()), 0.0, 1.0, [&](std::uint32_t t, double until) {
      if (share_vertex(mesh_.triangles[from], mesh_.triangles[t])) return until;
      const auto hit = find_ray_hit(p, inward, nearest, mesh_.corner(t, 0), mesh_.corner(t, 1), mesh_.corner(t, 2));
      if (!hit || *hit <= kSamePlaceShare * extent()) return until;
      nearest = *hit;
      hit_triangle = t;
      return std::min(until, nearest / width);
    });
    const bool is_wall = hit_triangle != from && normal(hit_triangle).dot(inward) >= kWallCosine;
    return is_wall ? std::optional(nearest) : std::nullopt;
  }

 private:
  Vec3 to_unit(const Vec3& p) const { return (p - bounds_.centre()) / bounds_.extent(); }
  Box box_of(std::size_t t) const {
    Box box;
    for (int k = 0; k < 3; ++k) box.grow(to_unit(mesh_.corner(t, k)));
    return box;
  }

  const TriangleMesh& mesh_;
  MeshBounds bounds_;
  WideBvh tree_;
};

}  // namespace

// Möller & Trumbore (1997), with the edges moved outwards by kBeyondEdge.
std::optional<double> find_ray_hit(const Vec3& p, const Vec3& direction, double max_distance, const Vec3& a, const Vec3& b,
                                   const Vec3& c) noexcept {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 across = direction.cross(ac);
  const double determinant = ab.dot(across);
  if (determinant == 0.0) return std::nullopt;
  const Vec3 to_p = p - a;
  const double u = to_p.dot(across) / determinant;
  const Vec3 along = to_p.cross(ab);
  const double v = direction.dot(along) / determinant;
  if (!(u >= -kBeyondEdge && v >= -kBeyondEdge && u + v <= 1.0 + kBeyondEdge)) return std::nullopt;
  const double distance = ac.dot(along) / determinant;
  return distance > 0.0 && distance < max_distance ? std::optional(distance) : std::nullopt;
}

ThinWalls find_thin_walls(const TriangleMesh& mesh, double width) {
  ThinWalls found;
  if (mesh.triangles.empty()) return found;
  const WallRays rays(mesh);
  if (!(rays.extent() > 0.0)) return found;
  // At twice the extent, every ray has left the mesh.
  const double longest = std::min(width, 2.0 * rays.extent());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 normal = rays.normal(t);
    if (normal.isZero(0.0)) continue;
    bool is_thin = false;
    for_each_thickness_sample(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), width, [&](const Vec3& p) {
      const auto thickness = rays.measure(t, p, -normal, longest);
      if (!thickness) return;
      is_thin = true;
      if (!found.thinnest || *thickness < found.thinnest->thickness) found.thinnest = {t, p, *thickness};
    });
    found.triangles += is_thin ? 1 : 0;
  }
  return found;
}

}  // namespace hapton
