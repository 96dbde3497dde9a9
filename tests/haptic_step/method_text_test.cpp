#include "haptic_step/method_text.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(MethodText, LeavesOutWhatIsAsByDefault) {
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

TEST(MethodText, RejectsWhatItDoesNotWrite) {
  for (const char* text : {"name", "name=", "speed=3", "set_size=many", "set_size=3x", "grid_division=0", "shading="}) {
    const auto read = parse_method_text(text);
    ASSERT_FALSE(read) << text;
    EXPECT_NE(read.error().what.find("not understood"), std::string::npos);
  }
}

}  // namespace
}  // namespace hapton
