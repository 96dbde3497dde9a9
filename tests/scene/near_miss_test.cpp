#include "scene/near_miss.h"

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

}  // namespace
}  // namespace hapton
