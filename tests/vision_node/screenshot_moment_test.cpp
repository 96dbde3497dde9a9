#include "vision_node/screenshot_moment.h"

#include <gtest/gtest.h>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

TEST(ScreenshotMoment, WaitsForAContactThatLasts) {
  auto moment = *ScreenshotMoment::parse("contact");
  EXPECT_FALSE(moment.take_now(0, false));
  EXPECT_FALSE(moment.take_now(100 * kMs, true));
  EXPECT_FALSE(moment.take_now(200 * kMs, false)) << "a brush only";
  EXPECT_FALSE(moment.take_now(300 * kMs, true));
  EXPECT_FALSE(moment.take_now(500 * kMs, true));
  EXPECT_TRUE(moment.missed_contact()) << "so far";
  EXPECT_TRUE(moment.take_now(700 * kMs, true));
  EXPECT_FALSE(moment.take_now(800 * kMs, true)) << "once";
  EXPECT_TRUE(moment.taken());
  EXPECT_FALSE(moment.missed_contact());
}

TEST(ScreenshotMoment, AtATime) {
  auto moment = *ScreenshotMoment::parse("1.5");
  EXPECT_FALSE(moment.take_now(1499 * kMs, true));
  EXPECT_TRUE(moment.take_now(1500 * kMs, false));
}

TEST(ScreenshotMoment, ExitIsLeftToTheEnd) {
  auto moment = *ScreenshotMoment::parse("exit");
  for (int ms = 0; ms < 10000; ++ms) ASSERT_FALSE(moment.take_now(ms * kMs, true));
  EXPECT_FALSE(moment.taken());
  EXPECT_FALSE(moment.missed_contact()) << "nobody waited for one";
}

TEST(ScreenshotMoment, RejectsAnythingElse) {
  for (const char* text : {"", "now", "1.5s", "-1", "nan", "inf", "1e9"}) {
    const auto moment = ScreenshotMoment::parse(text);
    ASSERT_FALSE(moment) << text;
    EXPECT_NE(moment.error().what.find("contact"), std::string::npos);
  }
}

}  // namespace
}  // namespace hapton
