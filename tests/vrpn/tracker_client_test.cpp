#include "vrpn/tracker_client.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/vrpn/hex.h"
#include "tests/vrpn/made_tracker.h"

namespace hapton::vrpn {
namespace {

// What a server of VRPN 07.38 sends: cookie, a tracker "Head0" as number 2, the type as number 9, one pose of sensor 1.
constexpr std::string_view kRecorded =
    "7672706e3a207665722e2030372e333820203000000000 00"
    "00000022 00000000 00000000 00000002 ffffffff 00000001  00000006 486561643000 000000000000"
    "00000032 00000000 00000000 00000009 fffffffe 00000002  00000016 7672706e5f547261636b657220506f735f5175617400 000000000000"
    "00000058 65000000 00000010 00000002 00000009 00000003  00000001 00000000"
    "3fe0000000000000 bff0000000000000 4000000000000000  0000000000000000 0000000000000000 bfe6a09e667f3bcd 3fe6a09e667f3bcd";

void expect_recorded_pose(const TrackerPose& pose) {
  EXPECT_EQ(pose.p_m, Vec3(0.5, -1.0, 2.0));
  EXPECT_LT((pose.q.coeffs() - Eigen::Vector4d(0.0, 0.0, -std::sqrt(0.5), std::sqrt(0.5))).norm(), 1e-15) << "x, y, z, w";
}

struct Connected : testing::Test {
  TrackerClient client{"Head0", 0};
  Connected() { EXPECT_TRUE(client.receive(say_hello("Head0"))); }
};
using VrpnTrackerClient = Connected;

TEST(VrpnTracker, ReadsARecordedStreamInOnePiece) {
  TrackerClient client("Head0", 1);
  ASSERT_TRUE(client.receive(hex(kRecorded)));
  const auto pose = client.take_newest();
  ASSERT_TRUE(pose);
  expect_recorded_pose(*pose);
  EXPECT_FALSE(client.take_newest()) << "once";
}

TEST(VrpnTracker, ReadsARecordedStreamByteByByteAndHasNothingBeforeItsEnd) {
  TrackerClient client("Head0", 1);
  const Bytes bytes = hex(kRecorded);
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_FALSE(client.take_newest()) << n;
    EXPECT_EQ(client.is_connected(), n >= kCookieBytes) << n;
    ASSERT_TRUE(client.receive(std::span(bytes).subspan(n, 1))) << n;
  }
  const auto pose = client.take_newest();
  ASSERT_TRUE(pose);
  expect_recorded_pose(*pose);
}

TEST(VrpnTracker, IntroducesItselfWithTheCookieAndTheTrackersName) {
  TrackerClient client("Head0", 0);
  Bytes expected;
  append_cookie(expected);
  EXPECT_EQ(to_hex(client.out()), to_hex(expected));
  client.out().clear();
  client.receive(say_hello("Head0"));
  client.ping();
  expected.clear();
  append_description(expected, kSenderDescription, 0, "Head0", {}, 1);
  append_description(expected, kTypeDescription, 0, "vrpn_Base ping_message", {}, 2);
  append_empty(expected, {0, 0, {}, 3});
  EXPECT_EQ(to_hex(client.out()), to_hex(expected));
}

TEST_F(VrpnTrackerClient, TheNewestPoseWins) {
  for (const double x : {1.0, 2.0, 3.0}) client.receive(say_pose(0, {x, 0, 0}));
  EXPECT_EQ(client.take_newest()->p_m.x(), 3.0);
}

TEST_F(VrpnTrackerClient, OtherSensorsAndOtherTrackersAreNotOurs) {
  client.receive(say_pose(1, {1, 0, 0}));
  Bytes other;
  append_position(other, {kMadeSender + 1, kMadeType, {}, 1}, 0, {1, 0, 0}, Quat::Identity());
  append_position(other, {kMadeSender, kMadeType + 1, {}, 1}, 0, {1, 0, 0}, Quat::Identity());
  EXPECT_TRUE(client.receive(other));
  EXPECT_FALSE(client.take_newest());
}

TEST_F(VrpnTrackerClient, ButtonsAreThoseOfTheDeviceAsTheServerLastSaid) {
  constexpr std::int32_t kChange = 11, kStates = 12;
  Bytes bytes;
  append_description(bytes, kTypeDescription, kChange, "vrpn_Button Change", {}, 3);
  append_description(bytes, kTypeDescription, kStates, "vrpn_Button States", {}, 4);
  append_button_change(bytes, {kMadeSender, kChange, {}, 5}, 3, true);
  append_button_change(bytes, {kMadeSender, kChange, {}, 6}, 31, true);
  append_button_change(bytes, {kMadeSender + 1, kChange, {}, 7}, 0, true);  // of another device
  for (const std::int32_t none : {-1, 32, 1 << 30}) append_button_change(bytes, {kMadeSender, kChange, {}, 8}, none, true);
  ASSERT_TRUE(client.receive(bytes));
  EXPECT_EQ(client.buttons(), 1U << 3 | 1U << 31);
  bytes.clear();
  append_button_change(bytes, {kMadeSender, kChange, {}, 9}, 3, false);
  ASSERT_TRUE(client.receive(bytes));
  EXPECT_EQ(client.buttons(), 1U << 31);
  EXPECT_EQ(client.reported_buttons(), 1U << 3 | 1U << 31);
  bytes.clear();
  append_button_states(bytes, {kMadeSender, kStates, {}, 10}, 0b101, 3);
  ASSERT_TRUE(client.receive(bytes));
  EXPECT_EQ(client.buttons(), 0b101U);
  EXPECT_EQ(client.reported_buttons(), 0xFFFFFFFFU) << "the states are those of all buttons";
  bytes.clear();
  append_button_states(bytes, {kMadeSender, kChange, {}, 11}, 0b11, 2);  // not a change of a button: its length is wrong
  ASSERT_TRUE(client.receive(bytes));
  EXPECT_EQ(client.buttons(), 0b101U);
}

TEST_F(VrpnTrackerClient, ANumberThatIsDescribedAnewMeansTheNewThing) {
  Bytes other;
  append_description(other, kSenderDescription, kMadeSender, "Wand0", {}, 1);
  client.receive(other);
  client.receive(say_pose(0, {1, 0, 0}));
  EXPECT_FALSE(client.take_newest());
  Bytes back;
  append_description(back, kSenderDescription, kMadeSender, "Head0", {}, 1);
  append_description(back, kTypeDescription, kMadeType, "vrpn_Tracker Velocity", {}, 1);
  client.receive(back);
  client.receive(say_pose(0, {1, 0, 0}));
  EXPECT_FALSE(client.take_newest());
}

TEST_F(VrpnTrackerClient, InvalidPosesAreIgnored) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (const Vec3& p : {Vec3(kNaN, 0, 0), Vec3(0, kInfinite, 0), Vec3(0, 0, -kInfinite)}) client.receive(say_pose(0, p));
  for (const Quat& q : {Quat(0, 0, 0, 0), Quat(kNaN, 0, 0, 0), Quat(0, 1e300, 0, 0), Quat(1e-3, 0, 0, 0), Quat(0, 0, kInfinite, 0)}) {
    client.receive(say_pose(0, Vec3::Zero(), q));
  }
  for (const double length : {0.5, 2.0, 0.49, 2.01}) client.receive(say_pose(0, Vec3::Zero(), Quat(0, length, 0, 0)));
  EXPECT_FALSE(client.take_newest());
  for (const double length : {0.51, 1.99}) {
    client.receive(say_pose(0, Vec3::Zero(), Quat(0, length, 0, 0)));
    EXPECT_TRUE(client.take_newest()) << length;
  }
  client.receive(say_pose(0, Vec3::Zero(), Quat(0.9, 0, 0, 0)));
  EXPECT_NEAR(client.take_newest()->q.norm(), 1.0, 1e-15) << "a rounded one is normalised";
}

