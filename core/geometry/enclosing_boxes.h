#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/median_tree.h"
#include "core/math/types.h"

namespace hapton {

// A tree of boxes that tells whether one of them contains a given box.
//
// Construction takes n log n steps for any input. A query compares the given box with about log n boxes where the boxes of the tree lie
// apart or inside one another; where many overlap, with all those whose common box contains it. Frame and unit: those of the boxes. RT:
// set-up only. Threads: one (a query changes the count).
class EnclosingBoxes {
 public:
  using Box = Eigen::AlignedBox3d;

  // Pre: every box is finite and not empty.
  explicit EnclosingBoxes(std::vector<Box> boxes);

  // Whether one of the boxes contains `box`. A box contains itself.
  bool contain(const Box& box);
  // The number of boxes compared so far, including those of the nodes of the tree.
  std::size_t comparisons() const noexcept { return comparisons_; }

 private:
  static constexpr std::uint32_t kLeafSize = 4;

  bool is_contained(std::uint32_t number, const Box& box);

  std::vector<Box> boxes_;
  MedianTree tree_;  // sorted by the centres of the boxes
  std::size_t comparisons_ = 0;
};

}  // namespace hapton
