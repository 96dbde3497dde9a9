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
  EXPECT_NEAR(state->arms[0].position_m.x(), 0.01, 1e-12);
  ASSERT_TRUE(state->grip);
  EXPECT_EQ(state->grip->buttons, 5U);
}

// Of several grips of one kind the first is used, and a wireless grip is used rather than one with a cable.
TEST(HaplyMessages, TheFirstGripCountsAndAWirelessOneBeforeOneWithACable) {
  const auto buttons = [](const std::string& text) {
    const auto state = read_state(text);
    return state && state->grip ? static_cast<int>(state->grip->buttons) : -1;
  };
  const std::string grips_with_a_and_b = R"([{"state":{"buttons":{"a":true}}},{"state":{"buttons":{"b":true}}}])";
  const std::string grip_with_c = R"([{"state":{"buttons":{"c":true,"a":false,"b":7}}}])";
  EXPECT_EQ(buttons(R"({"wireless_verse_grip":)" + grips_with_a_and_b + "}"), 1);
  EXPECT_EQ(buttons(R"({"verse_grip":)" + grips_with_a_and_b + "}"), 1);
  EXPECT_EQ(buttons(R"({"verse_grip":)" + grips_with_a_and_b + R"(,"wireless_verse_grip":)" + grip_with_c + "}"), 4);
  EXPECT_EQ(buttons(R"({"verse_grip":)" + grips_with_a_and_b + R"(,"wireless_verse_grip":[]})"), 1);
  EXPECT_EQ(buttons(R"({"verse_grip":)" + grips_with_a_and_b + R"(,"wireless_verse_grip":{"state":{}}})"), 1) << "no list";
  EXPECT_EQ(buttons(R"({"verse_grip":)" + grips_with_a_and_b + R"(,"wireless_verse_grip":[{}]})"), 1) << "it has no state";
  EXPECT_EQ(buttons(R"({"verse_grip":[{"state":{}}]})"), 0);
  EXPECT_EQ(buttons(R"({"verse_grip":[{}]})"), -1);
  EXPECT_EQ(buttons("{}"), -1);
}

// An arm that does not report its calibration counts as calibrated, and its model may be unknown.
TEST(HaplyMessages, AnArmIsCalibratedUnlessItSaysOtherwise) {
  const auto arm = [](const std::string& more) {
    const auto state =
        read_state(R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":0.01,"y":0.02,"z":0.03}})" + more + "}]}");
    return state && state->arms.size() == 1 ? state->arms[0] : Arm();
  };
  EXPECT_TRUE(arm("").is_calibrated);
  EXPECT_TRUE(arm(R"(,"status":{})").is_calibrated);
  EXPECT_TRUE(arm(R"(,"status":{"calibrated":7})").is_calibrated);
  EXPECT_TRUE(arm(R"(,"status":{"calibrated":true})").is_calibrated);
  EXPECT_FALSE(arm(R"(,"status":{"calibrated":false})").is_calibrated);
  EXPECT_EQ(arm("").position_m, Vec3(0.01, 0.02, 0.03));
  EXPECT_EQ(arm("").model, "");
  EXPECT_EQ(arm("").firmware, "");
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
            R"({"inverse3":[{"device_id":"049D","commands":{"set_cursor_force":{"vector":{"x":1,"y":0.5,"z":-0.25}}}}]})");
  EXPECT_EQ(Session().force_from_w(Vec3(1, 0.5, -0.25)), Vec3(1, 0.25, 0.5));
}

TEST(HaplyMessages, TheVersionIsReadWithAndWithoutAnEnvelope) {
  for (const char* text : {R"({"project_version":"3.5.2.0","git_tag":"x"})", R"({"ok":true,"data":{"project_version":"3.5.2.0"}})"}) {
    const auto version = read_version(text);
    ASSERT_TRUE(version) << text;
    EXPECT_EQ(version->major, 3);
    EXPECT_EQ(version->minor, 5);
  }
  for (const char* text : {"", "7", "{}", "[]", R"({"project_version":7})", R"({"project_version":"new"})"}) {
    EXPECT_FALSE(read_version(text)) << text;
  }
}

TEST(HaplyMessages, OtherVersionsAreNamedWithWhatToDo) {
  EXPECT_EQ(describe_version_problem({3, 5}), "");
  EXPECT_EQ(describe_version_problem({3, 12}), "");
  for (const Version old : {Version{2, 9}, Version{3, 0}, Version{3, 4}}) {
    EXPECT_THAT(describe_version_problem(old), testing::HasSubstr("update the service"));
  }
  EXPECT_THAT(describe_version_problem({4, 0}), testing::HasSubstr("a newer Hapton"));
}

