#include "tools/live/corners_text.h"

#include <gtest/gtest.h>

#include <string>

#include "scene/screen_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/tools/command_run.h"

namespace hapton {
namespace {

constexpr const char* kFourCorners = "-0.12,-0.075,-0.1;0.12,-0.075,-0.1;0.12,0.075,-0.1;-0.12,0.075,-0.1";

TEST(CornersText, ReadsFourPoints) {
  const auto corners = parse_corners("-0.1,0,1e-3;2,3,4;5,6,7;8,9,10.5");
  ASSERT_TRUE(corners);
  EXPECT_EQ((*corners)[0], Vec3(-0.1, 0.0, 0.001));
  EXPECT_EQ((*corners)[3], Vec3(8.0, 9.0, 10.5));
}

TEST(CornersText, WhatIsNotFourPointsIsOneLine) {
  for (const char* text :
       {"1,2,3", "1,2,3;1,2,3;1,2,3", "1,2,3;1,2,3;1,2,3;1,2", "1,2,3;1,2,3;1,2,3;1,2,3;1,2,3", "1,2,3;1,2,3;1,2,3;1,2,3,4",
        "1,2,3;1,2,3;1,2,3;1,2,nan", "1,2,3;1,2,3;1,2,3;1,2,inf", "1,2,3; 1,2,3;1,2,3;1,2,3", "1,2,x;1,2,3;1,2,3;1,2,3"}) {
    const auto corners = parse_corners(text);
    ASSERT_FALSE(corners) << text;
    EXPECT_EQ(corners.error().what.find("--corners " + std::string(text) + ": give four points"), 0U);
    EXPECT_EQ(corners.error().what.find('\n'), std::string::npos);
  }
}

TEST(ScreenCommand, CornersGiveAFileThatReadsBack) {
  const ScratchFolder scratch;
  const std::string file = (scratch.path() / "made" / "screen.toml").string();
  const CommandRun run = run_hapton({"screen", "--corners", kFourCorners, "--out", file});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(
      run.out,
      "picture of 240.0 x 150.0 mm, its centre at 0.0,0.0,-100.0 mm, facing 0.0 degrees up; the touched corners are 0.0, 0.0, 0.0 and "
      "0.0 mm from it\nvision_node --screen " +
          file + "\n");
  const auto screen = read_screen(file);
  ASSERT_TRUE(screen) << screen.error().what;
  EXPECT_LT((screen->X_WR.translation() - Vec3(0.0, 0.0, -0.1)).norm(), 1e-15);
  EXPECT_LT((screen->X_WR.linear() - Mat3::Identity()).norm(), 1e-14);
  EXPECT_NEAR(screen->width_m, 0.24, 1e-15);
  EXPECT_NEAR(screen->height_m, 0.15, 1e-15);
}

TEST(ScreenCommand, WrongCornersWriteNoFile) {
  const ScratchFolder scratch;
  const std::string file = (scratch.path() / "screen.toml").string();
  const auto error_of = [&](const std::string& corners) {
    const CommandRun run = run_hapton({"screen", "--corners", corners, "--out", file});
    EXPECT_EQ(run.code, 1);
    EXPECT_EQ(run.out, "");
    EXPECT_FALSE(std::filesystem::exists(file));
    EXPECT_EQ(run.err.find('\n'), run.err.size() - 1) << run.err;
    return run.err;
  };
  EXPECT_EQ(error_of("0,0"),
            "hapton screen: --corners 0,0: give four points X,Y,Z in metres, separated by semicolons, without spaces, in quotes: "
            "lower left, lower right, upper right, upper left\n");
  EXPECT_NE(error_of("0.12,-0.075,0;-0.12,-0.075,0;-0.12,0.075,0;0.12,0.075,0").find("they go round the other way"), std::string::npos);
  EXPECT_NE(error_of("-0.12,-0.075,0;0.12,-0.075,0;0.12,0.075,0.03;-0.12,0.075,0").find("1 % is allowed; touch all corners again"),
            std::string::npos);
  EXPECT_EQ(error_of("-120,-75,0;120,-75,0;120,75,0;-120,75,0"),
            "hapton screen: the picture would be 240 x 150 m, its centre up to 0 m away along an axis, and 100 m are the most: give the "
            "corners in metres\n")
      << "they are in mm";
}

TEST(ScreenCommand, NoHubIsOneLine) {
  const ScratchFolder scratch;
  const CommandRun run = run_hapton({"screen", "--hub", "127.0.0.1:1", "--out", (scratch.path() / "screen.toml").string()});
  EXPECT_EQ(run.code, 1);
  EXPECT_EQ(run.err.find("hapton screen: "), 0U) << run.err;
  EXPECT_EQ(run.err.find('\n'), run.err.size() - 1) << run.err;
}

}  // namespace
}  // namespace hapton
