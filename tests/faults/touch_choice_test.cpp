// The round trip changes, and with it where the force is computed: in the haptics node, or from patches beside the device. A hand rests 2
// mm deep, so its force must not change with it. Times are simulated; only the threads that send and build patches run in real time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "tests/faults/simulated_system.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

constexpr double kTopM = 0.05;
constexpr double kDepthM = 0.002;
constexpr double kStiffness = 1000.0;
constexpr double kForceN = kStiffness * kDepthM;
// Patches round vertices to a grid: the force may differ by this much.
constexpr double kRoundingN = 1e-4;

Scene box_up_to(double top_m) {
  Scene scene;
  scene.objects.emplace_back();
  scene.objects[0].name = "box";
  scene.objects[0].mesh = made::shared(made::box(Vec3::Constant(-0.05), Vec3(0.05, 0.05, top_m)));
  return scene;
}

LinkFaults one_way(double round_trip_ms) { return {.delay_ns = static_cast<std::int64_t>(0.5e6 * round_trip_ms)}; }

void press_in_near(SimulatedSystem& system) {
  system.scene = box_up_to(kTopM);
  system.start_haptics();
  system.run_for_ns(500 * kMs);
  ASSERT_NEAR(system.force_n().z(), kForceN, kRoundingN);
}

// Of the forces on the motors.
struct ForceRange {
  double least_n = 1e9;
  double largest_n = -1e9;
  double largest_step_n = 0.0;
};
ForceRange force_range_since(const PressingDevice& device, std::size_t first) {
  ForceRange range;
  for (std::size_t n = first; n < device.written.size(); ++n) {
    const Vec3& force_n = device.written[n].force_n;
    range.least_n = std::min(range.least_n, force_n.z());
    range.largest_n = std::max(range.largest_n, force_n.norm());
    if (n > first) range.largest_step_n = std::max(range.largest_step_n, (force_n - device.written[n - 1].force_n).norm());
  }
  return range;
}

