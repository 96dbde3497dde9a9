#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "io_node/vrpn/vrpn_feed.h"
#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

TEST_F(NetworkLoops, VisionReceivesTheProbeAtItsRateWithOffsetAndStatistics) {
  make({.vision_rate_hz = 50.0});
  device.drift.x() = 1e-6;
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  run(1000);
  EXPECT_NEAR(static_cast<double>(probes.size()), 50.0, 2.0);
  const ProbeState& probe = probes.back();
  EXPECT_EQ(probe.visual_offset_m, force_reply.visual_offset_m);
  EXPECT_TRUE(probe.contact);
  EXPECT_EQ(probe.force_n, force_reply.force_n);
  EXPECT_NEAR(probe.servo_rate_hz, 1000.0, 5.0);
  EXPECT_NEAR(probe.round_trip_p50_us, 100.0, 2.0);
  EXPECT_EQ(stats().probe_states_sent, probes.size());
}

// The device moves into a floor at 0.5 m/s, and each reply comes 1.3 ms late: an offset combined with the pose of another sample would be
// wrong by the device's motion between the two.
TEST_F(NetworkLoops, VisionReceivesAPoseAndTheOffsetOfTheSameSample) {
  make();
  device.drift.z() = -0.5e-3;
  floor_z_m = 0.0;
  reply_delay_ns = 1300 * kUs;
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  run(300);
  double largest_error_m = 0.0;
  std::size_t contact_count = 0;
  std::uint64_t last_sample = 0;
  for (const ProbeState& probe : probes) {
    const DeviceState& state = states.at(states.size() - 1 - (states.back().sample - std::max(probe.sample, states.front().sample)));
    EXPECT_GE(probe.sample, last_sample);
    last_sample = probe.sample;
    if (!probe.contact) continue;
    ++contact_count;
    EXPECT_EQ(probe.p_WD, state.p_WD);
    EXPECT_EQ(probe.sample_time_ns, state.sample_time_ns);
    largest_error_m = std::max(largest_error_m, std::fabs((probe.p_WD + probe.visual_offset_m).z() - *floor_z_m));
  }
  EXPECT_GT(contact_count, 40U);
  EXPECT_LE(largest_error_m, 1e-12) << "the probe is drawn beside the surface";
}

TEST_F(NetworkLoops, VisionReceivesTheNewestSampleWithoutHapticsReplies) {
  make();
  device.drift.z() = -0.5e-3;
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  run(200);
  reply_delay_ns = -1;
  run(60);
  EXPECT_FALSE(probes.back().contact);
  EXPECT_EQ(probes.back().visual_offset_m, Vec3(Vec3::Zero()));
  EXPECT_LE(states.back().sample - probes.back().sample, 10U) << "the picture stands still";
}

TEST_F(NetworkLoops, VisionIsServedWithoutHapticsToo) {
  make();
  device.drift.x() = 1e-6;
  join(kVision, NodeRole::vision);
  run(1000);
  EXPECT_NEAR(static_cast<double>(probes.size()), 240.0, 5.0);
  EXPECT_FALSE(probes.back().contact);
}

TEST_F(NetworkLoops, VisionGetsUnchangedStateTenTimesASecondAndChangesAtOnce) {
  make();
  join(kVision, NodeRole::vision);
  run(1000);
  EXPECT_NEAR(static_cast<double>(probes.size()), 12.0, 4.0);                    // not zero, as the statistics change now and then
  EXPECT_NEAR(static_cast<double>(stats().probe_states_unchanged), 228.0, 6.0);  // the others of 240
  const std::size_t before = probes.size();
  device.place.x() += 0.001;
  run(6);
  ASSERT_GT(probes.size(), before);
  EXPECT_EQ(probes.back().p_WD, device.place);
}

TEST_F(NetworkLoops, VisionGetsNoMoreThanItDraws) {
  make();
  device.drift.x() = 1e-6;
  device.stylus_buttons = 0;
  draw_ns = 20 * kMs;
  join(kVision, NodeRole::vision);
  run(1000);
  EXPECT_NEAR(static_cast<double>(probes.size()), 1000.0 / 21.0, 3.0);  // 20 ms to draw, and a cycle
  EXPECT_NEAR(static_cast<double>(stats().drawn), static_cast<double>(probes.size()), 1.0);
  EXPECT_LE(stats().device_to_drawn.max_ns(), 21 * kMs);
}

TEST_F(NetworkLoops, FrameAckGivesTheAgeOfTheFrame) {
  make();
  draw_ns = -1;
  join(kVision, NodeRole::vision);
  run(100);
  const ProbeState probe = probes.back();
  say(kVision, FrameAck{probe.sample, probe.sample_time_ns, 57.0F}, 15 * kMs);
  say(kVision, FrameAck{probe.sample + 1'000'000, probe.sample_time_ns, 57.0F}, 15 * kMs);
  say(kVision, FrameAck{probe.sample, -5, 57.0F}, 15 * kMs);
  const std::int64_t expected = clock.now_ns() + 15 * kMs - probe.sample_time_ns;
  run(30);
  EXPECT_EQ(stats().drawn, 1U);
  EXPECT_EQ(stats().device_to_drawn.max_ns(), expected);
  EXPECT_EQ(stats().frame_rate_hz, 57.0);
}

// No frame was drawn whose age could be measured.
TEST_F(NetworkLoops, APictureThatStayedTheSameIsNoFrame) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  draw_ns = -1;
  run(50);
  ASSERT_FALSE(probes.empty());
  FrameAck ack{.echo_sample = probes.back().sample, .echo_sample_time_ns = probes.back().sample_time_ns, .frame_rate_hz = 30.0F};
  ack.unchanged = true;
  say(kVision, ack);
  run(2);
  EXPECT_EQ(stats().drawn, 0U);
  EXPECT_EQ(stats().device_to_drawn.count(), 0U);
  ack.unchanged = false;
  ack.every_sample = true;
  say(kVision, ack);
  run(2);
  EXPECT_EQ(stats().drawn, 0U);
  ack.every_sample = false;
  say(kVision, ack);
  run(2);
  EXPECT_EQ(stats().drawn, 1U);
  EXPECT_EQ(stats().frame_rate_hz, 30.0);
}

// They get the probe as a vision node draws it: at the newest sample that has a force.
TEST_F(NetworkLoops, VrpnClientsGetTheProbeOfTheNewestForce) {
  vrpn::Feed feed;
  make();
  network->set_vrpn_feed(&feed);
  join(kHaptics, NodeRole::haptics);
  run(20);
  vrpn::FeedProxy proxy;
  EXPECT_FALSE(feed.take_proxy(proxy)) << "no client is there";
  feed.set_wanted(true);
  run(2);
  ASSERT_TRUE(feed.take_proxy(proxy));
  EXPECT_EQ(proxy.p_WP, Vec3(device.place + force_reply.visual_offset_m));
  EXPECT_TRUE(proxy.is_contact);
  force_reply.visual_turn = Vec3(0, 0, 0.5);
  run(3);
  ASSERT_TRUE(feed.take_proxy(proxy));
  EXPECT_LT(proxy.q_WP.angularDistance(Quat(Eigen::AngleAxisd(0.5, Vec3::UnitZ()))), 1e-9);
  network->set_vrpn_feed(nullptr);
}

}  // namespace
}  // namespace hapton
