#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace hapton {

// The bounding box of one tree item (a triangle, an object), rounded to single precision: it only decides how the tree is split.
struct FdhItem {
  std::array<float, 3> low;
  std::uint32_t id;
  std::array<float, 3> high;
  std::uint32_t unused = 0;  // fills 32 bytes
};

// The tree structure of a hierarchy, without bounds: it does not depend on the number of directions.
struct FdhTopology {
  static constexpr int kWidth = 8;                                // children of a node: the lanes of a Float8
  static constexpr std::uint32_t kLeafSize = 4;                   // most items of a leaf; count - 1 fits two bits
  static constexpr int kMaxDepth = 48;                            // nodes on the path from the root to a leaf
  static constexpr int kMaxStack = kMaxDepth * (kWidth - 1) + 1;  // a traversal leaves at most kWidth - 1 siblings per level
  static constexpr std::size_t kMaxItems = std::size_t{1} << 28;  // a leaf has 28 bits for its first item

  // A child is a node's index, a leaf (kLeafBit, count - 1 in two bits, first item in 28), or kNothing, for which is_leaf is true too.
  static constexpr std::uint32_t kLeafBit = 0x80000000U;
  static constexpr std::uint32_t kNothing = 0xFFFFFFFFU;
  static constexpr bool is_leaf(std::uint32_t child) { return (child & kLeafBit) != 0; }
  static constexpr std::uint32_t leaf_first(std::uint32_t child) { return child & 0x0FFFFFFFU; }
  static constexpr std::uint32_t leaf_count(std::uint32_t child) { return ((child >> 28) & 3U) + 1U; }
  static constexpr std::uint32_t leaf(std::uint32_t first, std::uint32_t count) { return kLeafBit | ((count - 1U) << 28) | first; }

  using Children = std::array<std::uint32_t, kWidth>;
  std::vector<Children> nodes;       // the root first; every node before its children; used children first
  std::vector<std::uint32_t> order;  // item ids in tree order: a leaf is a contiguous range
  int depth = 0;                     // levels of nodes, <= kMaxDepth
};

// Builds by the binned surface-area heuristic on boxes (MacDonald & Booth 1990; Wald 2007), directly with nodes of kWidth children: a node
// opens the child of largest area until it is full. If only median splits can respect kMaxDepth, it splits at the median. Reorders items.
// Pre: items.size() <= kMaxItems, every number finite. RT: set-up only.
FdhTopology build_fdh_topology(std::span<FdhItem> items);

}  // namespace hapton
