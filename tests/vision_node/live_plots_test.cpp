#include "vision_node/live_plots.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

ProbeState state_with(double force_n, float limit_n = 8.5F) {
  ProbeState state;
  state.force_n = Vec3(0.0, -force_n, 0.0);
  state.force_limit_n = limit_n;
  return state;
}

TEST(LivePlots, ShowForceWithItsLimitAndTheAgeOfTheFrames) {
  LivePlots plots(true);
  plots.receive(state_with(2.0), 1000 * kMs);
  plots.receive(state_with(3.25), 1100 * kMs);
  plots.record_motion_to_photon(14 * kMs, 1110 * kMs);
  const auto shown = plots.update(1120 * kMs);
  ASSERT_EQ(shown.size(), 2u);
  EXPECT_EQ(shown[0].title, "force 3.25 N, limit 8.5   (0 to 10, 5 s)");
  EXPECT_EQ(shown[0].limit, 8.5);
  EXPECT_EQ(shown[0].top, 10.0);
  ASSERT_EQ(shown[0].points.size(), 3u) << "two that came, and the last one still holds";
  EXPECT_EQ(shown[0].points[0].value, 2.0);
  EXPECT_EQ(shown[0].points[1].value, 3.25);
  EXPECT_EQ(shown[0].points[2].value, 3.25);
  EXPECT_EQ(shown[1].title, "age 14 ms   (0 to 20, 5 s)");
  EXPECT_EQ(shown[1].limit, 0.0);
  EXPECT_EQ(shown[1].top, 20.0);
}

TEST(LivePlots, AreOffUntilToggledAndThenKnowThePast) {
  LivePlots plots(false);
  plots.receive(state_with(2.0), 1000 * kMs);
  EXPECT_TRUE(plots.update(1100 * kMs).empty());
  EXPECT_FALSE(plots.wants_picture(5000 * kMs));
  plots.toggle();
  EXPECT_TRUE(plots.wants_picture(5000 * kMs));
  EXPECT_EQ(plots.update(5000 * kMs)[0].points.front().value, 2.0);
}

TEST(LivePlots, CallForTenPicturesASecondWhileThereIsAHub) {
  LivePlots plots(true);
  EXPECT_FALSE(plots.wants_picture(1000 * kMs)) << "nothing to show";
  plots.receive(state_with(0.0), 1000 * kMs);
  EXPECT_TRUE(plots.wants_picture(1000 * kMs));
  plots.update(1000 * kMs);
  EXPECT_FALSE(plots.wants_picture(1099 * kMs));
  EXPECT_TRUE(plots.wants_picture(1100 * kMs));
  plots.forget_force();
  EXPECT_FALSE(plots.wants_picture(1100 * kMs));
  const auto after = plots.update(3000 * kMs);
  EXPECT_GT(after[0].points.back().age_s, 1.9) << "no force is drawn while none arrives";
}

TEST(LivePlots, NaNIsNotPlotted) {
  LivePlots plots(true);
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  plots.receive(state_with(std::numeric_limits<double>::quiet_NaN(), kNaN), 1000 * kMs);
  plots.receive(state_with(1.0, -3.0F), 1100 * kMs);
  const auto shown = plots.update(1200 * kMs);
  EXPECT_EQ(shown[0].limit, 0.0);
  EXPECT_EQ(shown[0].title, "force 1 N   (0 to 1, 5 s)");
}

TEST(LivePlots, ScalesEndAtOneTwoOrFiveTimesAPowerOfTen) {
  EXPECT_EQ(choose_top(0.0, 1.0), 1.0);
  EXPECT_EQ(choose_top(1.0, 1.0), 1.0);
  EXPECT_EQ(choose_top(1.01, 1.0), 2.0);
  EXPECT_EQ(choose_top(8.5, 1.0), 10.0);
  EXPECT_EQ(choose_top(10.1, 1.0), 20.0);
  EXPECT_EQ(choose_top(333.0, 20.0), 500.0);
  EXPECT_EQ(choose_top(std::numeric_limits<double>::infinity(), 20.0), 20.0);
}

}  // namespace
}  // namespace hapton
