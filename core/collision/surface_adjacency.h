#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/large_vector.h"
#include "core/collision/wide_bvh.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// The triangle side adjacent to each edge of a mesh, and the triangles on which adjacency alone suffices to follow a point.
//
// A triangle has two sides, front (its vertices run counter-clockwise) and back. Seen from one side, the adjacent side at an edge belongs
// to the other triangle there; at a boundary edge it is the other side of the same triangle. An edge of three or more triangles has no
// adjacent sides.
//
// A triangle is walkable if a point on either side of it can meet only the adjacent triangles and those at its vertices: each edge has at
// most two triangles; each vertex has one fan, in which no triangle repeats a vertex; its height is at least kMinHeight; no other triangle
// intersects it or comes nearer than `margin`; and none that shares a vertex with it comes nearer than kMinAngle elsewhere.
//
// Frame and units: those of the vertices, whose extent is about 1. Threads: immutable except for mark_unwalkable. RT: queries yes;
// construction, find_walkable and mark_unwalkable set-up only.
class SurfaceAdjacency {
 public:
  static constexpr int kMaxValence = 4096;  // most triangles at a vertex; with more they are not walkable, which bounds the work
  static constexpr int kLargeFan = 64;      // triangles at a vertex; with more, not every pair of them is compared
  static constexpr double kMinAngle =
      0x1p-20;  // rad, seen from a shared vertex: below it, rounding could decide which triangle is hit first
  static constexpr double kMinHeight = 0x1p-36;  // of a walkable triangle: far above the distance at which a point snaps to a vertex

  struct Adjacent {
    std::uint32_t triangle = 0;
    int edge = 0;        // number of the shared edge in the adjacent triangle
    bool flips = false;  // the side adjacent to this triangle's front is a back
    bool exists = false;
  };

  SurfaceAdjacency() = default;
  // Computes adjacency only; no triangle is walkable before find_walkable. Linear in the mesh.
  SurfaceAdjacency(std::size_t vertex_count, std::span<const Triangle> triangles);

  // Edge k of triangle t runs from its corner k to the next.
  Adjacent adjacent(std::uint32_t t, int k) const {
    const std::uint32_t code = sides_[t].adjacent[static_cast<std::size_t>(k)];
    return {code >> 3, static_cast<int>(code >> 1 & 3U), (code & 1U) != 0, code != kNone};
  }
  bool is_walkable(std::uint32_t t) const { return sides_[t].is_walkable != 0; }
  bool has_large_fans() const { return has_large_fans_; }
  // Whether the triangle has a vertex at which more than kLargeFan triangles meet.
  bool is_in_large_fan(std::uint32_t t) const { return has_large_fans_ && sides_[t].fan != 0; }
  // The corner of the triangle at the vertex of its large fan, if that is closed and convex as seen from the front or the back: none of its
  // faces is above the plane of another, within rounding. -1: there is no such fan, or a triangle of it is in several large fans.
  int convex_fan_corner(std::uint32_t t, bool back) const {
    if (!has_large_fans_ || (sides_[t].fan & (back ? kConvexBack : kConvexFront)) == 0) return -1;
    return sides_[t].fan & kFanCorner;
  }
  void mark_unwalkable(std::uint32_t t) { sides_[t].is_walkable = 0; }
  void prefetch(std::uint32_t t) const { __builtin_prefetch(&sides_[t]); }
  std::size_t walkable_count() const;
  std::size_t bytes() const { return sides_.capacity() * sizeof(Sides); }

  // Determines the walkable triangles. `tree` is over the triangles' boxes, item t is triangle t. Returns the number of pairs that were
  // tested; a vertex of many triangles hardly adds to it.
  std::size_t find_walkable(std::span<const Vec3> vertices, std::span<const Triangle> triangles, const WideBvh& tree, double margin);

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  static constexpr std::uint16_t kFanCorner = 3;  // mask of the number of the corner at the fan's vertex
  static constexpr std::uint16_t kLarge = 4;
  static constexpr std::uint16_t kConvexFront = 8;
  static constexpr std::uint16_t kConvexBack = 16;
  static constexpr std::uint16_t kSeveral = 32;  // in more than one large fan

  void pair_edges(std::size_t vertex_count, std::span<const Triangle> triangles);
  // What the triangles at a vertex form.
  enum class Fan : std::uint8_t {
    broken,    // not one fan, or too many triangles
    whole,     // one fan
    compared,  // broken or whole; its triangles have been compared with each other
    even  // one closed fan whose triangles do not overlap, seen along their mean normal: no two are near each other except at a common edge
  };
  struct Fans {
    std::vector<Fan> of_vertex;
    std::vector<std::uint32_t> large;  // vertices of more than kLargeFan triangles
  };
  Fans find_fans(std::span<const Vec3> vertices, std::span<const Triangle> triangles) const;
  Fans find_even_fans(std::span<const Vec3> vertices, std::span<const Triangle> triangles) const;
  std::size_t compare_in_large_fans(std::span<const Vec3> vertices, std::span<const Triangle> triangles, double margin, Fans& fans);
  void mark_large_fan(std::uint32_t vertex, std::span<const std::uint32_t> around, std::span<const Triangle> triangles);
  void mark_convex_fan(std::span<const std::uint32_t> around, std::span<const Vec3> vertices, std::span<const Triangle> triangles);
  std::size_t compare_at(std::uint32_t vertex, std::span<const std::uint32_t> around, std::span<const Vec3> vertices,
                         std::span<const Triangle> triangles, double margin);
  bool is_whole_fan(std::span<const Triangle> triangles, std::uint32_t start, int corner, std::uint32_t valence) const;

  // What is known of one triangle's sides, in a single cache line.
  struct alignas(16) Sides {
    std::array<std::uint32_t, 3> adjacent{kNone, kNone, kNone};  // (adjacent triangle << 3) | (its edge << 1) | flips
    std::uint16_t is_walkable = 0;
    std::uint16_t fan = 0;  // the large fan that the triangle is in, as bits: kFanCorner, kLarge and the next three
  };
  LargeVector<Sides> sides_;
  bool has_large_fans_ = false;
};

// Whether two triangles of a mesh leave each other walkable: they are apart, except at a vertex or an edge that they share. RT: yes.
bool is_pair_walkable(std::span<const Vec3> vertices, const Triangle& s, const Triangle& t, double margin) noexcept;

// True if two triangles that share no vertex are certainly farther apart than `margin`. RT: yes.
bool are_apart(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b, double margin) noexcept;

}  // namespace hapton
