#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

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

  struct Node {
    Box around;
    std::uint32_t first = 0;  // boxes
    std::uint32_t last = 0;
    std::uint32_t right = 0;  // the left child follows its parent; 0: a leaf
  };

  std::uint32_t build(std::uint32_t first, std::uint32_t last);
  bool is_contained(std::uint32_t number, const Box& box);

  std::vector<Box> boxes_;
  std::vector<Node> nodes_;
  std::size_t compared_ = 0;
};

}  // namespace hapton
