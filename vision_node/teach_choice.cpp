#include "vision_node/teach_choice.h"

#include <charconv>

namespace hapton {

Result<TeachChoice> parse_teach(std::string_view text) {
  TeachChoice choice;
  constexpr std::string_view kTree = "tree:";
  if (text == "off") return choice;
  if (text == "contact") choice.view = TeachView::contact;
  if (text == "local-set") choice.view = TeachView::local_set;
  if (text == "grid") choice.view = TeachView::grid;
  if (text == "curvature") choice.view = TeachView::curvature;
  if (text == "tree") choice.view = TeachView::tree;
  if (text.starts_with(kTree)) {
    const char* end = text.data() + text.size();
    const auto [at, error] = std::from_chars(text.data() + kTree.size(), end, choice.level);
    if (error == std::errc() && at == end && choice.level >= 0 && choice.level <= TeachChoice::kDeepest) choice.view = TeachView::tree;
  }
  if (choice.view == TeachView::off) {
    return fail("'{}' is not known; give contact, local-set, tree:LEVEL with a level from 0 to {}, grid, curvature or off", text,
                TeachChoice::kDeepest);
  }
  return choice;
}

TeachChoice next_teach(TeachChoice choice) {
  choice.view = choice.view == TeachView::curvature ? TeachView::off : static_cast<TeachView>(static_cast<int>(choice.view) + 1);
  return choice;
}

TeachChoice next_level(TeachChoice choice, int depth) {
  choice.level = choice.level + 1 < depth ? choice.level + 1 : 0;
  return choice;
}

std::string_view teach_name(TeachView view) {
  switch (view) {
    case TeachView::off:
      return "";
    case TeachView::contact:
      return "contact";
    case TeachView::local_set:
      return "local set";
    case TeachView::tree:
      return "tree";
    case TeachView::grid:
      return "grid";
    case TeachView::curvature:
      return "curvature";
  }
  return "";
}

}  // namespace hapton
