#include "vision_node/stereo_mode.h"

#include <set>

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(StereoModeNames, ReadBackAsThemselves) {
  std::set<StereoMode> modes;
  for (const auto& name : stereo_mode_names()) {
    const auto mode = find_stereo_mode(name);
    ASSERT_TRUE(mode) << name;
    EXPECT_EQ(stereo_mode_name(*mode), name);
    EXPECT_TRUE(modes.insert(*mode).second) << name << " is the second name of a mode";
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
