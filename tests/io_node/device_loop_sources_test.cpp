// In the device loop: the source of a force, the time of its sample, and a network side that still has its claim on the device.
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/force/force_fade.h"
#include "io_node/device_loop.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

// A device that does not move. A read takes read_takes_ns; within_write is called once, in the middle of the next write.
class TimedDevice final : public Device {
 public:
  explicit TimedDevice(SimulatedClock& clock) : clock_(clock) {
    limits_ = {8.0, 2000.0, 1000.0, Vec3::Constant(-0.1), Vec3::Constant(0.1)};
    written_n.reserve(10'000);
  }
  std::string_view name() const noexcept override { return "timed"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceSample read(std::int64_t now_ns) noexcept override {
    clock_.advance_ns(read_takes_ns);
    return {now_ns, Vec3(0.01, 0.02, 0.03), Quat::Identity(), 0, true};
  }
  void write(const Wrench& wrench, std::int64_t) noexcept override {
    if (const auto once = std::exchange(within_write, nullptr)) once();
    written_n.push_back(wrench.force_n);
  }
  bool cut() noexcept override { return is_cut = true; }
  void restore() noexcept override { is_cut = false; }
  DeviceStatus status() const noexcept override { return DeviceStatus::ready; }
  bool set_hand_target(const std::optional<Vec3>&) noexcept override { return false; }

  std::int64_t read_takes_ns = 0;
  std::function<void()> within_write;
  std::vector<Vec3> written_n;
  bool is_cut = false;

 private:
  SimulatedClock& clock_;
  DeviceLimits limits_;
};

// The force of the device side, which the test sets.
struct SettableTouch final : LocalTouch {
  std::optional<LocalForce> step(const DeviceSample&) noexcept override { return force; }
  std::optional<LocalForce> force;
};

struct DeviceLoopSources : testing::Test {
  void make() { loop = std::make_unique<DeviceLoop>(device, clock, DeviceLoop::Options{}); }
  void run(int cycles, const std::optional<Vec3>& reply_n = std::nullopt) {
    for (int n = 0; n < cycles; ++n) {
      clock.sleep_until_ns(loop->tick_ns());
      loop->begin_cycle();
      ASSERT_TRUE(loop->run_cycle());
      for (DeviceCycle reported; loop->take_cycle(reported);) newest_cycle = reported;
      clock.advance_ns(100 * kUs);
      if (reply_n) loop->post({{.force_n = *reply_n}, newest_cycle.sample.time_ns});
    }
  }
  // Presses until a patch gives 2 N.
  void press_by_patch() {
    make();
    loop->set_local_touch(&local);
    local.force = LocalForce{.force_n = Vec3(0, 0, 2), .contact = true};
    run(300);
    ASSERT_NEAR(force_n(), 2.0, 1e-9);
  }
  double force_n() const { return device.written_n.back().norm(); }

  SimulatedClock clock;
  TimedDevice device{clock};
  SettableTouch local;
  std::unique_ptr<DeviceLoop> loop;
  DeviceCycle newest_cycle;
  static constexpr double kFadePerCycle = 1e-3 / ForceFade::kInContactS;  // share of a difference that fades in a cycle
};

// The governor alone would let the force rise by up to 2 N in one cycle.
TEST_F(DeviceLoopSources, WhereAnotherPatchTakesOverTheDifferenceFades) {
  ASSERT_NO_FATAL_FAILURE(press_by_patch());
  local.force->force_n.z() = 3.0;
  local.force->is_handed_over = true;
  run(1);
  EXPECT_NEAR(force_n(), 2.0 + kFadePerCycle, 1e-6);
  local.force->is_handed_over = false;
  run(49);
  EXPECT_NEAR(force_n(), 2.5, 1e-6);
  run(60);
  EXPECT_NEAR(force_n(), 3.0, 1e-9);
}

// As before, but the forces of both patches are known for one sample: only the difference between these two fades.
TEST_F(DeviceLoopSources, AKnownDifferenceOfTwoPatchesFades) {
  ASSERT_NO_FATAL_FAILURE(press_by_patch());
  local.force->force_n.z() = 3.0;
  local.force->difference_n = Vec3(0, 0, -1);
  run(1);
  EXPECT_NEAR(force_n(), 2.0 + kFadePerCycle, 1e-6);
  local.force->difference_n.setZero();
  run(110);
  EXPECT_NEAR(force_n(), 3.0, 1e-9);
}

// The time that reading takes does not count in the age of the force.
TEST_F(DeviceLoopSources, ASampleIsOfTheTimeAtWhichTheDeviceReturnedIt) {
  make();
  device.read_takes_ns = 300 * kUs;
  run(10);
  EXPECT_EQ(newest_cycle.sample.time_ns, newest_cycle.tick_ns + 300 * kUs);
  EXPECT_EQ(loop->collect_stats().device_read.max_ns(), 300 * kUs);
}

// The device thread sleeps until the tick that it knew before the cycle. Earlier ticks, of a higher rate, would all count as missed, and
// end a session with --overrun stop.
TEST_F(DeviceLoopSources, AHigherRateBeginsAtTheNextTickAndMissesNone) {
  loop = std::make_unique<DeviceLoop>(device, clock, DeviceLoop::Options{.rate_hz = 250.0, .overrun = OverrunPolicy::stop});
  run(2);
  clock.sleep_until_ns(loop->tick_ns());
  loop->begin_cycle();
  const std::int64_t wake_ns = loop->wake_after_next_ns();
  loop->set_rate_hz(10'000.0);
  clock.advance_ns(3 * kMs);  // late, but by less than a period at 250 Hz
  ASSERT_TRUE(loop->run_cycle());
  EXPECT_EQ(loop->tick_ns(), wake_ns);
  EXPECT_EQ(loop->collect_stats().rate_hz, 10'000.0);
  for (int n = 1; n <= 2; ++n) {
    clock.sleep_until_ns(loop->tick_ns());
    loop->begin_cycle();
    ASSERT_TRUE(loop->run_cycle());
    EXPECT_EQ(loop->tick_ns(), wake_ns + n * kMs / 10);
  }
  EXPECT_EQ(loop->collect_stats().missed_cycles, 0U);
  EXPECT_FALSE(loop->has_overrun());
}

// The session ends while the network side is preempted in the middle of a write, and does not continue.
TEST_F(DeviceLoopSources, AtTheEndANetworkSideThatIsStuckDoesNotKeepTheForceEither) {
  for (const bool finishes : {false, true}) {
    make();
    device.is_cut = false;
    run(200, Vec3(0, 0, 2));
    ASSERT_NEAR(force_n(), 2.0, 1e-9);
    device.within_write = [&] {
      clock.advance_ns(kCommandTimeoutNs);
      EXPECT_FALSE(finishes ? loop->finish() : loop->hold()) << "the claim is taken";
    };
    loop->post({{.force_n = Vec3(0, 0, 2.5)}, newest_cycle.sample.time_ns + 1});
    EXPECT_TRUE(device.is_cut) << finishes;
  }
}

}  // namespace
}  // namespace hapton
