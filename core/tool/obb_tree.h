#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/large_vector.h"
#include "core/collision/touch_geometry.h"

namespace hapton {

// A binary tree of oriented boxes over triangles, one triangle a leaf (Gottschalk, Lin & Manocha, "OBBTree", 1996). A box along the
// principal axes of a smooth piece of surface is thin: its thickness is of the order of the square of the piece's size, whereas a box along
// the coordinate axes is about as thick as the piece is large. So few pairs of such boxes show that two almost parallel surfaces are apart.
//
// We differ in where a piece is split: at the median, or, if it is small and has sharp edges, where the halves become flattest. Neither
// half has less than an eighth of the triangles, which bounds the depth. Boxes are stored in single precision and contain the exact corners
// of their triangles. Threads: immutable. RT: queries yes, construction set-up only.
class ObbTree {
 public:
  static constexpr int kMaxDepth = 96;

  // A box: centre + sum of axis[i] * y[i], |y[i]| <= half[i]. The axes are orthonormal to 2^-20.
  struct alignas(64) Node {
    std::array<float, 3> centre;
    std::array<std::array<float, 3>, 3> axes;  // axes[coordinate][axis], from the axis of the shortest extent to that of the longest
    std::array<float, 3> half;
    std::uint32_t link;  // number of the left child (the right one is the next node); of a leaf: ~(its number among the leaves)
    bool is_leaf() const { return (link >> 31) != 0; }
    Vec3 at() const { return {centre[0], centre[1], centre[2]}; }
    Vec3 axis(int i) const { return {axes[0][i], axes[1][i], axes[2][i]}; }
    Vec3 half_size() const { return {half[0], half[1], half[2]}; }
  };

  explicit ObbTree(const ObjectGeometry& surface);
  // The tree of all objects; triangles have TouchGeometry's numbers. Pre: the scene is built.
  explicit ObbTree(const TouchGeometry& scene);
  // The same, from the trees of the objects, joined by boxes along the coordinate axes. Pre: one tree for each object, in order.
  ObbTree(std::span<const ObbTree* const> objects, const TouchGeometry& scene);

  // The tree of the same surface in coordinates with the origin at p. Boxes are larger by the rounding of their centres.
  ObbTree with_origin_at(const Vec3& p) const;
  std::size_t bytes() const { return nodes_.capacity() * sizeof(Node) + triangles_.capacity() * sizeof(std::uint32_t); }

  // Node 0 is the root. Empty if there are no triangles.
  std::span<const Node> nodes() const { return nodes_; }
  // Pre: the node is a leaf.
  std::uint32_t triangle(const Node& leaf) const { return triangles_[~leaf.link]; }
  // The triangle of each leaf, by the leaf's number.
  std::span<const std::uint32_t> triangles() const { return triangles_; }

 private:
  ObbTree() = default;

  LargeVector<Node> nodes_;
  std::vector<std::uint32_t> triangles_;
};

}  // namespace hapton
