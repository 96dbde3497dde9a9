#include "vision_node/hud_text.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(Hud, ShowsThatHapticsIsPreparingInsteadOfMissing) {
  HudFacts facts;
  facts.is_connected = true;
  facts.state.status = ProbeStatus::no_haptics;
  EXPECT_NE(compose_hud(facts).find("no haptics_node replies"), std::string::npos);
  facts.preparing_s = 3.2;
  EXPECT_NE(compose_hud(facts).find("prepares the scene, 3 s"), std::string::npos) << compose_hud(facts);
  EXPECT_EQ(compose_hud(facts).find("no haptics_node replies"), std::string::npos);
  facts.state.status = ProbeStatus::ok;
  EXPECT_EQ(compose_hud(facts).find("free"), std::string::npos) << "it has only joined";
  facts.state.status = ProbeStatus::device_away;
  EXPECT_EQ(compose_hud(facts).find("prepares"), std::string::npos) << "the device has to be repaired first";
}

TEST(Hud, ShowsNoFrameRateBeforeItIsKnown) {
  HudFacts facts;
  facts.stereo = "mono";
  EXPECT_EQ(compose_hud(facts).find("frames/s"), std::string::npos) << compose_hud(facts);
  facts.frame_rate_hz = 29.0;
  EXPECT_NE(compose_hud(facts).find("29 frames/s   mono"), std::string::npos) << compose_hud(facts);
}

TEST(Hud, ShowsNoRoundTripWithoutReplies) {
  HudFacts facts;
  facts.is_connected = true;
  facts.state.servo_rate_hz = 1000.0F;
  facts.state.status = ProbeStatus::no_haptics;
  EXPECT_EQ(compose_hud(facts).find("servo 1000 Hz\n"), 0U) << compose_hud(facts);
  facts.state.round_trip_p50_us = 40.0F;
  facts.state.round_trip_p99_us = 120.0F;
  EXPECT_NE(compose_hud(facts).find("round trip p50 40  p99 120 us\n"), std::string::npos) << compose_hud(facts);
}

TEST(Hud, SaysWhyTheSavedSceneFileIsNotShown) {
  HudFacts facts;
  EXPECT_EQ(compose_hud(facts).find("SCENE FILE"), std::string::npos);
  facts.scene_problem = "a.toml: line 3: unknown key 'colr'; shown as it was before";
  EXPECT_NE(compose_hud(facts).find("\nSCENE FILE: a.toml: line 3: unknown key 'colr'; shown as it was before"), std::string::npos);
}

TEST(Hud, ARecordingIsNamedAndShowsItsOwnKeys) {
  HudFacts facts;
  facts.is_connected = true;
  facts.recording = "recording a.hapton   0:01.0";
  facts.recent_event = "marker: trial 7";
  EXPECT_EQ(compose_hud(facts).find("recording a.hapton"), 0U);
  EXPECT_NE(compose_hud(facts).find("\nmarker: trial 7"), std::string::npos);
  EXPECT_EQ(compose_hud(facts).find("dials"), std::string::npos);
  facts.is_other_scene = true;
  EXPECT_NE(compose_hud(facts).find("THE RECORDING HAS ANOTHER SCENE"), std::string::npos) << compose_hud(facts);
  EXPECT_NE(compose_notice(facts).find("The recording has another scene"), std::string::npos);
  EXPECT_NE(recording_keys_help().find("space pause"), std::string::npos);
}

