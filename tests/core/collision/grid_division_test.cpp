#include "core/collision/grid_division.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(GridDivision, OneNumberOrThree) {
  EXPECT_EQ(parse_grid_division("32").value(), (std::array<int, 3>{32, 32, 32}));
  EXPECT_EQ(parse_grid_division("1x20x1024").value(), (std::array<int, 3>{1, 20, 1024}));
}

TEST(GridDivision, AnythingElseIsAnErrorThatNamesIt) {
  for (const char* text : {"", "0", "-3", "1025", "99999999999", "3x", "3x4", "3x4x", "3x4x5x6", "3x4x5 ", " 3", "3.5", "ax3x3", "3X3X3"}) {
    const auto division = parse_grid_division(text);
    ASSERT_FALSE(division) << text;
    EXPECT_NE(division.error().what.find("'" + std::string(text) + "'"), std::string::npos);
  }
}

}  // namespace
}  // namespace hapton
