#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"

namespace hapton {

// A view that shows what a method computes with.
enum class TeachView { off, contact, local_set, tree, grid, curvature };

struct TeachChoice {
  static constexpr int kDeepest = 20;  // largest level that parse_teach() accepts; a free choice

  TeachView view = TeachView::off;
  int level = 2;  // shown level of the tree; 0: the children of the root
  friend bool operator==(const TeachChoice&, const TeachChoice&) = default;
};

// text: "contact", "local-set", "tree", "tree:LEVEL", "grid", "curvature" or "off". Error: one line.
Result<TeachChoice> parse_teach(std::string_view text);
// The next view in the order of TeachView; after the last one: off.
TeachChoice next_teach(TeachChoice choice);
// One level deeper; after the deepest one: 0. depth: the number of levels (TeachBuilder::tree_depth).
TeachChoice next_level(TeachChoice choice, int depth);
// The name for people, such as "local set"; empty: off.
std::string_view teach_name(TeachView view);

}  // namespace hapton
