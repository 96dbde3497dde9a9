#include "core/base/near_miss.h"

#include <gtest/gtest.h>

#include <array>

namespace hapton {
namespace {

TEST(NearMiss, NamesTheNearestOrAll) {
  const std::array<std::string_view, 3> known = {"friction_static", "friction_dynamic", "scale"};
  EXPECT_EQ(near_miss_hint("friction_statik", known), "; did you mean 'friction_static'?");
  EXPECT_EQ(near_miss_hint("frictiondynamic", known), "; did you mean 'friction_dynamic'?");
  EXPECT_EQ(near_miss_hint("scal", known), "; did you mean 'scale'?");
  EXPECT_EQ(near_miss_hint("sclae", known), "; did you mean 'scale'?");
  EXPECT_EQ(near_miss_hint("volume", known), "; known are friction_static, friction_dynamic, scale");
  EXPECT_EQ(near_miss_hint(std::string(100000, 'x'), known), "; known are friction_static, friction_dynamic, scale");
}

TEST(NearMiss, FindsTheNearestWordOrNone) {
  constexpr std::array<std::string_view, 3> known = {"--scene", "--seconds", "--out"};
  EXPECT_EQ(find_near_miss("--sceen", known), "--scene");
  EXPECT_EQ(find_near_miss("--second", known), "--seconds");
  EXPECT_EQ(find_near_miss("--volume", known), "");
}

}  // namespace
}  // namespace hapton
