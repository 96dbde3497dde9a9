#include "io_node/force_exchange.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

TEST_F(NetworkLoops, ForceBeginsWithARamp) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(52);
  EXPECT_NEAR(device.written.back().force_n.z(), 1.0, 0.1);
}

TEST_F(NetworkLoops, TheWholeSlewOfACycleIsThereForItsForce) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(300);
  force_reply.force_n = Vec3(0, 0, 3.9);  // 1.9 N more in one cycle; the device permits 2 N
  network->step();
  EXPECT_EQ(device.written.back().force_n, force_reply.force_n);
  EXPECT_EQ(stats().governor.counters.rate_limited, 0U);
  force_reply.force_n = Vec3(0, 0, 6.5);
  network->step();
  EXPECT_NEAR(device.written.back().force_n.z(), 5.9, 1e-9);
  EXPECT_EQ(stats().governor.counters.rate_limited, 1U);
}

TEST_F(NetworkLoops, LateForcesAreCountedAndTheNewestWins) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(200);
  reply_delay_ns = 1300 * kUs;
  run(100);
  EXPECT_NEAR(static_cast<double>(stats().responses.late), 100.0, 2.0);
  EXPECT_EQ(stats().round_trip.max_ns(), 1300 * kUs);
  EXPECT_EQ(device.written.back().force_n, force_reply.force_n);
  EXPECT_EQ(stats().responses.lost, 0U);
}

TEST_F(NetworkLoops, AForceThatIsTooOldToBeWrittenHasNoAge) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(200);
  reply_delay_ns = 30'000 * kUs;
  run(200);
  EXPECT_GT(stats().governor.counters.rejected_old, 100U);
  EXPECT_GE(stats().round_trip.max_ns(), 30'000 * kUs);
  EXPECT_LT(stats().force_age.max_ns(), kCommandTimeoutNs);
  EXPECT_GT(stats().force_age.count(), 150U);
}

TEST_F(NetworkLoops, AnOvertakenForceIsNotWritten) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(200);
  reply_delay_ns = -1;
  network->step();
  const DeviceState slow = states.back();
  network->step();
  reply_with_force(states.back(), 0);
  force_reply.force_n = Vec3(7, 0, 0);
  reply_with_force(slow, 100);
  run(3);
  EXPECT_EQ(device.written.back().force_n, Vec3(0, 0, 2));
  EXPECT_EQ(stats().responses.reordered, 1U);
}

// Where the force of the device side ends, the haptics node goes on from the device side's probe. Its replies from before do not know of
// that probe, and the first reply that does may be quite another force.
TEST_F(NetworkLoops, WhereALocalForceEndsOnlyRepliesFromItsProbeOnAreWritten) {
  class Touching final : public LocalTouch {
   public:
    std::optional<LocalForce> step(const DeviceSample&) noexcept override {
      return is_touching ? std::optional<LocalForce>({.force_n = Vec3(0, 0, 1), .visual_offset_m = Vec3(0, 0, 1e-3), .contact = true})
                         : std::nullopt;
    }
    bool is_touching = false;
  };
  Touching local;
  make();
  network->device_loop().set_local_touch(&local);
  join(kHaptics, NodeRole::haptics);
  run(300);
  reply_delay_ns = -1;
  local.is_touching = true;
  run(200);
  ASSERT_NEAR(device.written.back().force_n.z(), 1.0, 1e-9);
  const DeviceState sample_before = states.back();
  EXPECT_FALSE(sample_before.is_resumed);
  local.is_touching = false;
  network->step();
  const DeviceState resumed = states.back();
  EXPECT_TRUE(resumed.is_resumed) << "with the first sample that has no local force";
  force_reply.force_n = Vec3(0, 0, 3);
  reply_with_force(sample_before, 0);
  run(3);
  EXPECT_NEAR(device.written.back().force_n.z(), 1.0, 1e-9);
  reply_with_force(resumed, 0);
  run(1);
  EXPECT_NEAR(device.written.back().force_n.z(), 1.02, 1e-9) << "a hundredth of the difference, although four cycles passed";
}

// The haptics node got only 20 samples a second, so its own probe may still be where the hand was before it went around an edge.
TEST_F(NetworkLoops, WhereALocalForceEndsTheHapticsNodeLearnsThatTheHandIsFree) {
  struct Free final : LocalTouch {
    std::optional<LocalForce> step(const DeviceSample&) noexcept override {
      return is_local ? std::optional<LocalForce>(LocalForce()) : std::nullopt;
    }
    bool is_local = true;
  };
  Free local;
  make();
  network->device_loop().set_local_touch(&local);
  join(kHaptics, NodeRole::haptics);
  run(200);
  reply_delay_ns = -1;
  local.is_local = false;
  network->step();
  EXPECT_TRUE(states.back().is_resumed);
  EXPECT_LT((states.back().p_WP - states.back().p_WD).norm(), 1e-3);
}

