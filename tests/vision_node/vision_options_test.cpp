#include "vision_node/vision_options.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

std::variant<VisionOptions, int> parse(std::vector<const char*> words) {
  words.insert(words.begin(), "vision_node");
  return parse_vision_options(static_cast<int>(words.size()), words.data());
}

TEST(VisionOptions, DefaultsAreTheDocumentedOnes) {
  const auto parsed = parse({});
  ASSERT_TRUE(std::holds_alternative<VisionOptions>(parsed));
  const auto& options = std::get<VisionOptions>(parsed);
  EXPECT_EQ(options.view.stereo, StereoMode::automatic);
  EXPECT_EQ(options.view.width_px, 1280);
  EXPECT_EQ(options.view.height_px, 720);
  EXPECT_EQ(options.view.msaa, 0);
  EXPECT_TRUE(options.view.cull);
  EXPECT_FALSE(options.has_space_knobs);
  EXPECT_EQ(options.scene, "scenes/car_front.toml");
}

TEST(VisionOptions, FlagsArrive) {
  const auto parsed = parse({"--stereo",     "dresden",   "--size",   "800x600", "--no-cull",    "--msaa",  "4",
                             "--dial-y-deg", "30",        "--ipd-mm", "60",      "--screenshot", "a.png",   "--screenshot-when",
                             "2.5",          "--seconds", "3",        "--hub",   "box:5000",     "--knobs", "spacemouse"});
  ASSERT_TRUE(std::holds_alternative<VisionOptions>(parsed));
  const auto& options = std::get<VisionOptions>(parsed);
  EXPECT_EQ(options.view.stereo, StereoMode::dresden);
  EXPECT_EQ(options.view.width_px, 800);
  EXPECT_EQ(options.view.height_px, 600);
  EXPECT_FALSE(options.view.cull);
  EXPECT_EQ(options.view.msaa, 4);
  EXPECT_EQ(options.dials_degrees.y(), 30.0);
  EXPECT_EQ(options.ipd_mm, 60.0);
  EXPECT_EQ(options.screenshot, "a.png");
  EXPECT_EQ(options.hub, "box:5000");
  EXPECT_TRUE(options.has_space_knobs);
  EXPECT_EQ(std::get<VisionOptions>(parse({"--unit", "mm"})).loading.unit, Unit::mm);
}

TEST(VisionOptions, ASecondHubIsAnotherHand) {
  const auto one = std::get<VisionOptions>(parse({"--hub", "a"}));
  EXPECT_EQ(one.hub, "a");
  EXPECT_EQ(one.other_hub, "");
  const auto two = std::get<VisionOptions>(parse({"--hub", "a:1", "--hub", "b:2"}));
  EXPECT_EQ(two.hub, "a:1");
  EXPECT_EQ(two.other_hub, "b:2");
}

TEST(VisionOptions, WrongOnesEndWithAnErrorCode) {
  for (const auto& words : std::vector<std::vector<const char*>>{{"--stereo", "3d"},
                                                                 {"--knobs", "three"},
                                                                 {"--size", "wide"},
                                                                 {"--size", "1x1"},
                                                                 {"--size", "800x600x24"},
                                                                 {"--msaa", "-1"},
                                                                 {"--ipd-mm", "nan"},
                                                                 {"--seconds", "-5"},
                                                                 {"--screenshot-when", "soon"},
                                                                 {"--frames-per-second-limit", "-2"},
                                                                 {"--hub", "a", "--hub", "b", "--hub", "c"},
                                                                 {"--unheard-of"}}) {
    const auto parsed = parse(words);
    ASSERT_TRUE(std::holds_alternative<int>(parsed)) << words[0];
    EXPECT_NE(std::get<int>(parsed), 0) << words[0];
  }
}

}  // namespace
}  // namespace hapton