TEST(Hud, ShowsRatesLatencyForceContactAndMode) {
  HudFacts facts;
  facts.is_connected = true;
  facts.state.servo_rate_hz = 1000.4F;
  facts.state.round_trip_p50_us = 23.0F;
  facts.state.round_trip_p99_us = 81.0F;
  facts.state.force_n = {0.0, 3.0, 4.0};
  facts.state.contact = true;
  facts.state.visual_offset_m = {0.0, 0.0, 0.001};
  facts.frame_rate_hz = 58.2;
  facts.stereo = "anaglyph";
  facts.cull = false;
  const std::string text = compose_hud(facts);
  for (const char* part : {"1000 Hz", "23", "81", "5.00 N", "touching", "58", "anaglyph", "no cull"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
  }
  facts.state.contact = false;
  EXPECT_EQ(compose_hud(facts).find("touching"), std::string::npos);
}

TEST(Hud, ShowsTheTorqueOfATool) {
  HudFacts facts;
  facts.is_connected = true;
  EXPECT_EQ(compose_hud(facts).find("torque"), std::string::npos);
  facts.state.torque_nm = {0.03, 0.0, -0.04};
  EXPECT_NE(compose_hud(facts).find("torque 0.050 Nm"), std::string::npos) << compose_hud(facts);
}

TEST(Hud, CountsThePairsOfTrianglesInContact) {
  HudFacts facts;
  facts.is_connected = true;
  EXPECT_EQ(compose_hud(facts).find("hapton"), std::string::npos) << "a probe";
  facts.state.haptons = 0;
  EXPECT_EQ(compose_hud(facts).find("hapton"), std::string::npos) << "free";
  facts.state.haptons = 1;
  EXPECT_NE(compose_hud(facts).find(" 1 hapton "), std::string::npos) << compose_hud(facts);
  facts.state.haptons = 12;
  EXPECT_NE(compose_hud(facts).find(" 12 haptons "), std::string::npos) << compose_hud(facts);
}

TEST(Hud, NamesWhatIsTouched) {
  HudFacts facts;
  facts.is_connected = true;
  facts.touched_name = "hood (sheet metal)";
  EXPECT_EQ(compose_hud(facts).find("hood"), std::string::npos) << "nothing is touched";
  facts.state.contact = true;
  facts.state.object = 0;
  EXPECT_NE(compose_hud(facts).find("touching hood (sheet metal)"), std::string::npos) << compose_hud(facts);
  facts.held_name = "peg (steel)";
  EXPECT_EQ(compose_hud(facts).find("in contact"), std::string::npos) << "a magnet pulls what is held";
  facts.state.visual_turn = {0.0, 1e-6, 0.0};
  EXPECT_NE(compose_hud(facts).find("holding peg (steel), in contact"), std::string::npos) << compose_hud(facts);
  facts.state.visual_turn.setZero();
  facts.state.visual_offset_m = {0.0, 0.0, 1e-6};
  EXPECT_NE(compose_hud(facts).find("holding peg (steel), in contact"), std::string::npos) << compose_hud(facts);
  facts.state.contact = false;
  EXPECT_NE(compose_hud(facts).find("holding peg (steel)"), std::string::npos);
  EXPECT_EQ(compose_hud(facts).find("free"), std::string::npos);
}

// A magnet pulls, or the air is as viscous as honey: there is a force, but nothing is touched.
TEST(Hud, AForceInFreeSpaceIsNoTouch) {
  HudFacts facts;
  facts.is_connected = true;
  facts.state.contact = true;
  facts.state.force_n = {0.0, 0.0, 0.05};
  EXPECT_EQ(compose_hud(facts).find("touching"), std::string::npos) << compose_hud(facts);
  EXPECT_NE(compose_hud(facts).find("free, a force in space"), std::string::npos) << compose_hud(facts);
  facts.state.visual_offset_m = {0.0, 0.0, 1e-6};
  EXPECT_NE(compose_hud(facts).find("touching"), std::string::npos) << "a method that does not name the object";
  facts.state.visual_offset_m.setZero();
  facts.state.object = 2;
  EXPECT_NE(compose_hud(facts).find("touching"), std::string::npos) << "a needle in it";
}

TEST(Hud, AMeterShowsTheEnergyThatTheHandWasGiven) {
  HudFacts facts;
  facts.is_connected = true;
  EXPECT_EQ(compose_hud(facts).find("energy"), std::string::npos);
  facts.state.energy_percent = 34;
  EXPECT_NE(compose_hud(facts).find("energy given [####......] 34 %"), std::string::npos) << compose_hud(facts);
  facts.state.energy_percent = 120;
  EXPECT_NE(compose_hud(facts).find("[##########] 120 %"), std::string::npos) << compose_hud(facts);
}

TEST(Hud, NumbersThatAreNotFiniteDoNotBreakIt) {
  HudFacts facts;
  facts.is_connected = true;
  facts.state.force_n = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NE(compose_hud(facts).find("0.00 N"), std::string::npos);
}

TEST(Hud, SaysHowFarTheLevelsOfDetailAre) {
  HudFacts facts;
  EXPECT_EQ(compose_hud(facts).find("detail"), std::string::npos);
  facts.detail_progress = 0.42;
  EXPECT_NE(compose_hud(facts).find("detail 42 %"), std::string::npos);
}

TEST(Hud, SaysWhyThereIsNoForce) {
  HudFacts facts;
  facts.is_connected = true;
  const std::pair<ProbeStatus, const char*> statuses[] = {{ProbeStatus::no_haptics, "no haptics_node replies"},
                                                          {ProbeStatus::fault_latched, "hapton set --reset-faults"},
                                                          {ProbeStatus::device_away, "the device is away"},
                                                          {ProbeStatus::calibrating, "being calibrated"}};
  for (const auto& [status, text] : statuses) {
    facts.state.status = status;
    EXPECT_NE(compose_hud(facts).find(text), std::string::npos) << text;
    EXPECT_EQ(compose_hud(facts).find("free"), std::string::npos) << text;
  }
  facts.state.status = ProbeStatus::ok;
  EXPECT_NE(compose_hud(facts).find("free"), std::string::npos);
}

// The network is too slow, so the text must not send the user to look for haptics_node.
TEST(Hud, SaysThatRepliesComeTooLate) {
  HudFacts facts;
  facts.is_connected = true;
  facts.state.status = ProbeStatus::no_haptics;
  facts.state.round_trip_p50_us = 19'000.0F;
  EXPECT_NE(compose_hud(facts).find("NO FORCE: no haptics_node replies"), std::string::npos);
  facts.state.round_trip_p50_us = 41'200.0F;
  EXPECT_NE(compose_hud(facts).find("NO FORCE: replies of haptics_node take 41 ms, a force lasts 20 ms"), std::string::npos)
      << compose_hud(facts);
  EXPECT_EQ(compose_hud(facts).find("no haptics_node replies"), std::string::npos);
  facts.state.status = ProbeStatus::ok;
  EXPECT_EQ(compose_hud(facts).find("NO FORCE"), std::string::npos) << "io_node computes it";
}

TEST(Hud, WarnsOfASceneOutOfReachOrDifferentFromTheHapticOne) {
  HudFacts facts;
  facts.is_connected = true;
  const std::string plain = compose_hud(facts);
  const auto lines = std::count(plain.begin(), plain.end(), '\n');
  facts.state.status = ProbeStatus::out_of_reach;
  EXPECT_NE(compose_hud(facts).find("CANNOT REACH"), std::string::npos);
  EXPECT_NE(compose_hud(facts).find("free"), std::string::npos);
  facts.state.status = ProbeStatus::too_small;
  EXPECT_NE(compose_hud(facts).find("FAR TOO SMALL"), std::string::npos);
  facts.state.status = ProbeStatus::hand_inside;
  EXPECT_NE(compose_hud(facts).find("INSIDE A BODY"), std::string::npos);
  EXPECT_NE(compose_hud(facts).find("free"), std::string::npos);
  facts.state.status = ProbeStatus::ok;
  facts.is_other_scene = true;
  const std::string text = compose_hud(facts);
  EXPECT_NE(text.find("ANOTHER SCENE"), std::string::npos);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), lines + 1);
  facts.is_other_scene = false;
  facts.is_other_tool = true;
  EXPECT_NE(compose_hud(facts).find("ANOTHER TOOL"), std::string::npos);
}