TEST_F(NetworkLoops, ACommandTimeoutReleasesTheForceWhichRampsBackIn) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(300);
  reply_delay_ns = -1;
  run(19);
  EXPECT_NE(device.written.back().force_n, Vec3::Zero());
  run(3);
  EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
  EXPECT_EQ(stats().governor.counters.command_timeouts, 1U);
  reply_delay_ns = 50 * kUs;
  run(10);
  EXPECT_LT(device.written.back().force_n.z(), 0.3);
  run(120);
  EXPECT_EQ(device.written.back().force_n, force_reply.force_n);
  EXPECT_EQ(stats().responses.lost, 0U);  // none counts as lost before kReplyTimeoutNs is over
  run(250);
  EXPECT_NEAR(static_cast<double>(stats().responses.lost), 22.0, 1.0);
}

TEST_F(NetworkLoops, ASlowHapticsNodeThatSkipsSamplesSupersedesThem) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(200);
  reply_delay_ns = -1;
  run(4);
  reply_delay_ns = 100 * kUs;
  force_reply.skipped_samples = 4;
  network->step();
  force_reply.skipped_samples = 0;
  run(400);
  EXPECT_EQ(stats().responses.superseded, 4U);
  EXPECT_EQ(stats().responses.lost, 0U);
}

// Twice the network side sends only the newest of three cycles. The haptics node replies to the last sample, and skips the two sent before.
TEST_F(NetworkLoops, SamplesThatALateNetworkSideNeverSentAreNotLost) {
  make();
  join(kHaptics, NodeRole::haptics);
  network->use_device_thread();
  const auto run_device_cycles = [&](int count) {
    for (int n = 0; n < count; ++n) {
      clock.sleep_until_ns(network->device_loop().tick_ns());
      network->device_loop().begin_cycle();
      ASSERT_TRUE(network->device_loop().run_cycle());
    }
    network->step();
  };
  for (int n = 0; n < 200; ++n) {
    if (n % 100 == 50) say(kHaptics, Hello{NodeRole::haptics});
    run_device_cycles(1);
  }
  reply_delay_ns = -1;
  run_device_cycles(1);
  run_device_cycles(3);
  reply_delay_ns = 100 * kUs;
  force_reply.skipped_samples = 2;
  run_device_cycles(3);
  force_reply.skipped_samples = 0;
  for (int n = 0; n < 400; ++n) {
    if (n % 100 == 50) say(kHaptics, Hello{NodeRole::haptics});
    run_device_cycles(1);
  }
  EXPECT_EQ(stats().responses.superseded, 2U);
  EXPECT_EQ(stats().responses.lost, 0U);
}

TEST_F(NetworkLoops, HostileForcesNeverReachTheMotorsAsTheyAre) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(200);
  for (const double bad : {1e8, -1e8, 1e9, 8.1}) {
    force_reply.force_n = Vec3(bad, bad, -bad);
    run(20);
  }
  Vec3 last = Vec3::Zero();
  std::int64_t last_ns = 0;
  // The limits of BenchDevice: 8 N, and 2000 N/s.
  for (const auto& written : device.written) {
    ASSERT_TRUE(written.force_n.allFinite());
    ASSERT_LE(written.force_n.norm(), 8.0);
    const double allowed_change_n = last_ns > 0 ? 2000.0e-9 * static_cast<double>(written.time_ns - last_ns) : 8.0;
    ASSERT_LE((written.force_n - last).norm(), allowed_change_n + 1e-9);
    last = written.force_n;
    last_ns = written.time_ns;
  }
  EXPECT_GT(stats().governor.counters.clamped, 60U);
  EXPECT_GT(stats().governor.counters.rate_limited, 0U);
}

TEST_F(NetworkLoops, DuplicatesAndForgedEchoesAreIgnored) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(200);
  const std::size_t writes_before = device.written.size();
  ForceCommand forged = force_reply;
  forged.force_n = Vec3(8, 0, 0);
  forged.echo_sample = states.back().sample;
  forged.echo_sample_time_ns = states.back().sample_time_ns;
  say(kHaptics, forged);
  forged.echo_sample += 100;
  say(kHaptics, forged);
  forged.echo_sample_time_ns = kMaxWireTimeNs;
  say(kHaptics, forged);
  reply_delay_ns = -1;
  network->step();
  EXPECT_EQ(device.written.size(), writes_before);
  EXPECT_EQ(stats().responses.duplicate, 1U);
  EXPECT_EQ(stats().responses.unknown, 2U);
}

}  // namespace
}  // namespace hapton