// Round trips are long and short, single datagrams and bursts are lost, jitter crosses both limits. Three vision nodes are connected.
TEST(TouchChoice, TheForceOfAHandAtRestNeverChanges) {
  for (const double rate_hz : {1000.0, 10'000.0}) {
    SCOPED_TRACE(rate_hz);
    SimulatedSystem system(11, TouchChoice::automatic, rate_hz);
    ASSERT_NO_FATAL_FAILURE(press_in_near(system));
    std::vector<std::unique_ptr<SimulatedVision>> visions;
    for (int n = 0; n < 3; ++n) visions.push_back(system.make_vision(1));
    const std::size_t first = system.device.written.size();
    const auto run = [&](const LinkFaults& faults, double seconds) {
      system.set_faults(faults, faults);
      system.run_for_ns(static_cast<std::int64_t>(1e9 * seconds));
    };
    LinkFaults jittering = one_way(4.0);
    jittering.jitter_ns = 4 * kMs;
    jittering.loss = 0.1;
    LinkFaults bursts = one_way(9.0);
    bursts.burst_share = 0.05;
    bursts.burst_length = 2.0;
    for (int round = 0; round < (rate_hz > 5000.0 ? 1 : 2); ++round) {
      SCOPED_TRACE(round);
      run(jittering, 2.0);
      run(one_way(0.2), 0.7);
      run(one_way(9.0), 2.0);
      ASSERT_TRUE(system.wait_for_patches());
      run(bursts, 3.0);  // only now: a burst of 11 ms may occur, which would end a remote force
      run(one_way(300.0), 2.0);
      run(jittering, 2.0);
      run(one_way(0.2), 2.5);
      run(one_way(12.0), 0.3);
      run(one_way(0.2), 7.0);
      EXPECT_FALSE(system.wants_patches());
      const std::uint64_t local = system.stats().local_forces;
      run(one_way(0.2), 0.2);
      EXPECT_EQ(system.stats().local_forces, local);
    }
    const ForceRange range = force_range_since(system.device, first);
    EXPECT_GT(range.least_n, kForceN - kRoundingN);
    EXPECT_LT(range.largest_n, kForceN + kRoundingN);
    EXPECT_EQ(system.stats().governor.counters.command_timeouts, 0U);
  }
}

// With patches the haptics node gets few samples: for long, most of the measured round trips are from before the change.
TEST(TouchChoice, ANetworkThatHasBecomeFastIsChosenForOnce) {
  SimulatedSystem system(13, TouchChoice::automatic);
  ASSERT_NO_FATAL_FAILURE(press_in_near(system));
  system.set_faults(one_way(12.0), one_way(12.0));
  system.run_for_ns(10'000 * kMs);
  ASSERT_TRUE(system.wait_for_patches());
  LinkFaults near = one_way(0.2);
  near.loss = 0.1;
  system.set_faults(near, near);
  const std::size_t first = system.device.written.size();
  int changes = 0;
  for (int n = 0; n < 800; ++n) {
    const bool wanted_patches = system.wants_patches();
    system.run_for_ns(10 * kMs);
    changes += system.wants_patches() != wanted_patches ? 1 : 0;
  }
  EXPECT_EQ(changes, 1);
  EXPECT_FALSE(system.wants_patches());
  EXPECT_GT(force_range_since(system.device, first).least_n, kForceN - kRoundingN);
}

// Another haptics node with the same scene is started: first one with a long round trip, then one with a short one.
TEST(TouchChoice, AHapticsNodeThatIsStartedAgainIsChosenForByItsOwnRoundTrip) {
  SimulatedSystem system(12, TouchChoice::automatic);
  ASSERT_NO_FATAL_FAILURE(press_in_near(system));
  system.set_faults(one_way(12.0), one_way(12.0));
  system.run_for_ns(2500 * kMs);
  ASSERT_TRUE(system.wait_for_patches());
  for (const double round_trip_ms : {12.0, 0.2}) {
    SCOPED_TRACE(round_trip_ms);
    system.kill_haptics();
    system.run_for_ns(2500 * kMs);
    EXPECT_EQ(system.force_n(), Vec3(Vec3::Zero()));
    system.set_faults(one_way(round_trip_ms), one_way(round_trip_ms));
    system.start_haptics();
    system.run_for_ns(1000 * kMs);
    ASSERT_TRUE(system.wait_for_patches());
    EXPECT_NEAR(system.force_n().z(), kForceN, kRoundingN) << "the hand is where it was: still inside";
  }
  system.run_for_ns(6000 * kMs);
  EXPECT_FALSE(system.wants_patches()) << "it is near";
  EXPECT_NEAR(system.force_n().z(), kForceN, kRoundingN);
}

// Each time, the top is half a millimetre lower (if it rose past the probe, the probe would be on its other side). The force falls by 0.5
// N, which fades in over 0.1 s. The hub's force is replaced by that of the haptics node, and then by that of the new patches, so two fades
// may overlap; neither is of more than 0.5 N.
TEST(TouchChoice, ASceneThatIsReadAgainFadesInWhereverTheForceIsComputed) {
  constexpr double kLowerM = 0.0005;
  for (const double round_trip_ms : {0.2, 9.0, 12.0, 17.0}) {
    SCOPED_TRACE(round_trip_ms);
    SimulatedSystem system(13, TouchChoice::automatic);
    ASSERT_NO_FATAL_FAILURE(press_in_near(system));
    system.set_faults(one_way(round_trip_ms), one_way(round_trip_ms));
    system.run_for_ns(2500 * kMs);
    const bool is_far = round_trip_ms > 8.0;
    ASSERT_EQ(system.wants_patches(), is_far);
    if (is_far) {
      ASSERT_TRUE(system.wait_for_patches());
    }
    const std::size_t first = system.device.written.size();
    for (const double top_m : {kTopM - kLowerM, kTopM - 2.0 * kLowerM}) {
      system.haptics->set_scene(box_up_to(top_m));
      const double force_n = kForceN + kStiffness * (top_m - kTopM);
      for (int n = 0; n < 3000 && std::abs(system.force_n().z() - force_n) > kRoundingN; ++n) {
        system.run_for_ns(5 * kMs);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      EXPECT_NEAR(system.force_n().z(), force_n, kRoundingN);
      system.run_for_ns(200 * kMs);
      if (is_far) {
        EXPECT_TRUE(system.wait_for_patches()) << "of the new scene";
      }
      EXPECT_NEAR(system.force_n().z(), force_n, kRoundingN);
    }
    const ForceRange range = force_range_since(system.device, first);
    EXPECT_LT(range.largest_step_n, 2.0 * kStiffness * kLowerM * 1e-3 / ForceFade::kInContactS + kRoundingN);
    EXPECT_GT(range.least_n, kForceN - 2.0 * kStiffness * kLowerM - kRoundingN);
    EXPECT_LT(range.largest_n, kForceN + kRoundingN);
    EXPECT_EQ(system.stats().governor.counters.command_timeouts, 0U);
  }
}

// `hapton set` changes 1,000 to 500 N/m and back: with a remote force, with patches, and while the hub changes from one to the other.
TEST(TouchChoice, AnotherMaterialFadesInWhereverTheForceIsComputed) {
  SimulatedSystem system(14, TouchChoice::automatic);
  ASSERT_NO_FATAL_FAILURE(press_in_near(system));
  const std::size_t first = system.device.written.size();
  bool is_soft = false;
  const auto change = [&] {
    is_soft = !is_soft;
    system.haptics->set_materials({{.stiffness_n_per_m = is_soft ? 0.5 * kStiffness : kStiffness}});
  };
  const auto expect_changed = [&] {
    const double force_n = is_soft ? 0.5 * kForceN : kForceN;
    for (int n = 0; n < 3000 && std::abs(system.force_n().z() - force_n) > kRoundingN; ++n) {
      system.run_for_ns(5 * kMs);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_NEAR(system.force_n().z(), force_n, kRoundingN);
  };
  change();
  expect_changed();
  system.set_faults(one_way(12.0), one_way(12.0));
  for (int n = 0; n < 1000 && !system.wants_patches(); ++n) system.run_for_ns(10 * kMs);
  change();  // the first parts of the scene are being sent
  ASSERT_TRUE(system.wait_for_patches());
  expect_changed();
  change();
  expect_changed();
  system.set_faults(one_way(0.2), one_way(0.2));
  for (int n = 0; n < 1000 && system.wants_patches(); ++n) system.run_for_ns(10 * kMs);
  change();  // the force has just become remote again
  expect_changed();
  system.run_for_ns(1000 * kMs);
  // The parts that the hub received earlier have another stiffness.
  change();
  expect_changed();
  system.set_faults(one_way(12.0), one_way(12.0));
  system.run_for_ns(3000 * kMs);
  ASSERT_TRUE(system.wait_for_patches());
  system.run_for_ns(500 * kMs);
  expect_changed();
  const ForceRange range = force_range_since(system.device, first);
  EXPECT_LT(range.largest_step_n, 2.0 * 0.5 * kForceN * 1e-3 / ForceFade::kInContactS + kRoundingN);
  EXPECT_GT(range.least_n, 0.5 * kForceN - kRoundingN);
  EXPECT_LT(range.largest_n, kForceN + kRoundingN);
  EXPECT_EQ(system.stats().governor.counters.command_timeouts, 0U);
}

}  // namespace
}  // namespace hapton
