#include "haptic_step/method_text.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(MethodText, LeavesOutDefaults) {
  EXPECT_EQ(to_text({}), "name=proxy");
  EXPECT_EQ(to_text({.name = "sweep", .grid_division = {8, 9, 10}}), "name=sweep grid_division=8x9x10");
}

TEST(MethodText, GivesBackEverySettingToTheLastBit) {
  const MethodSettings settings{.name = "smooth",
                                .grid_division = {1, 2, 3},
                                .offset_m = 0.1 + 0.2,
                                .set_size = 100,
                                .smooth_radius_m = 1.0 / 3.0,
                                .smooth_layer = 1e-300,
                                .hull_directions = 26,
                                .crease_deg = 63.0 / 11.0,
                                .simplify_m = 1e-5 / 3.0,
                                .build_on_approach = true,
                                .shading = 0.7,
                                .probe_radius_m = 0.0005,
                                .coupling_n_per_m = 800.0 / 7.0,
                                .reference_substeps = 32,
                                .reference_substep_limit = 512};
  const auto read = parse_method_text(to_text(settings));
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(to_text(*read), to_text(settings));
  EXPECT_EQ(read->offset_m, settings.offset_m);
  EXPECT_EQ(read->smooth_radius_m, settings.smooth_radius_m);
  EXPECT_EQ(read->crease_deg, settings.crease_deg);
  EXPECT_EQ(read->simplify_m, settings.simplify_m);
  EXPECT_EQ(read->grid_division, settings.grid_division);
  EXPECT_TRUE(read->build_on_approach);
  EXPECT_EQ(read->reference_substep_limit, 512);
}

TEST(ToolText, IsReadAsItWasWritten) {
  const ToolCoupling coupling{.stiffness_n_per_m = 800.0 / 7.0, .rotational_stiffness_nm_per_rad = 1e-3 / 3.0};
  EXPECT_EQ(to_text(coupling, 12, 0.0005), to_text(coupling, 12) + " voxel_m=0.0005");
  EXPECT_TRUE(parse_tool_text(to_text(coupling, 12, 0.0005)));
  const auto read = parse_tool_text(to_text(coupling, 12));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->stiffness_n_per_m, coupling.stiffness_n_per_m);
  EXPECT_EQ(read->rotational_stiffness_nm_per_rad, coupling.rotational_stiffness_nm_per_rad);
}

// Older builds wrote 0 into a recording for a stiffness that follows from the size of the tool.
TEST(ToolText, ARotationalStiffnessOfZeroIsAccepted) {
  const auto read = parse_tool_text("name=tool stiffness_n_per_m=800 rotational_stiffness_nm_per_rad=0 effects=wind@0");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->stiffness_n_per_m, 800.0);
  EXPECT_EQ(read->rotational_stiffness_nm_per_rad, 0.0);
}

TEST(ToolText, RejectsMethodsAndMalformedTexts) {
  for (const char* text : {"", "name=proxy", "name=toolbox stiffness_n_per_m=5", "stiffness_n_per_m=5", "name=tool stiffness_n_per_m=soft",
                           "name=tool stiffness_n_per_m=-5", "name=tool stiffness_n_per_m=nan", "name=tool stiffness_n_per_m",
                           "name=tool rotational_stiffness_nm_per_rad=-1", "name=tool rotational_stiffness_nm_per_rad=soft",
                           "name=tool rotational_stiffness_nm_per_rad=nan"}) {
    EXPECT_FALSE(parse_tool_text(text)) << text;
  }
  EXPECT_FALSE(parse_tool_text(to_text(MethodSettings())));
}

TEST(MethodText, RejectsWhatItDoesNotWrite) {
  for (const char* text : {"name", "name=", "speed=3", "set_size=many", "set_size=3x", "grid_division=0", "shading="}) {
    const auto read = parse_method_text(text);
    ASSERT_FALSE(read) << text;
    EXPECT_NE(read.error().what.find("not understood"), std::string::npos);
  }
}

}  // namespace
}  // namespace hapton
