// A person touches the corners of a screen; the programs are the real ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <string>

#include "tests/process/system.h"

namespace hapton::process {
namespace {

using ::testing::HasSubstr;

// The hand goes to p_WH and stays there until the program has printed `expected`.
bool touches(SessionObserver& hand, const Vec3& p_WH, Program& program, const std::string& expected) {
  hand.lead_hand(p_WH);
  const std::int64_t end_ns = hand.now_ns() + static_cast<std::int64_t>(1e9 * kPatience.count());
  ProbeState state;
  while (hand.now_ns() < end_ns && hand.receive_state(state)) {
    if (program.out().find(expected) != std::string::npos) return true;
  }
  return false;
}

// One number of a TOML line "key = number" or "key = [number, ...".
double read_number(const std::string& text, const std::string& key) { return std::stod(text.substr(text.find(key) + key.size())); }

TEST(ScreenCommand, TouchedCornersGiveTheScreen) {
  System system({"--device", "simulated"});
  const std::string file = (system.folder() / "screen.toml").string();
  system.start("io_node");
  SessionObserver hand(system);
  ProbeState state;
  ASSERT_TRUE(hand.receive_state(state));
  Program program("hapton", {"screen", "--hub", system.hub(), "--out", file}, system.folder());
  ASSERT_TRUE(touches(hand, Vec3(0.0, 0.0, 0.05), program, "1 of 4: the lower left corner\n")) << program.err();
  const std::array<Vec3, 4> corners = {Vec3(-0.08, -0.05, -0.04), Vec3(0.08, -0.05, -0.04), Vec3(0.08, 0.05, -0.04),
                                       Vec3(-0.08, 0.05, -0.04)};
  const std::array<std::string, 4> expected = {"2 of 4: the lower right corner\n", "3 of 4: the upper right corner\n",
                                               "4 of 4: the upper left corner\n", "vision_node --screen " + file + "\n"};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    ASSERT_TRUE(touches(hand, corners[i], program, expected[i])) << program.out() << program.err();
  }
  const auto ended = program.wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 0) << ended->err;
  EXPECT_EQ(ended->err, "");
  EXPECT_THAT(ended->out, HasSubstr("picture of 1"));
  const std::string text = read_text(file);
  EXPECT_NEAR(read_number(text, "width_m = "), 0.16, 0.001) << text;
  EXPECT_NEAR(read_number(text, "height_m = "), 0.10, 0.001) << text;
  EXPECT_NEAR(read_number(text, "position_m = ["), 0.0, 0.001) << text;
  system.end("io_node");
}

TEST(ScreenCommand, AStopWritesNothing) {
  System system({"--device", "simulated"});
  const std::string file = (system.folder() / "screen.toml").string();
  system.start("io_node");
  SessionObserver hand(system);
  ProbeState state;
  ASSERT_TRUE(hand.receive_state(state));
  Program program("hapton", {"screen", "--hub", system.hub(), "--out", file}, system.folder());
  ASSERT_TRUE(System::wait_until([&] { return program.out().find("1 of 4") != std::string::npos; })) << program.err();
  program.send_signal(SIGINT);
  const auto ended = program.wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 1);
  EXPECT_EQ(ended->err, "hapton screen: stopped before all corners were touched; nothing was written\n");
  EXPECT_FALSE(std::filesystem::exists(file));
  system.end("io_node");
}

}  // namespace
}  // namespace hapton::process
