#include "devices/haply_messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace hapton::haply {
namespace {

TEST(HaplyMessages, AxesBecomeThoseOfTheWorld) {
  EXPECT_TRUE(to_w(Vec3(0, -0.12, 0.15)).isZero()) << "home";
  EXPECT_TRUE(to_w(Vec3(0.01, -0.12, 0.15)).isApprox(Vec3(0.01, 0, 0), 1e-12)) << "right";
  EXPECT_TRUE(to_w(Vec3(0, -0.12, 0.16)).isApprox(Vec3(0, 0.01, 0), 1e-12)) << "up";
  EXPECT_TRUE(to_w(Vec3(0, -0.13, 0.15)).isApprox(Vec3(0, 0, 0.01), 1e-12)) << "towards the user";
  EXPECT_EQ(force_from_w(Vec3(1, 2, 3)), Vec3(1, -3, 2));
}

TEST(HaplyMessages, ForcesAndPositionsTurnAlike) {
  const Vec3 f_W(0.3, -0.2, 0.5);
  const Vec3 f = force_from_w(f_W);
  EXPECT_TRUE((to_w(f) - to_w(Vec3(Vec3::Zero()))).isApprox(f_W, 1e-12));
}

TEST(HaplyMessages, OrientationsTurnWithTheAxes) {
  // A quarter turn about the service's z, which is up: about W's y.
  const Quat q(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitZ()));
  EXPECT_LT(to_w(q).angularDistance(Quat(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY()))), 1e-12);
}

TEST(HaplyMessages, AStateGivesCursorGripAndCalibration) {
  const auto state = read_state(R"({"session_id":7,
    "inverse3":[{"device_id":"049D","config":{"type":"inverse3x","extended_firmware_version":"7.4"},
                 "state":{"cursor_position":{"x":0.01,"y":-0.12,"z":0.15}},"status":{"calibrated":false}}],
    "wireless_verse_grip":[{"device_id":"61","state":{"orientation":{"w":1,"x":0,"y":0,"z":0},"buttons":{"a":true,"c":true}}}]})");
  ASSERT_TRUE(state);
  ASSERT_EQ(state->arms.size(), 1U);
  EXPECT_EQ(state->arms[0].id, "049D");
  EXPECT_EQ(state->arms[0].model, "inverse3x");
  EXPECT_EQ(state->arms[0].firmware, "7.4");
  EXPECT_FALSE(state->arms[0].is_calibrated);
  EXPECT_NEAR(state->arms[0].p_WD.x(), 0.01, 1e-12);
  ASSERT_TRUE(state->grip);
  EXPECT_EQ(state->grip->buttons, 5U);
}

TEST(HaplyMessages, WhatIsMissingOrOfAnotherKindIsLeftOut) {
  for (const char* text : {"{}", R"({"inverse3":7})", R"({"inverse3":[7,null,{}]})", R"({"inverse3":[{"device_id":"a"}]})",
                           R"({"inverse3":[{"device_id":"a","state":{"cursor_position":{"x":"1","y":0,"z":0}}}]})",
                           R"({"inverse3":[{"device_id":"","state":{"cursor_position":{"x":1,"y":0,"z":0}}}]})",
                           R"({"inverse3":[{"device_id":"a","state":{"cursor_position":{"x":1e999,"y":0,"z":0}}}]})"}) {
    const auto state = read_state(text);
    if (state) {
      EXPECT_TRUE(state->arms.empty()) << text;
    }
  }
  const auto state = read_state(R"({"wireless_verse_grip":[{"state":{"orientation":{"w":9,"x":0,"y":0,"z":0}}}]})");
  ASSERT_TRUE(state && state->grip);
  EXPECT_EQ(state->grip->q_WT.coeffs(), Quat::Identity().coeffs()) << "an orientation that is none";
}

TEST(HaplyMessages, WhatIsNoObjectIsAnError) {
  for (const char* text : {"", "7", "[]", "{", "null", "\xff"}) EXPECT_FALSE(read_state(text)) << text;
}

TEST(HaplyMessages, TheFirstNamesUsAndTheAxesAndExertsNoForce) {
  EXPECT_EQ(first_message("049D"), R"({"session":{"configure":{"profile":{"name":"org.hapton:io_node"},"basis":{"permutation":"XYZ"}}},)"
                                   R"("inverse3":[{"device_id":"049D","commands":{"set_cursor_force":{"vector":{"x":0,"y":0,"z":0}}}}]})");
}

TEST(HaplyMessages, TheOthersCarryTheForceAlone) {
  EXPECT_EQ(force_message("049D", Vec3(1, 0.5, -0.25)),
            R"({"inverse3":[{"device_id":"049D","commands":{"set_cursor_force":{"vector":{"x":1,"y":0.25,"z":0.5}}}}]})");
}

TEST(HaplyMessages, AnIdCannotBreakOutOfItsQuotes) {
  EXPECT_THAT(force_message("a\"},{\"", Vec3::Zero()), testing::HasSubstr(R"("device_id":"a\"},{\"")"));
}

}  // namespace
}  // namespace hapton::haply
