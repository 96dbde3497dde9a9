#include "scene/screen_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

const std::string kScreenText =
    "schema = \"hapton.screen/1\"\n"
    "position_m = [0.01, 0.05, -0.12]\n"
    "rotation_deg = [-30, 0, 0]\n"
    "width_m = 0.52\n"
    "height_m = 0.29\n";

std::string screen_error(const std::string& text) {
  const auto read = parse_screen(text);
  return read ? std::string("none") : read.error().what;
}

// kScreenText with `from` replaced by `to`.
std::string changed_screen_text(const std::string& from, const std::string& to) {
  std::string text = kScreenText;
  return text.replace(text.find(from), from.size(), to);
}

TEST(ScreenFile, GivesPoseAndSize) {
  const auto screen = parse_screen(kScreenText);
  ASSERT_TRUE(screen) << screen.error().what;
  EXPECT_LT((screen->X_WR.translation() - Vec3(0.01, 0.05, -0.12)).norm(), 1e-15);
  // The screen leans back: its normal points partly upwards.
  EXPECT_LT((screen->X_WR.linear().col(2) - Vec3(0.0, 0.5, std::sqrt(0.75))).norm(), 1e-12);
  EXPECT_EQ(screen->width_m, 0.52);
  EXPECT_EQ(screen->height_m, 0.29);
}

TEST(ScreenFile, WhatIsWrittenReadsBack) {
  constexpr std::uint64_t kSeed = 1;
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 100; ++i) {
    const Quat q = Quat(normal(random), normal(random), normal(random), normal(random)).normalized();
    ScreenRectangle screen;
    screen.X_WR = Eigen::Translation3d(normal(random), normal(random), normal(random)) * q;
    screen.width_m = 0.1 + std::abs(normal(random));
    screen.height_m = 1.0;
    const auto read = parse_screen(write_screen(screen));
    ASSERT_TRUE(read) << read.error().what;
    EXPECT_EQ(read->X_WR.translation(), screen.X_WR.translation()) << "seed " << kSeed;
    EXPECT_LT((read->X_WR.linear() - screen.X_WR.linear()).norm(), 1e-14);
    EXPECT_EQ(read->width_m, screen.width_m);
    EXPECT_EQ(read->height_m, screen.height_m);
  }
}

TEST(ScreenFile, AScreenThatAFileMayNotHaveIsFoundBeforeItIsWritten) {
  ScreenRectangle screen;
  screen.width_m = 0.4;
  screen.height_m = 0.3;
  EXPECT_TRUE(check_screen(screen));
  screen.X_WR = Eigen::Translation3d(0.0, -120.0, 0.0);
  EXPECT_FALSE(check_screen(screen));
  EXPECT_FALSE(parse_screen(write_screen(screen)));
  screen.X_WR = Pose::Identity();
  screen.height_m = 300.0;
  EXPECT_FALSE(check_screen(screen));
  EXPECT_FALSE(parse_screen(write_screen(screen)));
}

TEST(ScreenFile, ErrorsNameLineKeyAndAllowedValues) {
  EXPECT_EQ(screen_error(changed_screen_text("0.52", "0")), "line 4: 'width_m' in the file is 0: it must be at least 0.02 and at most 100");
  EXPECT_EQ(screen_error(changed_screen_text("0.29", "290")),
            "line 5: 'height_m' in the file is 290: it must be at least 0.02 and at most 100");
  EXPECT_EQ(screen_error(changed_screen_text("0.29", "nan")),
            "line 5: 'height_m' in the file is nan: it must be at least 0.02 and at most 100");
  EXPECT_EQ(screen_error(changed_screen_text("0.29", "\"a\"")), "line 5: 'height_m' in the file must be a number");
  EXPECT_EQ(screen_error(changed_screen_text("-0.12", "-120")),
            "line 2: number 3 of 'position_m' in the file is -120: it must be at least -100 and at most 100");
  EXPECT_EQ(screen_error(changed_screen_text("[0.01, ", "[")), "line 2: 'position_m' in the file must be a list of 3 numbers");
  EXPECT_THAT(screen_error(changed_screen_text("height_m", "hight_m")),
              HasSubstr("line 5: unknown key 'hight_m' in the file; did you mean 'height_m'?"));
  EXPECT_THAT(screen_error(changed_screen_text("width_m = 0.52\n", "")), HasSubstr("the file has no 'width_m': add it"));
  EXPECT_THAT(screen_error(changed_screen_text("rotation_deg = [-30, 0, 0]\n", "")), HasSubstr("the file has no 'rotation': add it"));
  EXPECT_EQ(screen_error(changed_screen_text("rotation_deg = [-30, 0, 0]", "rotation = [1, 1, 0, 0]")),
            "line 3: 'rotation' has length 1.41421: a rotation is a quaternion [w, x, y, z] of length 1");
  EXPECT_THAT(screen_error(changed_screen_text("width_m", "rotation = [1, 0, 0, 0]\nwidth_m")), HasSubstr("keep one"));
  EXPECT_EQ(
      screen_error(changed_screen_text("screen/1", "screen/2")),
      "line 1: the schema is 'hapton.screen/2', and this program reads 'hapton.screen/1': calibrate the screen with a program of this "
      "version");
  EXPECT_THAT(screen_error("schema = \n"), HasSubstr("line 1: "));
  EXPECT_EQ(screen_error("schema = \n").find('\n'), std::string::npos);
}

TEST(ScreenFile, AnErrorNamesTheFile) {
  const ScratchFolder scratch;
  scratch.write("screen.toml", changed_screen_text("0.52", "0"));
  const auto wrong = read_screen(scratch.path() / "screen.toml");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().what,
            (scratch.path() / "screen.toml").string() + ": line 4: 'width_m' in the file is 0: it must be at least 0.02 and at most 100");
  const auto missing = read_screen(scratch.path() / "no.toml");
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().what, HasSubstr("no.toml"));
  scratch.write("screen.toml", kScreenText);
  EXPECT_TRUE(read_screen(scratch.path() / "screen.toml"));
}

}  // namespace
}  // namespace hapton
