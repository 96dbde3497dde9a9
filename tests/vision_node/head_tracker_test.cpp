#include "vision_node/head_tracker.h"

#include <numbers>

#include <gtest/gtest.h>

#include "runtime/log.h"
#include "tests/vrpn/made_tracker.h"

namespace hapton {
namespace {

using vrpn::MadeTracker;
using vrpn::say_pose;

struct HeadTrackerTest : testing::Test {
  static void SetUpTestSuite() { start_log("test"); }

  MadeTracker server;
  HeadSource source;
  std::unique_ptr<HeadTracker> tracker;
  std::optional<Head> head;
  std::int64_t last_take_ns = 0;  // time of the last take_head() in wait_for_head()

  void open() {
    source.tracker = vrpn::TrackerName{"Head0", to_string(server.address())};
    tracker = std::move(*HeadTracker::open(source, 0.063));
  }
  bool wait_for_head(const vrpn::Bytes& message) {
    head.reset();
    return server.attend_until([&](std::int64_t now_ns) {
      server.say(message);
      last_take_ns = now_ns;
      head = tracker->take_head(now_ns);
      return head.has_value();
    });
  }
};

TEST(HeadInputTest, IsKeysASpaceMouseOrATracker) {
  EXPECT_FALSE(parse_head_input("keys")->tracker || parse_head_input("keys")->is_space_mouse);
  EXPECT_TRUE(parse_head_input("spacemouse")->is_space_mouse);
  const auto input = parse_head_input("vrpn:Head0@127.0.0.1:3884");
  ASSERT_TRUE(input && input->tracker);
  EXPECT_EQ(input->tracker->device, "Head0");
  EXPECT_EQ(input->tracker->host, "127.0.0.1:3884");
  for (const char* text : {"", "key", "vrpn:", "vrpn:Head0", "Head0@host", "vrpn:@host", "spacemouse:"}) {
    const auto none = parse_head_input(text);
    ASSERT_FALSE(none) << text;
    EXPECT_EQ(none.error().what.find('\n'), std::string::npos);
  }
}

// Expected values are computed by hand. The tracker is above the screen; its z axis is the screen's y axis, its y axis the screen's -z.
TEST(FindHead, PutsTrackerSensorAndEyesTogether) {
  HeadSource source;
  source.X_RT = Eigen::Translation3d(0.0, 0.25, 0.1) * Eigen::AngleAxisd(-std::numbers::pi / 2, Vec3::UnitX());
  source.p_BH = Vec3(0.0, -0.08, 0.02);
  const Quat turned(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX()));
  const Head head = find_head(source, {{0.1, -0.5, 0.2}, turned});
  EXPECT_LT((head.p_RH - Vec3(0.1, 0.25 + 0.2 - 0.08, 0.1 + 0.5 + 0.02)).norm(), 1e-12) << head.p_RH.transpose();
  EXPECT_LT((head.q_RH * Vec3::UnitY() - Vec3::UnitY()).norm(), 1e-12) << "upright";
}

TEST_F(HeadTrackerTest, BringsTheHead) {
  source.X_RT = Eigen::Translation3d(0.0, 0.3, 0.0);
  open();
  EXPECT_FALSE(tracker->take_head(0));
  EXPECT_EQ(tracker->describe(0), "") << "it has hardly begun";
  ASSERT_TRUE(wait_for_head(say_pose(0, {0.05, -0.25, 0.7})));
  EXPECT_LT((head->p_RH - Vec3(0.05, 0.05, 0.7)).norm(), 1e-12);
  EXPECT_EQ(tracker->describe(last_take_ns), "");
}

TEST_F(HeadTrackerTest, SaysWhenTheHeadIsLostAndWhenItIsBack) {
  open();
  ASSERT_TRUE(wait_for_head(say_pose(0, {0, 0, 0.7})));
  const std::int64_t later_ns = last_take_ns + HeadTracker::kStaleNs + 2'500'000'000;
  EXPECT_FALSE(tracker->take_head(later_ns));
  EXPECT_NE(tracker->describe(later_ns).find("has sent no pose for 3 s"), std::string::npos) << tracker->describe(later_ns);
  EXPECT_EQ(tracker->describe(later_ns).find('\n'), std::string::npos);
  ASSERT_TRUE(wait_for_head(say_pose(0, {0, 0, 0.7})));
  EXPECT_EQ(tracker->describe(last_take_ns), "");
}

TEST_F(HeadTrackerTest, AHeadInTheScreenOrBehindItIsNotTaken) {
  open();
  ASSERT_TRUE(wait_for_head(say_pose(0, {0, 0, 0.7})));
  bool is_reported = false;
  ASSERT_TRUE(server.attend_until([&](std::int64_t now_ns) {
    server.say(say_pose(0, {0, 0, -0.7}));
    const auto accepted = tracker->take_head(now_ns);
    EXPECT_TRUE(!accepted || accepted->p_RH.z() == 0.7);
    is_reported = tracker->describe(now_ns).find("-700 mm, which is not in front of the screen") != std::string::npos;
    return is_reported;
  }));
}

TEST_F(HeadTrackerTest, NamesWhatTheServerHasWhereTheSensorIsNotThere) {
  server.set_hello(vrpn::say_hello("Wand0"));
  open();
  std::string description;
  ASSERT_TRUE(server.attend_until([&](std::int64_t now_ns) {
    EXPECT_FALSE(tracker->take_head(now_ns));
    description = tracker->describe(now_ns);
    return description.find("Wand0") != std::string::npos;
  }));
  EXPECT_NE(description.find("sensor 0"), std::string::npos) << description;
}

TEST_F(HeadTrackerTest, SaysThatNobodyReplies) {
  source.tracker = vrpn::TrackerName{"Head0", "127.0.0.1:1"};
  tracker = std::move(*HeadTracker::open(source, 0.063));
  tracker->take_head(0);
  tracker->take_head(2'000'000'000);
  EXPECT_NE(tracker->describe(2'000'000'000).find("no VRPN server replies for Head0@127.0.0.1:1"), std::string::npos);
}

}  // namespace
}  // namespace hapton
