#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/median_tree.h"
#include "core/math/types.h"

namespace hapton {

// Boxes in a tree: whether one of them contains another box.
//
// Construction takes n log n steps for any input. A query compares the box with about log n others where these lie apart or inside each
// other; where many overlap, with those whose common box contains it. Frame and unit: those of the boxes. RT: set-up only. Threads: one
// (queries count).
class EnclosingBoxes {
 public:
  using Box = Eigen::AlignedBox3d;

  // Pre: not empty boxes, finite.
  explicit EnclosingBoxes(std::vector<Box> boxes);

  // A box contains itself.
  bool contain(const Box& box);
  // Boxes, of the tree's nodes as well, that were compared so far.
  std::size_t compared() const noexcept { return compared_; }

 private:
  static constexpr std::uint32_t kLeafSize = 4;

  bool is_contained(std::uint32_t number, const Box& box);

  std::vector<Box> boxes_;
  MedianTree tree_;  // by the middles of the boxes
  std::size_t compared_ = 0;
};

}  // namespace hapton
