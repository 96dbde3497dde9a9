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
// A triangle is walkable if a point on either side of it can meet only the adjacent triangles and those at its vertices: every edge has at
// most two triangles; every vertex has one fan, in which no triangle repeats a vertex; no other triangle intersects it or comes nearer than
// `margin`; and no two that share a vertex come nearer than kLeastAngle to each other.
//
// Frame and units: those of the vertices, whose extent is about 1. Threads: immutable but for mark_unwalkable. RT: queries yes;
// construction, find_walkable and mark_unwalkable set-up only.
class SurfaceAdjacency {
 public:
  static constexpr int kMostValence = 4096;  // triangles at a vertex; with more it is not walkable, which bounds the work there
  static constexpr double kLeastAngle =
      0x1p-20;  // rad, seen from a shared vertex: below it, rounding could decide which triangle is hit first
  static constexpr double kLeastHeight = 0x1p-36;  // of a triangle: far above the distance within which a point snaps to a vertex

  struct Adjacent {
    std::uint32_t triangle = 0;
    int edge = 0;        // the adjacent triangle's number of the shared edge
    bool flips = false;  // the adjacent side of the front is a back
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
  void mark_unwalkable(std::uint32_t t) { sides_[t].is_walkable = 0; }
  void prefetch(std::uint32_t t) const { __builtin_prefetch(&sides_[t]); }
  std::size_t walkable_count() const;
  std::size_t bytes() const { return sides_.capacity() * sizeof(Sides); }

  // Determines the walkable triangles. `tree` is over the triangles' boxes, item t is triangle t.
  void find_walkable(std::span<const Vec3> vertices, std::span<const Triangle> triangles, const WideBvh& tree, double margin);

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  void pair_edges(std::size_t vertex_count, std::span<const Triangle> triangles);
  // What the triangles at a vertex form.
  enum class Fan : std::uint8_t {
    broken,  // not one fan, or too many triangles
    whole,   // one fan
    even     // one closed fan whose triangles do not overlap as seen from above: no two of them are near each other except at a common edge
  };
  std::vector<Fan> find_fans(std::span<const Vec3> vertices, std::span<const Triangle> triangles) const;
  std::vector<Fan> find_even_fans(std::span<const Vec3> vertices, std::span<const Triangle> triangles) const;
  bool is_whole_fan(std::span<const Triangle> triangles, std::uint32_t start, int corner, std::uint32_t valence) const;

  // Of one triangle, together in a cache line.
  struct alignas(16) Sides {
    std::array<std::uint32_t, 3> adjacent{kNone, kNone, kNone};  // (adjacent triangle << 3) | (its edge << 1) | flips
    std::uint32_t is_walkable = 0;
  };
  LargeVector<Sides> sides_;
};

// Whether two triangles of a mesh leave each other walkable: apart, or apart except for the vertices they share. RT: yes.
bool is_pair_walkable(std::span<const Vec3> vertices, const Triangle& s, const Triangle& t, double margin) noexcept;

// True if two triangles that share no vertex are certainly farther apart than `margin`. RT: yes.
bool are_apart(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b, double margin) noexcept;

}  // namespace hapton