TEST_F(VrpnTrackerClient, ABodyOfAnotherLengthIsNoPose) {
  for (const std::size_t length : {std::size_t{24}, std::size_t{28}, std::size_t{87}, std::size_t{80}}) {
    Bytes bytes = say_pose(0, {1, 0, 0});
    bytes.resize((length + 7) / 8 * 8);
    bytes[3] = static_cast<std::byte>(length);
    EXPECT_TRUE(client.receive(bytes)) << length;
  }
  EXPECT_FALSE(client.take_newest());
  client.receive(say_pose(0, {1, 0, 0}));
  EXPECT_TRUE(client.take_newest()) << "and what follows is understood";
}

TEST_F(VrpnTrackerClient, DisconnectsAtAGoodbyeAndAtInvalidLengths) {
  Bytes goodbye;
  append_empty(goodbye, {0, kDisconnect, {}, 1});
  EXPECT_FALSE(client.receive(goodbye));
  for (const char* length : {"00000000", "00000017", "0000fa01", "7fffffff", "ffffffff"}) {
    TrackerClient other("Head0", 0);
    other.receive(say_hello("Head0"));
    EXPECT_FALSE(other.receive(hex(std::string(length) + "0000000000000000000000000000000000000000"))) << length;
  }
}

TEST(VrpnTracker, WhatIsNotVrpnIsClosed) {
  for (const std::string& text : {std::string("HTTP/1.1 400 Bad Request"), std::string("vrpn: ver. 06.00  00000"), std::string(24, '\0')}) {
    TrackerClient client("Head0", 0);
    const auto bytes = std::as_bytes(std::span(text));
    EXPECT_TRUE(client.receive(bytes.first(std::min<std::size_t>(10, bytes.size()))));
    Bytes rest(bytes.begin() + 10, bytes.end());
    rest.resize(kCookieBytes);
    EXPECT_FALSE(client.receive(rest)) << text;
  }
}

