#include "vision_node/stereo_mode.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(StereoModeNames, ReadBackAsThemselves) {
  const auto names = stereo_mode_names();
  EXPECT_EQ(names.size(), 16u);
  for (const auto& name : names) {
    const auto mode = find_stereo_mode(name);
    ASSERT_TRUE(mode) << name;
    EXPECT_EQ(stereo_mode_name(*mode), name);
  }
}

TEST(StereoModeNames, UnknownOnesAreRejectedWithTheList) {
  const auto mode = find_stereo_mode("3d");
  ASSERT_FALSE(mode);
  EXPECT_NE(mode.error().what.find("'3d'"), std::string::npos);
  EXPECT_NE(mode.error().what.find("side_by_side"), std::string::npos);
}

}  // namespace
}  // namespace hapton
