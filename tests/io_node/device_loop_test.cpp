#include "io_node/device_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "devices/simulated_phantom.h"
#include "io_node/device_thread.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/patience.h"
#include "tests/support/system_call_guard.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

constexpr std::int64_t kLatestReleaseNs = 21 * kMs;  // kCommandTimeoutNs and one cycle

// A device that does not move and records its calls. within_write is called in the middle of a write.
class StillDevice final : public Device {
 public:
  StillDevice() {
    limits_ = {8.0, 2000.0, 1000.0, Vec3::Constant(-0.1), Vec3::Constant(0.1)};
    written.reserve(100'000);
  }
  std::string_view name() const noexcept override { return "still"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceSample read(std::int64_t now_ns) noexcept override { return {now_ns, place, Quat::Identity(), buttons, true}; }
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept override {
    if (within_write) within_write();
    written.emplace_back(wrench.force_n, now_ns);
  }
  bool cut() noexcept override {
    is_cut = can_be_cut;
    return can_be_cut;
  }
  void restore() noexcept override { is_cut = false; }
  DeviceStatus status() const noexcept override { return DeviceStatus::ready; }
  bool set_hand_target(const std::optional<Vec3>&) noexcept override { return false; }
  bool aim_hand(std::span<const Vec3> p_WA) noexcept override {
    aims.assign(p_WA.begin(), p_WA.end());
    return true;
  }

  double force_n() const { return is_cut || written.empty() ? 0.0 : written.back().first.norm(); }
  Vec3 place = Vec3(0.01, 0.02, 0.03);
  std::uint32_t buttons = 0;
  std::vector<std::pair<Vec3, std::int64_t>> written;
  std::vector<Vec3> aims;
  std::function<void()> within_write;
  bool is_cut = false;
  bool can_be_cut = true;

 private:
  DeviceLimits limits_;
};

struct DeviceLoops : testing::Test {
  // Runs a cycle at its tick; then a force for its sample comes.
  void cycle(const std::optional<Vec3>& force_n) {
    clock.sleep_until_ns(loop.tick_ns());
    loop.begin_cycle();
    ASSERT_TRUE(loop.run_cycle());
    DeviceCycle reported;
    while (loop.take_cycle(reported)) newest_cycle = reported;
    clock.advance_ns(100'000);
    if (force_n) loop.post({{.force_n = *force_n}, newest_cycle.sample.time_ns});
  }
  void press(int cycles = 200) {
    for (int n = 0; n < cycles; ++n) cycle(Vec3(0, 0, 2));
    ASSERT_NEAR(device.force_n(), 2.0, 1e-9);
  }

  SimulatedClock clock;
  StillDevice device;
  HeartbeatPage page;
  DeviceLoop loop{device, clock, {}};
  DeviceCycle newest_cycle;
};

// The dead man's switch may have been released between the request and the cycle that grants it.
TEST_F(DeviceLoops, AResetThatNeedsTheSwitchTakesEffectOnlyWhileItIsHeld) {
  DeviceLoop switch_loop(device, clock, {.dead_mans_switch = 2});
  const auto run = [&](int cycles) {
    for (int n = 0; n < cycles; ++n) {
      clock.sleep_until_ns(switch_loop.tick_ns());
      switch_loop.begin_cycle();
      ASSERT_TRUE(switch_loop.run_cycle());
      for (DeviceCycle reported; switch_loop.take_cycle(reported);) newest_cycle = reported;
    }
  };
  device.buttons = 1U << 1;
  run(100);
  EXPECT_TRUE(switch_loop.latest().is_switch_held);
  const auto latch_fault = [&] {
    device.place.x() = -device.place.x();
    run(20);
    ASSERT_NE(switch_loop.latest().governor.fault, SafetyFault::none);
  };
  device.place.x() = 0.08;
  run(1000);
  (void)switch_loop.latest();
  latch_fault();
  device.buttons = 0;
  switch_loop.reset_faults(ResetPresence::while_held);  // requested while the switch was held in the newest cycle
  EXPECT_TRUE(switch_loop.latest().is_switch_held);
  run(5);
  EXPECT_NE(switch_loop.latest().governor.fault, SafetyFault::none);
  EXPECT_FALSE(switch_loop.latest().is_switch_held);
  EXPECT_EQ(switch_loop.collect_stats().resets_denied, 1U);
  switch_loop.reset_faults(ResetPresence::known);
  run(5);
  EXPECT_EQ(switch_loop.latest().governor.fault, SafetyFault::none) << "who is known to be here needs no switch";
  device.buttons = 1U << 1;
  run(1000);
  latch_fault();
  switch_loop.reset_faults(ResetPresence::while_held);
  run(5);
  EXPECT_EQ(switch_loop.latest().governor.fault, SafetyFault::none);
  EXPECT_EQ(switch_loop.collect_stats().resets_denied, 1U);
}

// The force ramps down first, and ramps up again after the reset.
TEST_F(DeviceLoops, WhileAFaultIsLatchedTheDeviceIsCut) {
  press();
  device.place.x() = -device.place.x();
  for (int n = 0; n < 20 && loop.latest().governor.fault == SafetyFault::none; ++n) {
    ASSERT_FALSE(device.is_cut);
    cycle(Vec3(0, 0, 2));
  }
  ASSERT_NE(loop.latest().governor.fault, SafetyFault::none);
  for (int n = 0; n < 20; ++n) cycle(Vec3(0, 0, 2));
  EXPECT_TRUE(device.is_cut);
  EXPECT_EQ(device.written.back().first.norm(), 0.0) << "ramped to zero before the cut";
  EXPECT_EQ(loop.collect_stats().cuts, 0U) << "nothing was late";
  for (int n = 0; n < 1000; ++n) cycle(Vec3(0, 0, 2));
  EXPECT_TRUE(device.is_cut) << "however much time has passed";
  loop.reset_faults(ResetPresence::known);
  for (int n = 0; n < 3; ++n) cycle(Vec3(0, 0, 2));
  EXPECT_EQ(loop.latest().governor.fault, SafetyFault::none);
  EXPECT_FALSE(device.is_cut);
  EXPECT_LT(device.force_n(), 0.2);
  press();
}

TEST_F(DeviceLoops, AFaultThatWasLatchedBeforeKeepsTheDeviceCut) {
  loop.restore_latched_fault(SafetyFault::jump);
  cycle(std::nullopt);
  EXPECT_TRUE(device.is_cut);
  loop.reset_faults(ResetPresence::known);
  for (int n = 0; n < 3; ++n) cycle(std::nullopt);
  EXPECT_FALSE(device.is_cut);
}

TEST_F(DeviceLoops, APostedForceIsGovernedAndWrittenAtOnce) {
  press();
  const DeviceSide& side = loop.latest();
  EXPECT_EQ(side.command_number, 200U);
  EXPECT_EQ(side.written.force_n, Vec3(0, 0, 2));
  EXPECT_EQ(device.written.back().second, newest_cycle.sample.time_ns + 100'000);
}

// If a write is interrupted in the middle, this errs on the safe side: whoever watches believes that the motors are still on.
TEST_F(DeviceLoops, AForceIsAnnouncedBeforeItIsWrittenAndZeroAfterIt) {
  std::vector<std::int64_t> announced;
  device.within_write = [&] { announced.push_back(loop.force_sample_ns()); };
  press();
  ASSERT_FALSE(announced.empty());
  EXPECT_EQ(announced.back(), newest_cycle.sample.time_ns);
  announced.clear();
  while (device.force_n() > 0.0) cycle(Vec3::Zero());
  ASSERT_FALSE(announced.empty());
  EXPECT_NE(announced.back(), 0) << "while zero was written";
  EXPECT_EQ(loop.force_sample_ns(), 0);
}

// A force comes late in a period. It has used the next cycle's share of the slew limit as well; the cycle after that continues the ramp.
TEST_F(DeviceLoops, ARampMissesNoCycleBetweenForces) {
  press();
  cycle(std::nullopt);
  clock.sleep_until_ns(loop.tick_ns() - 300 * kUs);
  loop.post({{.force_n = Vec3(0, 0, 8)}, newest_cycle.sample.time_ns});
  const double after_post_n = device.force_n();
  ASSERT_LT(after_post_n, 8.0) << "the slew limit ramps it";
  cycle(std::nullopt);
  const double after_cycle_n = device.force_n();
  cycle(std::nullopt);
  EXPECT_GT(device.force_n(), after_cycle_n);
}

TEST_F(DeviceLoops, WithoutNewForcesTheForceReachesZeroInTime) {
  press();
  const std::int64_t sample_ns = newest_cycle.sample.time_ns;
  while (device.force_n() > 0.0 && clock.now_ns() - sample_ns < 100 * kMs) cycle(std::nullopt);
  EXPECT_LE(clock.now_ns() - sample_ns, kLatestReleaseNs);
  EXPECT_LE(loop.collect_stats().longest_release_ns, kLatestReleaseNs);
}

// In an earlier version the old force stayed for one or two cycles: the first cycle after a stall took it for this cycle's force.
TEST_F(DeviceLoops, TheFirstCycleAfterAStallWritesZeroBeforeItDoesAnythingElse) {
  for (const std::int64_t stall_ns : {21 * kMs, 50 * kMs, 1116 * kMs}) {
    press();
    clock.advance_ns(stall_ns);
    const std::int64_t stall_end_ns = clock.now_ns();
    loop.begin_cycle();
    ASSERT_TRUE(loop.run_cycle());
    EXPECT_EQ(device.force_n(), 0.0) << stall_ns;
    EXPECT_EQ(device.written.back().second, stall_end_ns) << stall_ns;
    EXPECT_EQ(loop.force_sample_ns(), 0);
  }
}

TEST_F(DeviceLoops, ALateForceIsNotHeldForLonger) {
  press();
  // Forces come 15 ms after their samples, and then no more forces come.
  std::vector<std::int64_t> samples;
  std::int64_t last_sample_ns = 0;
  for (int n = 0; n < 100; ++n) {
    cycle(std::nullopt);
    samples.push_back(newest_cycle.sample.time_ns);
    if (samples.size() > 15) {
      last_sample_ns = samples[samples.size() - 16];
      loop.post({{.force_n = Vec3(0, 0, 2)}, last_sample_ns});
    }
  }
  ASSERT_GT(device.force_n(), 0.0);
  while (device.force_n() > 0.0 && clock.now_ns() - last_sample_ns < 100 * kMs) cycle(std::nullopt);
  EXPECT_LE(clock.now_ns() - last_sample_ns, kLatestReleaseNs);
}

// The network side is preempted in the middle of a write and does not continue: the device side neither waits nor fails.
TEST_F(DeviceLoops, ANetworkSideStuckInTheMiddleOfAWriteDoesNotKeepTheForce) {
  press();
  const std::int64_t sample_ns = newest_cycle.sample.time_ns;
  int cycles = 0;
  device.within_write = [&] {
    device.within_write = nullptr;
    while (!device.is_cut && cycles < 1000) {
      clock.advance_ns(kMs);
      EXPECT_FALSE(loop.run_cycle()) << "the claim is taken";
      ++cycles;
    }
  };
  loop.post({{.force_n = Vec3(0, 0, 2.5)}, sample_ns + 1});
  EXPECT_TRUE(device.is_cut);
  EXPECT_LE(cycles, 21) << "20 ms and a cycle";
  EXPECT_EQ(device.force_n(), 0.0);
  EXPECT_EQ(loop.collect_stats().cuts, 1U);
  // The network side continues after all: the force does not jump, and ramps up once forces come again.
  for (int n = 0; n < 3; ++n) cycle(std::nullopt);
  EXPECT_FALSE(device.is_cut);
  EXPECT_EQ(device.force_n(), 0.0);
  cycle(Vec3(0, 0, 2));
  EXPECT_LT(device.force_n(), 0.1);
  press();
}

TEST_F(DeviceLoops, ADeviceThatCannotBeCutIsNotCountedAsCut) {
  press();
  clock.advance_ns(30 * kMs);
  device.can_be_cut = false;
  EXPECT_FALSE(loop.cut_if_older(kCommandTimeoutNs));
  EXPECT_EQ(loop.collect_stats().cuts, 0U);
  device.can_be_cut = true;
  loop.cut_if_older(kCommandTimeoutNs);
  EXPECT_TRUE(device.is_cut);
}

TEST_F(DeviceLoops, AForcePostedWhileACycleRunsIsServedAtItsEnd) {
  press();
  std::uint64_t number = 0;
  clock.sleep_until_ns(loop.tick_ns());
  loop.begin_cycle();
  clock.advance_ns(25 * kMs);  // so the cycle begins with a write, which releases the force
  device.within_write = [&] {
    device.within_write = nullptr;
    number = loop.post({{.force_n = Vec3(0, 0, 2)}, clock.now_ns() - 1});
    EXPECT_NE(loop.latest().command_number, number) << "not during the write of the cycle";
  };
  ASSERT_TRUE(loop.run_cycle());
  EXPECT_EQ(loop.latest().command_number, number);
}

TEST_F(DeviceLoops, AfterACutByTheWatchdogProcessTheForceRampsUpFromZero) {
  loop.set_heartbeat_page(&page);
  press();
  EXPECT_GT(page.heartbeat_ns.load(), 0);
  EXPECT_EQ(page.force_sample_ns.load(), newest_cycle.sample.time_ns);
  page.is_cut = 1;
  cycle(Vec3(0, 0, 2));
  EXPECT_EQ(page.is_cut.load(), 1U) << "the last force is still on the motors";
  clock.advance_ns(100 * kMs);
  cycle(std::nullopt);
  EXPECT_EQ(page.force_sample_ns.load(), 0);
  EXPECT_EQ(page.is_cut.load(), 0U);
  cycle(Vec3(0, 0, 2));
  EXPECT_LT(device.force_n(), 0.1);
}

TEST_F(DeviceLoops, ANetworkSideThatIsFarBehindLosesCyclesButNotTheirOrder) {
  for (std::size_t n = 0; n < 2 * DeviceLoop::kMaxQueuedCycles; ++n) {
    clock.sleep_until_ns(loop.tick_ns());
    loop.begin_cycle();
    ASSERT_TRUE(loop.run_cycle());
  }
  DeviceCycle reported;
  std::uint64_t count = 0;
  for (std::uint64_t last = 0; loop.take_cycle(reported); last = reported.number) {
    EXPECT_EQ(reported.number, last + 1);
    ++count;
  }
  EXPECT_EQ(count, DeviceLoop::kMaxQueuedCycles);
  EXPECT_EQ(loop.collect_stats().cycles_unreported, DeviceLoop::kMaxQueuedCycles);
}

// The force fades out, and comes back without a step larger than that of the fade; the reported device point stands still meanwhile.
TEST_F(DeviceLoops, TheClutchTakesTheForceAwayAndMovesTheDevice) {
  DeviceLoop clutched(device, clock, {.clutch_button = 2});
  const auto cycle_with = [&](const Vec3& force_n) {
    clock.sleep_until_ns(clutched.tick_ns());
    clutched.begin_cycle();
    ASSERT_TRUE(clutched.run_cycle());
    for (DeviceCycle reported; clutched.take_cycle(reported);) newest_cycle = reported;
    clock.advance_ns(100'000);
    clutched.post({{.force_n = force_n}, newest_cycle.sample.time_ns});
  };
  const Vec3 place = device.place;
  for (int n = 0; n < 300; ++n) cycle_with({0, 0, 2});
  EXPECT_NEAR(device.force_n(), 2.0, 1e-9);
  device.buttons = 1U << 1;
  double last_force_n = 2.0;
  for (int n = 0; n < 50; ++n) {
    device.place.x() -= 1e-4;
    cycle_with({0, 0, 2});
    EXPECT_EQ(newest_cycle.sample.p_WD, place + Vec3(-1e-4, 0, 0)) << "where it was when the button went down";
    EXPECT_LE(device.force_n(), last_force_n + 1e-12) << n;
    last_force_n = device.force_n();
    if (n >= 11) {  // Clutch::kFadeOutS, 10 ms
      EXPECT_EQ(device.force_n(), 0.0) << n;
    }
  }
  device.buttons = 0;
  for (int n = 0; n < 200; ++n) {
    cycle_with({0, 0, 2});
    EXPECT_EQ(newest_cycle.sample.p_WD, place + Vec3(-1e-4, 0, 0));
    EXPECT_LE(device.force_n(), last_force_n + 2.0 * 1e-3 / Clutch::kFadeInS + 1e-9) << n;
    last_force_n = device.force_n();
  }
  EXPECT_NEAR(device.force_n(), 2.0, 1e-9);
  device.place.x() += 1e-3;
  cycle_with({0, 0, 2});
  EXPECT_LT((newest_cycle.sample.p_WD - place - Vec3(9e-4, 0, 0)).norm(), 1e-12);
}

// A point at which the hand of a simulated device aims is in the frame of the scene. The device gets it in its own frame, without the
// offset of the clutch.
TEST_F(DeviceLoops, TheClutchMovesWhatTheHandAimsAt) {
  DeviceLoop clutched(device, clock, {.clutch_button = 1});
  const auto run = [&](const Vec3& place, std::uint32_t buttons) {
    device.place = place;
    device.buttons = buttons;
    for (int n = 0; n < 20; ++n) {
      clock.sleep_until_ns(clutched.tick_ns());
      clutched.begin_cycle();
      ASSERT_TRUE(clutched.run_cycle());
    }
  };
  run(Vec3::Zero(), 0);
  run(Vec3::Zero(), 1);
  run(Vec3(0.03, 0, 0), 1);
  run(Vec3(0.03, 0, 0), 0);
  const Vec3 aim(0.05, 0.01, 0.0);
  clutched.aim_hand({&aim, 1});
  run(Vec3(0.03, 0, 0), 0);
  ASSERT_EQ(device.aims.size(), 1U);
  EXPECT_LT((device.aims[0] - Vec3(0.08, 0.01, 0.0)).norm(), 1e-12);
}

// A force that was released while no new force came leaves nothing that could fade.
TEST_F(DeviceLoops, AfterAPauseOfTheForceNothingOfTheOldOneFades) {
  class ConstantTouch final : public LocalTouch {
   public:
    std::optional<LocalForce> step(const DeviceSample&) noexcept override { return force; }
    std::optional<LocalForce> force = LocalForce{.force_n = Vec3(0, 0, 3), .contact = true};
  };
  ConstantTouch local;
  loop.set_local_touch(&local);
  for (int n = 0; n < 300; ++n) cycle(std::nullopt);
  ASSERT_NEAR(device.force_n(), 3.0, 1e-6);
  local.force.reset();
  for (int n = 0; n < 100; ++n) cycle(std::nullopt);
  ASSERT_EQ(device.force_n(), 0.0);
  double largest_force_n = 0.0;
  for (int n = 0; n < 300; ++n) {
    cycle(Vec3(0, 0, 1e-3));
    largest_force_n = std::max(largest_force_n, device.force_n());
  }
  EXPECT_NEAR(largest_force_n, 1e-3, 1e-6);
}

TEST_F(DeviceLoops, TheGovernorSeesTheDeviceWhereItIs) {
  DeviceLoop clutched(device, clock, {.clutch_button = 1});  // the workspace that the governor guards is that of the device itself
  const auto run = [&](int cycles, const Vec3& force_n) {
    for (int n = 0; n < cycles; ++n) {
      clock.sleep_until_ns(clutched.tick_ns());
      clutched.begin_cycle();
      ASSERT_TRUE(clutched.run_cycle());
      for (DeviceCycle reported; clutched.take_cycle(reported);) newest_cycle = reported;
      clock.advance_ns(100'000);
      clutched.post({{.force_n = force_n}, newest_cycle.sample.time_ns});
    }
  };
  const auto move_device = [&](double from, double to) {
    for (double x = from; std::abs(x - to) > 1e-9; x += to > from ? 1e-3 : -1e-3) {
      device.place.x() = x;
      run(1, Vec3::Zero());
    }
    device.place.x() = to;
  };
  device.buttons = 1;
  move_device(0.01, -0.07);
  device.buttons = 0;
  move_device(-0.07, 0.05);
  run(300, {2, 0, 0});
  EXPECT_NEAR(newest_cycle.sample.p_WD.x(), 0.13, 1e-9) << "beyond the workspace, 0.1 m";
  EXPECT_NEAR(device.force_n(), 2.0, 1e-9) << "the device is within it";
}

TEST_F(DeviceLoops, UsesNeitherHeapNorSystemCalls) {
  if (AllocationGuard::is_available()) {
    AllocationGuard guard;
    press();
    EXPECT_EQ(guard.count(), 0U);
  }
  if (!SystemCallGuard::is_available()) GTEST_SKIP() << "system calls cannot be forbidden in this build or on this kernel";
  EXPECT_EQ(SystemCallGuard::run([] {}, [&] { press(500); }), "");
}

// Two threads without a network, and the network side stops for good: the force must be released. This is the design's central property.
TEST(DeviceThreads, ReleasesTheForceWhenTheNetworkSideStops) {
  SteadyClock clock;
  SimulatedPhantom device({});
  const auto loop = std::make_unique<DeviceLoop>(device, clock, DeviceLoop::Options{});
  DeviceThread thread(*loop, clock);
  ASSERT_TRUE(thread.start({.mode = RealtimeMode::off}));
  DeviceCycle cycle;
  std::uint64_t posted = 0;
  // A busy machine may be slow; the test fails only if the forces are not posted within 30 s.
  const std::int64_t end_ns = clock.now_ns() + 30'000 * kMs;
  while (posted <= 100 && clock.now_ns() < end_ns) {
    while (loop->take_cycle(cycle)) posted = loop->post({{.force_n = Vec3(0, 0, 1)}, cycle.sample.time_ns});
    clock.sleep_until_ns(clock.now_ns() + kMs / 4);
  }
  EXPECT_GT(posted, 100U);
  EXPECT_TRUE(wait_until([&] { return loop->force_sample_ns() == 0; }));
  thread.stop();
  EXPECT_GE(loop->collect_stats().governor.counters.command_timeouts, 1U);
}

// Both threads run as fast as they can: no force is lost, no thread waits for ever, and ThreadSanitizer can check this.
TEST(DeviceThreads, TwoThreadsNeverWriteToTheDeviceAtTheSameTime) {
  SteadyClock clock;
  StillDevice device;
  std::atomic<int> writers{0};
  std::atomic<int> simultaneous_writes{0};
  device.within_write = [&] {
    if (writers.fetch_add(1) != 0) simultaneous_writes.fetch_add(1);
    writers.fetch_sub(1);
  };
  const auto loop = std::make_unique<DeviceLoop>(device, clock, DeviceLoop::Options{.rate_hz = 10'000.0});
  DeviceThread thread(*loop, clock);
  ASSERT_TRUE(thread.start({.mode = RealtimeMode::off}));
  std::uint64_t number = 0;
  const std::int64_t end_ns = clock.now_ns() + 500 * kMs;
  while (clock.now_ns() < end_ns) number = loop->post({{.force_n = Vec3(0, 0, 1)}, clock.now_ns()});
  thread.stop();
  EXPECT_EQ(loop->latest().command_number, number) << "the last force was not written";
  EXPECT_EQ(simultaneous_writes.load(), 0);
}

}  // namespace
}  // namespace hapton
