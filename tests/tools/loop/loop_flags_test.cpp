#include "tools/loop/loop_flags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hapton {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ReadNumbers, TakesListsAndRanges) {
  EXPECT_THAT(*read_numbers("--rate", "1000"), ElementsAre(1000.0));
  EXPECT_THAT(*read_numbers("--rate", "250,1e3"), ElementsAre(250.0, 1000.0));
  EXPECT_THAT(*read_numbers("--delay", "0:500:3"), ElementsAre(0.0, 250.0, 500.0));
  const auto by_ratio = *read_numbers("--rate", "100:10000:3log");
  ASSERT_EQ(by_ratio.size(), 3U);
  EXPECT_NEAR(by_ratio[1], 1000.0, 1e-9);
}

TEST(ReadNumbers, RejectsTextsThatAreNoNumbers) {
  for (const char* text : {"fast", "", ",", "1,two", "1:2", "1:2:1", "1:2:2.5", "0:10:3log", "1:2:x", "nan", "1:2:1e9"}) {
    const auto numbers = read_numbers("--rate", text);
    ASSERT_FALSE(numbers) << text;
    EXPECT_THAT(numbers.error().what, HasSubstr("--rate")) << text;
  }
}

LoopFlags flags_for(const std::string& device, const std::string& hand) {
  LoopFlags flags;
  flags.device = device;
  flags.hand = hand;
  return flags;
}

TEST(LoopsOf, RejectsAnAmplifierThatFollowsNothing) {
  LoopFlags flags = flags_for("touch", "light");
  for (const double hz : {0.0, 0.1, 200.0}) {
    flags.amplifier_hz = hz;
    EXPECT_TRUE(loops_of(flags)) << hz;
  }
  flags.amplifier_hz = 1e-300;
  const auto loops = loops_of(flags);
  ASSERT_FALSE(loops);
  EXPECT_THAT(loops.error().what, HasSubstr("--amplifier 1e-300: give 0 for no lag"));
}

TEST(LoopsOf, CombinesDevicesAndHands) {
  EXPECT_EQ(loops_of(flags_for("touch,falcon", "light,firm"))->size(), 4U);
  EXPECT_EQ(loops_of(flags_for("all", "all"))->size(), device_presets().size() * hand_presets().size());
}

TEST(LoopsOf, ChangesAPreset) {
  LoopFlags flags = flags_for("touch", "stylus");
  flags.friction_n = 0.0;
  flags.encoder_step_m = 1e-6;
  flags.amplifier_hz = 500.0;
  flags.modes = 0;
  const DeviceModel device = loops_of(flags)->front().device_model;
  EXPECT_EQ(device.friction_n, 0.0);
  EXPECT_EQ(device.encoder_step_m, 1e-6);
  EXPECT_EQ(device.amplifier_hz, 500.0);
  EXPECT_EQ(device.mode_count, 0);
}

TEST(LoopsOf, ALoopOfOnesOwnIsDeviceAndHandTogether) {
  LoopFlags flags;
  flags.mass_kg = 0.225;
  flags.damping_ns_per_m = 5.0;
  flags.hand_stiffness_n_per_m = 500.0;
  const NamedLoop loop = loops_of(flags)->front();
  EXPECT_EQ(loop.device_model.mass_kg, 0.225);
  EXPECT_EQ(loop.hand_model.mass_kg, 0.0);
  EXPECT_EQ(loop.hand_model.stiffness_n_per_m, 500.0);
}

TEST(LoopsOf, TakesTwoJoints) {
  LoopFlags flags = flags_for("premium-1.5", "stylus");
  flags.joints = {"0.01,3500,2", "0.005,8000,0"};
  const DeviceModel device = loops_of(flags)->front().device_model;
  ASSERT_EQ(device.mode_count, 2);
  EXPECT_EQ(device.modes[0].mass_kg, 0.01);
  EXPECT_EQ(device.modes[0].stiffness_n_per_m, 3500.0);
  EXPECT_EQ(device.modes[0].damping_ns_per_m, 2.0);
  EXPECT_EQ(device.modes[1].stiffness_n_per_m, 8000.0);
  EXPECT_NEAR(device.motor_mass_kg(), 0.06, 1e-12);
  flags.modes = 1;
  EXPECT_EQ(loops_of(flags)->front().device_model.mode_count, 1);
  LoopFlags own_loop;
  own_loop.mass_kg = 0.2;
  own_loop.damping_ns_per_m = 5.0;
  own_loop.joints = {"0.05,1000,1"};
  EXPECT_EQ(loops_of(own_loop)->front().device_model.mode_count, 1);
}

TEST(LoopsOf, RejectsJointsThatCannotBe) {
  for (const auto& [joints, reason] :
       std::vector<std::pair<std::vector<std::string>, std::string>>{{{"0.01,3500"}, "give MASS,STIFFNESS,DAMPING"},
                                                                     {{"0.01,3500,x"}, "is not a number"},
                                                                     {{"0,3500,1"}, "the mass is at least"},
                                                                     {{"0.01,-1,1"}, "the stiffness above 0"},
                                                                     {{"0.01,3500,-1"}, "the damping 0 to"},
                                                                     {{"0.05,3500,1", "0.025,3500,1"}, "some have to remain at the motors"},
                                                                     {{"0.01,1,1", "0.01,1,1", "0.01,1,1"}, "2 joints at most, not 3"}}) {
    LoopFlags flags = flags_for("premium-1.5", "stylus");
    flags.joints = joints;
    const auto loops = loops_of(flags);
    ASSERT_FALSE(loops) << reason;
    EXPECT_THAT(loops.error().what, HasSubstr(reason));
  }
}

TEST(LoopsOf, SaysWhatIsMissingOrMeant) {
  EXPECT_THAT(loops_of(flags_for("tuch", "stylus")).error().what, HasSubstr("did you mean 'touch'?"));
  EXPECT_THAT(loops_of(flags_for("touch", "stilus")).error().what, HasSubstr("did you mean 'stylus'?"));
  EXPECT_THAT(loops_of({}).error().what, HasSubstr("give --device"));
  LoopFlags both = flags_for("touch", "stylus");
  both.mass_kg = 1.0;
  EXPECT_THAT(loops_of(both).error().what, HasSubstr("exclude each other"));
  LoopFlags mass_only;
  mass_only.mass_kg = 1.0;
  EXPECT_THAT(loops_of(mass_only).error().what, HasSubstr("--damping-ns-per-m"));
  LoopFlags damping_only;
  damping_only.damping_ns_per_m = 1.0;
  EXPECT_THAT(loops_of(damping_only).error().what, HasSubstr("--mass-kg"));
}

}  // namespace
}  // namespace hapton