TEST(VrpnTracker, NamesAFewDevicesInPrintableLetters) {
  TrackerClient client("Head0", 0);
  EXPECT_EQ(client.describe_devices(), "");
  client.receive(say_hello("Wand\n\x1b[0"));
  EXPECT_EQ(client.describe_devices(), "Wand??[0");
  Bytes many;
  for (int n = 0; n < 1000; ++n) append_description(many, kSenderDescription, n, "D" + std::to_string(n), {}, 1);
  for (int n = 0; n < 1000; ++n) append_description(many, kSenderDescription, n, "D0", {}, 1);
  EXPECT_TRUE(client.receive(many));
  EXPECT_EQ(client.describe_devices(), "Wand??[0, D0, D1, D2, D3, D4, D5, D6");
}

// Streams with a few bytes changed, cut off and repeated: nothing but a finite pose ever comes out.
TEST(VrpnTracker, DamagedStreamsGiveOnlyFinitePoses) {
  constexpr std::uint64_t kSeed = 17;
  std::mt19937_64 random(kSeed);
  const Bytes good = hex(kRecorded);
  int poses = 0, closed = 0;
  for (int round = 0; round < 20'000; ++round) {
    Bytes bytes = good;
    for (std::uint64_t n = random() % 4; n > 0; --n) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    bytes.resize(1 + random() % bytes.size());
    if (random() % 2 == 0) bytes.insert(bytes.end(), good.begin(), good.end());
    TrackerClient client("Head0", 1);
    for (std::size_t from = 0; from < bytes.size();) {
      const std::size_t piece = std::min<std::size_t>(1 + random() % 200, bytes.size() - from);
      if (!client.receive(std::span(bytes).subspan(from, piece))) {
        ++closed;
        break;
      }
      from += piece;
    }
    if (const auto pose = client.take_newest()) {
      ++poses;
      ASSERT_TRUE(pose->p_m.allFinite() && std::abs(pose->q.norm() - 1.0) < 1e-12) << "seed " << kSeed << ", round " << round;
    }
    ASSERT_LT(client.out().size(), 512u);
  }
  EXPECT_GT(poses, 100);
  EXPECT_GT(closed, 1000);
}

}  // namespace
}  // namespace hapton::vrpn