// The service applies its transforms in this order: device, mount, workspace, application.
TEST(HaplyMessages, PositionsAndForcesAreThoseOfTheDeviceWhateverTheSessionPlacesIt) {
  Session session;
  Arm arm;
  arm.mount = {Vec3(0.1, 0.2, 0.3), Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized())), Vec3::Ones()};
  arm.transform = {Vec3(-0.5, 0, 0.25), Quat(Eigen::AngleAxisd(-1.9, Vec3(0, 1, 1).normalized())), Vec3::Ones()};
  session.update(arm);
  ASSERT_FALSE(session.is_scaled());
  const auto placed = [&](const Vec3& p) {
    const Vec3 mounted = *arm.mount.position_m + *arm.mount.rotation * p;
    return Vec3(*arm.transform.position_m + *arm.transform.rotation * mounted);
  };
  const Vec3 p(0.02, -0.1, 0.17), f_W(0.5, -1, 2);
  EXPECT_TRUE(session.to_w(placed(p)).isApprox(to_w(p), 1e-12));
  // The work of a force is the same in both frames.
  const Vec3 step(1e-3, -2e-3, 5e-4);
  EXPECT_NEAR(session.force_from_w(f_W).dot(placed(p + step) - placed(p)), f_W.dot(to_w(p + step) - to_w(p)), 1e-15);
}

TEST(HaplyMessages, APartialTransformKeepsTheRest) {
  Session session;
  Arm arm;
  arm.transform.position_m = Vec3(0.1, 0, 0);
  session.update(arm);
  arm.transform = {};
  arm.transform.rotation = Quat(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitZ()));
  session.update(arm);
  session.update(Arm{});
  EXPECT_TRUE(session.to_w(Vec3(0.1, 0.02, 0)).isApprox(to_w(Vec3(0.02, 0, 0)), 1e-12));
  arm.transform.scale = Vec3(1, 1, 3);
  session.update(arm);
  EXPECT_TRUE(session.is_scaled());
}

TEST(HaplyMessages, MountAndTransformAreReadFromAnInventory) {
  const auto state = read_state(R"({"inverse3":[{"device_id":"a",
    "config":{"mount":{"position":{"x":1,"y":2,"z":3},"rotation":{"w":1,"x":0,"y":0,"z":0},"scale":{"x":1,"y":1,"z":2}}},
    "state":{"cursor_position":{"x":0,"y":0,"z":0},
             "transform":{"position":{"x":"1","y":0,"z":0},"rotation":{"w":9,"x":0,"y":0,"z":0}}}}]})");
  ASSERT_TRUE(state && state->arms.size() == 1);
  const Arm& arm = state->arms[0];
  ASSERT_TRUE(arm.mount.position_m && arm.mount.rotation && arm.mount.scale);
  EXPECT_EQ(*arm.mount.position_m, Vec3(1, 2, 3));
  EXPECT_TRUE(arm.mount.is_scaled());
  EXPECT_FALSE(arm.transform.position_m || arm.transform.rotation || arm.transform.scale) << "invalid parts are left out";
}

TEST(HaplyMessages, AnIdCannotBreakOutOfItsQuotes) {
  EXPECT_THAT(force_message("a\"},{\"", Vec3::Zero()), testing::HasSubstr(R"("device_id":"a\"},{\"")"));
}

TEST(HaplyMessages, AGripWithACableCountsWhereThereIsNoneWithout) {
  const auto buttons_of = [](const char* text) {
    const auto state = read_state(text);
    return state && state->grip ? static_cast<int>(state->grip->buttons) : -1;
  };
  EXPECT_EQ(buttons_of("{}"), -1);
  EXPECT_EQ(buttons_of(R"({"verse_grip":[{"state":{"buttons":{"b":true}}}]})"), 2);
  EXPECT_EQ(buttons_of(R"({"wireless_verse_grip":[],"verse_grip":[{"state":{"buttons":{"b":true}}}]})"), 2);
  EXPECT_EQ(buttons_of(R"({"wireless_verse_grip":[{"state":{"buttons":{"a":true}}}],"verse_grip":[{"state":{"buttons":{"b":true}}}]})"), 1);
}

}  // namespace
}  // namespace hapton::haply
