#include "vision_node/teach_choice.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(TeachChoice, IsReadFromTheCommandLine) {
  EXPECT_EQ(parse_teach("local-set")->view, TeachView::local_set);
  EXPECT_EQ(parse_teach("tree:3"), (TeachChoice{TeachView::tree, 3}));
  EXPECT_EQ(parse_teach("tree")->level, TeachChoice().level);
  EXPECT_EQ(parse_teach("off")->view, TeachView::off);
  for (const char* wrong : {"", "trees", "tree:", "tree:x", "tree:-1", "tree:21", "tree:2x", "grid:1", "Contact"}) {
    const auto read = parse_teach(wrong);
    ASSERT_FALSE(read) << wrong;
    EXPECT_NE(read.error().what.find("local-set"), std::string::npos) << read.error().what;
  }
}

TEST(TeachChoice, KeysStepThroughAllViewsAndLevels) {
  TeachChoice choice;
  std::string names;
  do {
    choice = next_teach(choice);
    names += std::string(teach_name(choice.view)) + ",";
  } while (choice.view != TeachView::off);
  EXPECT_EQ(names, "contact,local set,tree,grid,curvature,,");
  EXPECT_EQ(next_level({TeachView::tree, 1}, 4).level, 2);
  EXPECT_EQ(next_level({TeachView::tree, 3}, 4).level, 0);
}

}  // namespace
}  // namespace hapton
