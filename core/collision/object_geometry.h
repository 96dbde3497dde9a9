#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/large_vector.h"
#include "core/collision/surface_adjacency.h"
#include "core/collision/wide_bvh.h"
#include "core/geometry/point_triangle.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// The coordinates of all contact computation: p_local = (p_S - origin) / unit_m, where unit_m is the power of two that puts the scene's
// diagonal into [1, 2). A mesh of a micrometre and one of a thousand kilometres, wherever they are, have the same local coordinates, so
// every tolerance can be a plain number.
struct LocalFrame {
  Vec3 origin = Vec3::Zero();
  double unit_m = 1.0;

  Vec3 to_local(const Vec3& p_S) const { return (p_S - origin) / unit_m; }
  Vec3 to_scene(const Vec3& local) const { return local * unit_m + origin; }
};

// One mesh prepared for contact: local coordinates, triangles in tree order, a bounding volume tree.
//
// Coordinates are rounded to a grid of 2^-51. Two such coordinates subtract exactly, so edges are exact and the normals of the thinnest
// slivers keep their direction (point_triangle.h).
//
// Copies share coordinates, triangles and tree, and differ in the marks of what is not walkable.
// Threads: immutable once in use, except a surface that deforms: only one thread may use that. RT: queries, move_vertex and swap_tree yes;
// construction, copies, with_origin_at(), bounds(), find_near and mark_unwalkable(_near) set-up only.
class ObjectGeometry {
 public:
  // Local units. Any other part of the surface is at least this far from a walkable triangle (surface_adjacency.h).
  static constexpr double kWalkableMargin = 0x1p-26;
  // Local units. make() seals cracks up to this width, if most_triangles suffice: at cracks a point probe is a sphere of radius 2^-31, half
  // a contact offset, and could be caught between the two boundaries of a crack.
  static constexpr double kResolution = 0x1p-27;

  // shading_crease_rad: if set, smooth normals are kept too: the mesh's authored ones where they are valid, otherwise computed ones; edges
  // with a larger angle between the faces' normals stay sharp (corner_normals.h).
  // new_vertex: if not null, is set to the number in this object of each vertex of the mesh, kUnused where no triangle uses the vertex.
  static constexpr std::uint32_t kUnused = 0xFFFFFFFFU;
  ObjectGeometry(const TriangleMesh& mesh, const LocalFrame& frame, std::optional<double> shading_crease_rad = std::nullopt,
                 std::vector<std::uint32_t>* new_vertex = nullptr);
  // The same, but if not all is walkable, features finer than kResolution are removed (touch_resolution.h), if most_triangles suffice.
  static ObjectGeometry make(const TriangleMesh& mesh, const LocalFrame& frame, std::size_t most_triangles,
                             std::optional<double> shading_crease_rad = std::nullopt);

  // The same surface with the origin at p, in the same local units. Its tree is empty: this is for a tool, whose tree is never searched.
  ObjectGeometry with_origin_at(const Vec3& p) const;

  std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(surface_->triangles.size()); }
  std::size_t bytes() const;
  const WideBvh& tree() const { return surface_->tree; }
  const Triangle& triangle(std::uint32_t t) const { return triangles_[t]; }
  std::span<const Vec3> vertices() const { return surface_->vertices; }
  Box bounds() const { return Box::of(vertices()); }  // computed anew by each call; RT: no
  const Vec3& corner(std::uint32_t t, int k) const { return vertices_[triangles_[t][k]]; }
  struct Corners {
    const Vec3& a;
    const Vec3& b;
    const Vec3& c;
    const Triangle& vertices;  // indices in this object
  };
  Corners corners(std::uint32_t t) const {
    const Triangle& v = triangles_[t];
    return {vertices_[v[0]], vertices_[v[1]], vertices_[v[2]], v};
  }
  Separation separation(std::uint32_t t, const Vec3& p) const {
    const Triangle& corners = triangles_[t];
    return separation_from_triangle(p, vertices_[corners[0]], vertices_[corners[1]], vertices_[corners[2]]);
  }

  // For a surface that deforms. Moves a vertex to these local coordinates, rounded to the grid. Boxes of the tree stay: while a triangle
  // is not within its box, a query may miss it. Pre: each coordinate is within -1 and 1; the surface is not shared with a copy.
  void move_vertex(std::uint32_t vertex, const Vec3& local) noexcept;
  // Exchanges the tree for another one over the same items, with other boxes.
  void swap_tree(WideBvh& other) noexcept { std::swap(surface_->tree, other); }
  // Whether every triangle is walkable: then no gap is narrower than kWalkableMargin, and make() has nothing to remove.
  bool is_walkable() const { return adjacency_.walkable_count() == triangle_count(); }

  const SurfaceAdjacency& adjacency() const { return adjacency_; }
  // Makes triangles near the box of another object unwalkable, for an object that is not built yet. The objects may overlap.
  void mark_unwalkable_near(const Box& other);
  // The walkable triangles that another object makes unwalkable, in any order. bounds: a box around this object. Work: one search for each
  // triangle of the other object that is near these bounds.
  std::vector<std::uint32_t> find_near(const ObjectGeometry& other, const Box& bounds) const;
  void mark_unwalkable(std::span<const std::uint32_t> triangles);

  // The smooth unit normal at a point of triangle t, interpolated between its corners; zero if no normals were kept or none results.
  Vec3 smooth_normal(std::uint32_t t, const Vec3& on_triangle) const noexcept;

  // To prefetch a triangle, call this for its indices first, and prefetch_corners() some time later.
  void prefetch_indices(std::uint32_t t) const { __builtin_prefetch(&triangles_[t]); }
  // To prefetch what a walk over edge k of a triangle reads, call this for the triangle beyond the edge, later prefetch_opposite().
  void prefetch_across(std::uint32_t t, int k) const {
    const SurfaceAdjacency::Adjacent across = adjacency_.adjacent(t, k);
    if (!across.exists) return;
    adjacency_.prefetch(across.triangle);
    prefetch_indices(across.triangle);
  }
  void prefetch_opposite(std::uint32_t t, int k) const {
    const SurfaceAdjacency::Adjacent across = adjacency_.adjacent(t, k);
    if (across.exists) __builtin_prefetch(&vertices_[triangles_[across.triangle][(across.edge + 2) % 3]]);
  }
  void prefetch_corners(std::uint32_t t) const {
    for (const std::uint32_t v : triangles_[t]) __builtin_prefetch(&vertices_[v]);
  }

 private:
  struct Surface {
    LargeVector<Vec3> vertices;
    LargeVector<Triangle> triangles;
    std::vector<Eigen::Vector3f> normals;
    std::vector<Triangle> corner_normals;  // indices into normals, per corner
    WideBvh tree{std::span<const Box>{}};
  };

  explicit ObjectGeometry(std::shared_ptr<Surface> surface);

  std::shared_ptr<Surface> surface_;  // shared by all copies
  Vec3* vertices_ = nullptr;          // like the next, the surface's data: saves queries an indirection
  const Triangle* triangles_ = nullptr;
  SurfaceAdjacency adjacency_;
};

}  // namespace hapton