TEST(HudNotice, SaysWhyNothingCanBeTouchedHowLargeTheSceneIsAndWhatToDo) {
  HudFacts facts;
  facts.scene_diameter_m = 1e-4;
  facts.state.status = ProbeStatus::too_small;
  EXPECT_EQ(compose_notice(facts), "") << "without a hub that is what is wrong";
  facts.is_connected = true;
  EXPECT_NE(compose_notice(facts).find("0.1 mm across"), std::string::npos) << compose_notice(facts);
  EXPECT_NE(compose_notice(facts).find("--unit"), std::string::npos);
  facts.state.status = ProbeStatus::out_of_reach;
  facts.scene_diameter_m = 0.25;
  facts.scene_distance_m = 254.0;
  EXPECT_NE(compose_notice(facts).find("250 mm across, 254 m away"), std::string::npos) << compose_notice(facts);
  facts.state.status = ProbeStatus::ok;
  EXPECT_EQ(compose_notice(facts), "");
  facts.is_other_scene = true;
  EXPECT_NE(compose_notice(facts).find("another scene"), std::string::npos);
  facts.is_other_scene = false;
  facts.is_other_tool = true;
  EXPECT_NE(compose_notice(facts).find("another tool"), std::string::npos);
}

TEST(HudNotice, IsEmptyWhereTheCornerSaysItAll) {
  HudFacts facts;
  facts.is_connected = true;
  for (const ProbeStatus status :
       {ProbeStatus::no_haptics, ProbeStatus::fault_latched, ProbeStatus::device_away, ProbeStatus::calibrating}) {
    facts.state.status = status;
    EXPECT_EQ(compose_notice(facts), "");
  }
}

TEST(Hud, NamesEveryKey) {
  for (const char* key : {"x X", "y Y", "z Z", " 1 2 3 4 ", " p ", " b ", " s ", " h ",    " q ",  " m ",
                          " e ", " f ", " r ", " g ",       " c ", " w ", " o ", "arrows", "page", "home"})
    EXPECT_NE(keys_help().find(key), std::string_view::npos) << key;
}

TEST(Hud, ShowsWhichButtonsTheHandOnTheMouseHolds) {
  HudFacts facts;
  facts.is_connected = true;
  facts.state.buttons = 0b1010;
  EXPECT_EQ(compose_hud(facts).find("button"), std::string::npos) << "a stylus in a hand is not shown by a key";
  facts.is_hand_led = true;
  EXPECT_NE(compose_hud(facts).find("hand on the mouse, button 2, button 4"), std::string::npos) << compose_hud(facts);
}

TEST(Hud, WhatIsDrawnHasALineOfItsOwn) {
  HudFacts facts;
  const std::string without = compose_hud(facts);
  facts.annotations = "3 strokes, 1 measure";
  EXPECT_EQ(compose_hud(facts), without + "\n3 strokes, 1 measure");
}

}  // namespace
}  // namespace hapton
