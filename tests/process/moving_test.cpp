// Objects that move by keyframes or deform, in the real programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <string>
#include <vector>

#include "tests/process/led_hand.h"

namespace hapton::process {
namespace {

using ::testing::HasSubstr;

// A hand that holds still over the piston of scenes/machine.toml is pushed up by it; the recording gives the same forces again.
TEST(MovingObjects, PushAHandThatHoldsStillAndAreReplayed) {
  LedHand hand("simulated", "t_s,x_m,y_m,z_m\n0,-0.068,0.05,0\n0.5,-0.068,0.033,0\n60,-0.068,0.033,0\n", "machine.toml");
  EXPECT_TRUE(hand.goes_above("max_force_written_n", 0.5));
  hand.end();
  const Ended replayed = hand.replay();
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
}

// A hand that holds still over the block of scenes/deforming.toml is pushed up by its first hump.
TEST(DeformingObjects, PushAHandThatHoldsStillAndAreReplayed) {
  LedHand hand("simulated", "t_s,x_m,y_m,z_m\n0,-0.0543,0,-0.006\n0.5,-0.0543,-0.030,-0.006\n60,-0.0543,-0.030,-0.006\n", "deforming.toml");
  EXPECT_TRUE(hand.goes_above("max_force_written_n", 0.5));
  hand.end();
  const Ended replayed = hand.replay();
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
}

Ended move_with(const LedHand& hand, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "move");
  arguments.insert(arguments.end(), {"--hub", hand.hub});
  return run("hapton", arguments, hand.scratch.path()).value_or(Ended{});
}

// The programs may still be starting, or the machine may stand still for seconds.
Ended moved_at_last(const LedHand& hand, const std::vector<std::string>& arguments) {
  Ended moved;
  System::wait_until([&] {
    moved = move_with(hand, arguments);
    return moved.exit_code == 0;
  });
  EXPECT_EQ(moved.exit_code, 0) << moved.err;
  return moved;
}

// A hand that holds still over the platform of scenes/lift.toml is pushed up when a program lifts it.
TEST(ObjectsThatProgramsMove, PushAHandThatHoldsStillAndAreReplayed) {
  LedHand hand("simulated", "t_s,x_m,y_m,z_m\n0,-0.05,0.06,0.01\n0.5,-0.05,0.029,0.01\n600,-0.05,0.029,0.01\n", "lift.toml");
  const Ended moved = moved_at_last(hand, {"platform", "--to", "-0.05,-0.005,0", "--over", "0.2"});
  EXPECT_EQ(moved.out, "platform moves, for 0.200 s\n");
  EXPECT_TRUE(hand.goes_above("max_force_written_n", 0.5));
  const Ended slowed = moved_at_last(hand, {"platform", "--to", "-0.05,-0.02,0", "--over", "0.01"});
  EXPECT_THAT(slowed.out, HasSubstr(" s, not 0.01 s: no point of it may be faster than 0.25 m/s\n"));
  moved_at_last(hand, {"#2", "--rotate", "-90,0,70"});
  Ended refused;
  const auto is_refused = [&] {
    refused = move_with(hand, {"ground", "--to", "0,0,0"});
    return refused.err.find("rejected") != std::string::npos;
  };
  EXPECT_TRUE(System::wait_until(is_refused));
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_EQ(
      refused.err,
      "hapton move: the haptics node rejected it: programs may not move 'ground': give it moved_by = \"program\" in the scene file\n");
  hand.end();
  const Ended replayed = hand.replay();
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
  const Ended info = run("hapton", {"session", "info", hand.file}, hand.scratch.path()).value_or(Ended{});
  EXPECT_THAT(info.out, HasSubstr("objects moved by programs: "));
}

// A hand goes to the left side of the brick of scenes/push.toml and 30 mm on: so does the brick, and the recording gives the same forces.
TEST(ObjectsThatArePushed, GoWhereTheHandPushesThemAndAreReplayed) {
  LedHand hand("simulated",
               "t_s,x_m,y_m,z_m\n0,-0.005,0.018,0\n0.5,-0.005,-0.008,0\n1,0.0095,-0.008,0\n2.5,0.04,-0.008,0\n600,0.04,-0.008,0\n",
               "push.toml");
  Program dynamics("hapton", {"dynamics", "--scene", HAPTON_SOURCE_DIR "/scenes/push.toml", "--hub", hand.hub}, hand.scratch.path());
  EXPECT_TRUE(hand.goes_above("max_force_written_n", 0.3));
  // Until it is over: the simulated hand waits for nobody.
  EXPECT_FALSE(dynamics.wait(Seconds(4))) << dynamics.out() << dynamics.err();
  dynamics.send_signal(SIGTERM);
  const auto ended = dynamics.wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 0) << ended->err;
  EXPECT_THAT(ended->out, HasSubstr("bodies: brick (0.15 kg), peg (0.1 kg), wing nut (0.08 kg); obstacles: 1\n"));
  std::smatch moved;
  ASSERT_TRUE(std::regex_search(ended->out, moved, std::regex("brick is ([0-9.]+) mm from where it began"))) << ended->out;
  EXPECT_NEAR(std::stod(moved[1]), 30.0, 6.0);
  hand.end();
  const Ended replayed = hand.replay();
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
}

// The same from parts of the scene beside the device: the piston pushes, and the recording has the forces of the haptics node, 20 a second.
TEST(MovingObjects, PushAHandThatFeelsThemFromPatches) {
  LedHand hand("simulated", "t_s,x_m,y_m,z_m\n0,-0.068,0.05,0\n0.5,-0.068,0.033,0\n600,-0.068,0.033,0\n", "machine.toml",
               {"--touch", "patch"});
  EXPECT_TRUE(System::wait_until([&] { return hand.io.out().find("hub on ") != std::string::npos; }));
  EXPECT_TRUE(System::wait_until([&] { return hand.read_counter("local_forces") > 2000; })) << hand.haptics.err();
  EXPECT_TRUE(hand.goes_above("max_force_written_n", 0.5));
  EXPECT_EQ(hand.haptics.err().find("this node computes the forces"), std::string::npos) << hand.haptics.err();
  hand.end();
  const Ended replayed = hand.replay();
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
}

// A program lifts the platform under a hand that feels it from patches, and softens it meanwhile.
TEST(ObjectsThatProgramsMove, PushAHandThatFeelsThemFromPatches) {
  LedHand hand("simulated", "t_s,x_m,y_m,z_m\n0,-0.05,0.06,0.01\n0.5,-0.05,0.029,0.01\n600,-0.05,0.029,0.01\n", "lift.toml",
               {"--touch", "patch"});
  EXPECT_TRUE(System::wait_until([&] { return hand.io.out().find("hub on ") != std::string::npos; }));
  EXPECT_TRUE(System::wait_until([&] { return hand.read_counter("local_forces") > 1000; })) << hand.haptics.err();
  moved_at_last(hand, {"platform", "--to", "-0.05,-0.005,0", "--over", "0.2"});
  EXPECT_TRUE(hand.goes_above("max_force_written_n", 0.5));
  const std::int64_t before = hand.read_counter("local_forces");
  const auto set = run("hapton", {"set", "--hub", hand.hub, "--object", "platform", "--stiffness", "300"}, hand.scratch.path());
  ASSERT_TRUE(set);
  EXPECT_EQ(set->exit_code, 0) << set->err;
  EXPECT_TRUE(System::wait_until([&] { return hand.read_counter("local_forces") > before + 1000; })) << "patches go on";
  hand.end();
}

}  // namespace
}  // namespace hapton::process
