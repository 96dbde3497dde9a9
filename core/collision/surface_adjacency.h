#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/collision/wide_bvh.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Which triangle side lies across each edge of a mesh, and where a point on the surface can be followed by that alone.
//
// A triangle has two sides, front (its vertices run counter-clockwise) and back. Seen from one side, the neighbour across an edge is a side
// of the other triangle there; across a boundary edge it is the other side of the same triangle. An edge of three and more triangles has
// no neighbours here.
//
// A triangle is walkable when a point on either side of it can meet nothing but the neighbours across its edges and the triangles round its
// vertices: every edge has at most two triangles, every vertex one fan of them and none that repeats a vertex, no other triangle intersects
// it or comes nearer than `margin`, and no two that share a vertex come nearer than kLeastAngle to each other.
//
// Frame and units: those of the vertices, whose extent is about 1.
// Threads: immutable but for mark_unwalkable. RT: queries yes; construction, find_walkable and mark_unwalkable set-up only.
class SurfaceAdjacency {
 public:
  static constexpr int kMostValence = 4096;        // triangles round a vertex: more, and it is not walkable: bounds the work at a vertex
  static constexpr double kLeastAngle = 0x1p-20;   // rad, as seen from a shared vertex: nearer, and rounding could decide what is hit first
  static constexpr double kLeastHeight = 0x1p-36;  // of a triangle: far above the distance within which a point is taken to be at a vertex

  struct Across {
    std::uint32_t triangle = 0;
    int edge = 0;        // its own number of the shared edge
    bool flips = false;  // the neighbour of the front is its back
    bool exists = false;
  };

  SurfaceAdjacency() = default;
  // Only the neighbours; until find_walkable nothing is walkable. Linear in the mesh.
  SurfaceAdjacency(std::size_t vertex_count, std::span<const Triangle> triangles);

  // Edge k of triangle t runs from its corner k to the next.
  Across across(std::uint32_t t, int k) const {
    const std::uint32_t code = across_[3 * std::size_t{t} + static_cast<std::size_t>(k)];
    return {code >> 3, static_cast<int>(code >> 1 & 3U), (code & 1U) != 0, code != kNone};
  }
  bool is_walkable(std::uint32_t t) const { return walkable_[t] != 0; }
  void mark_unwalkable(std::uint32_t t) { walkable_[t] = 0; }
  std::size_t walkable_count() const;
  std::size_t bytes() const { return across_.capacity() * sizeof(std::uint32_t) + walkable_.capacity(); }

  // Which triangles are walkable. `tree` is over the triangles' boxes, item t is triangle t.
  void find_walkable(std::span<const Vec3> vertices, std::span<const Triangle> triangles, const WideBvh& tree, double margin);

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  void pair_edges(std::size_t vertex_count, std::span<const Triangle> triangles);
  // What the triangles round a vertex form.
  enum class Fan : std::uint8_t {
    broken,  // not one fan, or too large a one
    whole,   // one fan
    even     // one closed fan that lies side by side seen from above: none of its triangles comes near another but by their common edge
  };
  std::vector<Fan> find_fans(std::span<const Vec3> vertices, std::span<const Triangle> triangles) const;
  std::vector<Fan> find_even_fans(std::span<const Vec3> vertices, std::span<const Triangle> triangles) const;
  bool is_whole_fan(std::span<const Triangle> triangles, std::uint32_t start, int corner, std::uint32_t valence) const;

  std::vector<std::uint32_t> across_;  // (neighbour << 3) | (its edge << 1) | flips
  std::vector<std::uint8_t> walkable_;
};

// Whether two triangles of a mesh leave each other walkable: apart, or apart but for the vertices they share. RT: yes.
bool is_pair_walkable(std::span<const Vec3> vertices, const Triangle& s, const Triangle& t, double margin) noexcept;

// True when two triangles that share no vertex are surely farther apart than `margin`. RT: yes.
bool are_apart(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b, double margin) noexcept;

}  // namespace hapton
