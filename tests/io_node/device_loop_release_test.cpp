// A torque is released in the same way as a force; and what the statistics say about a release.
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "io_node/device_loop.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

const Wrench kTurningAlone = {.torque_nm = Vec3(0.1, 0.0, 0.0)};
const Wrench kPressingAlone = {.force_n = Vec3(0.0, 0.0, 2.0)};

// A device whose motors turn the stylus, too. It does not move, and records what is written.
class TurningDevice final : public Device {
 public:
  TurningDevice() {
    limits_ = {8.0, 2000.0, 1000.0, Vec3::Constant(-0.1), Vec3::Constant(0.1), 0.2, 50.0};
    written.reserve(10'000);
  }
  std::string_view name() const noexcept override { return "turning"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceSample read(std::int64_t now_ns) noexcept override { return {now_ns, Vec3(0.01, 0.02, 0.03), Quat::Identity(), buttons, true}; }
  void write(const Wrench& wrench, std::int64_t) noexcept override { written.push_back(wrench); }
  bool cut() noexcept override { return is_cut = true; }
  void restore() noexcept override { is_cut = false; }
  DeviceStatus status() const noexcept override { return DeviceStatus::ready; }
  bool set_hand_target(const std::optional<Vec3>&) noexcept override { return false; }

  std::uint32_t buttons = 0;
  std::vector<Wrench> written;
  bool is_cut = false;

 private:
  DeviceLimits limits_;
};

struct DeviceLoopReleases : testing::Test {
  void make(const DeviceLoop::Options& options = {}) { loop = std::make_unique<DeviceLoop>(device, clock, options); }
  // Runs cycles of a millisecond each; each sample gets this reply.
  void run(int cycles, const std::optional<Wrench>& reply) {
    for (int n = 0; n < cycles; ++n) {
      clock.sleep_until_ns(loop->tick_ns());
      loop->begin_cycle();
      ASSERT_TRUE(loop->run_cycle());
      for (DeviceCycle reported; loop->take_cycle(reported);) newest_cycle = reported;
      clock.advance_ns(100 * kUs);
      if (reply) loop->post({*reply, newest_cycle.sample.time_ns});
    }
  }
  double torque_nm() const { return device.written.back().torque_nm.norm(); }
  double force_n() const { return device.written.back().force_n.norm(); }

  SimulatedClock clock;
  TurningDevice device;
  std::unique_ptr<DeviceLoop> loop;
  DeviceCycle newest_cycle;
};

// Only the torque changes: the force is zero all the time.
TEST_F(DeviceLoopReleases, ATorqueAloneIsReleasedInTime) {
  make();
  run(200, kTurningAlone);
  ASSERT_NEAR(torque_nm(), 0.1, 1e-9);
  ASSERT_EQ(force_n(), 0.0);
  const std::int64_t sample_ns = newest_cycle.sample.time_ns;
  while (torque_nm() > 0.0 && clock.now_ns() - sample_ns < 100 * kMs) run(1, std::nullopt);
  EXPECT_LE(clock.now_ns() - sample_ns, 21 * kMs) << "20 ms and a cycle";
}

TEST_F(DeviceLoopReleases, ATorqueAloneCountsAsMotorsThatAreOn) {
  make();
  run(200, kTurningAlone);
  EXPECT_EQ(loop->force_sample_ns(), newest_cycle.sample.time_ns);
  clock.advance_ns(30 * kMs);
  EXPECT_TRUE(loop->cut_if_older(kCommandTimeoutNs));
  EXPECT_TRUE(device.is_cut);
}

TEST_F(DeviceLoopReleases, TheClutchTakesTheTorqueAwayAndGivesItBack) {
  make({.clutch_button = 1});
  run(200, kTurningAlone);
  ASSERT_NEAR(torque_nm(), 0.1, 1e-9);
  device.buttons = 1;
  run(50, kTurningAlone);
  EXPECT_EQ(torque_nm(), 0.0);
  device.buttons = 0;
  run(200, kTurningAlone);
  EXPECT_NEAR(torque_nm(), 0.1, 1e-9);
}

TEST_F(DeviceLoopReleases, WhereTorqueIsForbiddenTheForceComesAlone) {
  make({.forbids_torque = true});
  run(200, Wrench{.force_n = kPressingAlone.force_n, .torque_nm = kTurningAlone.torque_nm});
  EXPECT_NEAR(force_n(), 2.0, 1e-9);
  EXPECT_EQ(loop->collect_stats().max_torque_nm, 0.0);
}

TEST_F(DeviceLoopReleases, TheLongestOneIsMeasuredFromTheSampleToZeroOnTheMotors) {
  make();
  run(200, kPressingAlone);
  EXPECT_EQ(loop->collect_stats().longest_release_ns, 0);
  run(30, std::nullopt);
  ASSERT_EQ(force_n(), 0.0);
  EXPECT_GT(loop->collect_stats().longest_release_ns, 18 * kMs);
  EXPECT_LE(loop->collect_stats().longest_release_ns, 21 * kMs);
}

TEST_F(DeviceLoopReleases, TheOneAtTheEndOfTheSessionIsIntendedAndNotCounted) {
  make();
  run(200, kPressingAlone);
  loop->end();
  run(30, std::nullopt);
  ASSERT_EQ(force_n(), 0.0);
  EXPECT_EQ(loop->collect_stats().longest_release_ns, 0);
  EXPECT_EQ(loop->collect_stats().governor.counters.command_timeouts, 0U);
}

// Otherwise a watchdog that goes by the age of the force on the motors would not cut it off in time.
TEST_F(DeviceLoopReleases, AForceThatIsRejectedMakesTheOneOnTheMotorsNoYounger) {
  make();
  run(200, kPressingAlone);
  loop->post({kPressingAlone, clock.now_ns() + 50 * kMs});  // replies to a sample that was never taken
  EXPECT_EQ(loop->collect_stats().governor.counters.rejected_future, 1U);
  EXPECT_EQ(loop->force_sample_ns(), newest_cycle.sample.time_ns);
}

}  // namespace
}  // namespace hapton
