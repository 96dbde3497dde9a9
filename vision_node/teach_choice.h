#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"

namespace hapton {

// A view that shows what a method computes with.
enum class TeachView { off, contact, local_set, tree, grid, curvature };

struct TeachChoice {
  static constexpr int kDeepest = 20;  // level of the tree that may be given; a free choice

  TeachView view = TeachView::off;
  int level = 2;  // of the tree: 0 is that below the root
  friend bool operator==(const TeachChoice&, const TeachChoice&) = default;
};

// "contact", "local-set", "tree", "tree:LEVEL", "grid", "curvature" or "off". Error: one line.
Result<TeachChoice> parse_teach(std::string_view text);
// In the order of the list above, then off again.
TeachChoice next_teach(TeachChoice choice);
// One level deeper; from the deepest to 0.
TeachChoice next_level(TeachChoice choice, int depth);
// "local set"; empty: off.
std::string_view teach_name(TeachView view);

}  // namespace hapton
