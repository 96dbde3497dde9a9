#include "io_node/local_patch.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "core/force/force_method.h"
#include "io_node/device_loop.h"
#include "tests/io_node/network_loop_fixture.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

std::unique_ptr<Patch> sheet_patch(double height_m, double radius_m = 1.0, const Material& material = {}) {
  TouchScene scene;
  scene.objects.push_back({made::shared(made::sheet(0.05, height_m, 20)), material});
  auto patch = std::make_unique<Patch>();
  patch->step = std::make_unique<TouchStep>(*make_method({}, scene));
  patch->radius_m = radius_m;
  patch->lift_m = 1e-7;
  return patch;
}

DeviceSample sample_at(const Vec3& p_WD, std::int64_t time_ns) { return {time_ns, p_WD, Quat::Identity(), 0, true}; }

PatchOrders orders_until(std::int64_t until_ns) {
  PatchOrders orders;
  orders.is_wanted = true;
  orders.until_ns = until_ns;
  return orders;
}

TEST(LocalPatch, FeelsNothingBeforeItIsWantedOrHasAPatch) {
  LocalPatch local;
  EXPECT_FALSE(local.step(sample_at(Vec3::Zero(), 1 * kMs)));
  local.offer(sheet_patch(0.0));
  EXPECT_FALSE(local.step(sample_at(Vec3::Zero(), 2 * kMs)));
  local.publish(orders_until(100 * kMs));
  EXPECT_TRUE(local.step(sample_at(Vec3(0, 0, 0.01), 3 * kMs)));
}

TEST(LocalPatch, GivesTheForceOfThePatch) {
  LocalPatch local;
  local.offer(sheet_patch(0.0));
  local.publish(orders_until(1000 * kMs));
  for (int n = 1; n <= 10; ++n) {
    const auto felt = local.step(sample_at(Vec3(0.001, 0.002, 0.001 - 3e-4 * n), n * kMs));
    ASSERT_TRUE(felt);
    if (n > 4) {
      EXPECT_NEAR(felt->force_n.z(), 1000.0 * (3e-4 * n - 0.001), 1e-6);
      EXPECT_NEAR(felt->visual_offset_m.z(), 3e-4 * n - 0.001, 1e-9);
    }
  }
}

// The velocity is that over the time between two samples. A gap of a second counts as 20 ms only, so that the device is not taken for slow.
TEST(LocalPatch, DampingUsesTheTimeBetweenTheSamples) {
  constexpr double kDamping = 4.0;
  LocalPatch local;
  local.offer(sheet_patch(0.0, 1.0, {.stiffness_n_per_m = 500.0, .damping_ns_per_m = kDamping}));
  local.publish(orders_until(9000 * kMs));
  for (int n = 1; n <= 10; ++n) (void)local.step(sample_at(Vec3(0.001, 0.002, 0.001 - 3e-4 * n), n * kMs));
  const auto force_z_n = [&](double z, std::int64_t ms) { return local.step(sample_at(Vec3(0.001, 0.002, z), ms * kMs))->force_n.z(); };
  EXPECT_NEAR(force_z_n(-0.0022, 11), 500.0 * 0.0022 + kDamping * 2e-4 / 0.001, 1e-6);
  EXPECT_NEAR(force_z_n(-0.0024, 16), 500.0 * 0.0024 + kDamping * 2e-4 / 0.005, 1e-6);
  EXPECT_NEAR(force_z_n(-0.0034, 1016), 500.0 * 0.0034 + kDamping * 1e-3 / 0.020, 1e-6);
}

// The safety case: without haptics, patches alone give the force until PatchOrders::until_ns and no longer.
TEST(LocalPatch, EndsWhenHapticsIsSilentForTooLong) {
  LocalPatch local;
  local.offer(sheet_patch(0.0));
  local.publish(orders_until(50 * kMs));
  EXPECT_TRUE(local.step(sample_at(Vec3(0, 0, 0.01), 49 * kMs)));
  EXPECT_FALSE(local.step(sample_at(Vec3(0, 0, 0.01), 50 * kMs)));
  EXPECT_FALSE(local.step(sample_at(Vec3(0, 0, 0.01), 5000 * kMs)));
}

// A hand that goes through the surface while haptics is silent is on the same side of it when haptics sends again.
TEST(LocalPatch, TheSurfaceIsTheSameAfterATimeout) {
  LocalPatch local;
  local.offer(sheet_patch(0.0));
  local.publish(orders_until(50 * kMs));
  EXPECT_TRUE(local.step(sample_at(Vec3(0, 0, 0.001), 49 * kMs)));
  EXPECT_FALSE(local.step(sample_at(Vec3(0, 0, -0.001), 60 * kMs)));
  local.publish(orders_until(200 * kMs));
  const auto felt = local.step(sample_at(Vec3(0, 0, -0.002), 100 * kMs));
  ASSERT_TRUE(felt);
  EXPECT_NEAR(felt->force_n.z(), 2.0, 1e-6);
}

TEST(LocalPatch, APatchOfAnotherSceneIsNotFelt) {
  LocalPatch local;
  local.offer(sheet_patch(0.0));
  local.publish(orders_until(1000 * kMs));
  EXPECT_TRUE(local.step(sample_at(Vec3(0, 0, 0.01), 1 * kMs)));
  local.set_generation(1);
  EXPECT_FALSE(local.step(sample_at(Vec3(0, 0, 0.01), 2 * kMs)));
  auto patch = sheet_patch(0.0);
  patch->generation = 1;
  local.offer(std::move(patch));
  EXPECT_TRUE(local.step(sample_at(Vec3(0, 0, 0.01), 3 * kMs)));
}

TEST(LocalPatch, TheDevicesThreadAllocatesAndFreesNothing) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  LocalPatch local;
  local.publish(orders_until(100'000 * kMs));
  std::uint64_t allocations = 0;
  for (int n = 1; n < 2000; ++n) {
    if (n % 100 == 1) local.offer(sheet_patch(0.0, n % 300 == 1 ? 0.02 : 1.0));
    local.free_retired();
    PatchHandState hand;
    AllocationGuard guard;
    (void)local.step(sample_at(Vec3(0.04 * std::sin(0.01 * n), 0.0, -0.002), n * kMs));
    (void)local.read_hand_state(hand);
    allocations += guard.count();
  }
  EXPECT_EQ(allocations, 0U);
  EXPECT_GT(local.counts().handed_over, 5U);
}

// A floor that programs move, by 100 mm/s from 1 s of scene time on.
struct MovedFloor {
  LocalPatch local;
  PatchOrders orders = orders_until(1'000'000 * kMs);
  MoveTable moves;

  MovedFloor() {
    auto bodies = std::make_unique<PatchBodies>();
    bodies->bodies.resize(2);
    bodies->bodies[1] = {.is_commanded = true, .object = 0, .radius_m = 0.1};
    local.offer(std::move(bodies));
    auto empty_patch = std::make_unique<Patch>();
    empty_patch->radius_m = 1e9;
    empty_patch->lift_m = 1e-7;
    local.offer(std::move(empty_patch), 0);
    auto floor = sheet_patch(0.0);
    floor->objects = {0};
    local.offer(std::move(floor), 1);
    orders.remote_force_ns = 5000 * kMs;
    orders.remote_force_scene_ns = 700 * kMs;
    local.publish(orders);
    (void)moves.take({.source = 1, .serial = 1, .object = 0, .start_ns = 1000 * kMs, .end_ns = 2000 * kMs, .to_p_m = Vec3(0, 0, 0.1)});
    local.publish(moves);
  }
};

// Scene time advances with each sample from that of the newest remote force, so that every program has the floor at the same place.
TEST(LocalPatch, FeelsWhatMovesWhereItIsAtTheSceneTimeOfTheSample) {
  MovedFloor floor;
  for (int n = 1; n < 600; ++n) {
    const auto felt = floor.local.step(sample_at(Vec3(0.001, 0.002, 0.01), (5000 + n) * kMs));
    ASSERT_TRUE(felt) << n;
    EXPECT_EQ(felt->scene_time_ns, (700 + n) * kMs);
    const double top_m = std::max(0.0, 1e-4 * (n - 300));
    EXPECT_NEAR(felt->force_n.z(), 1000.0 * std::max(0.0, top_m - 0.01), 1e-6) << n;
    EXPECT_EQ(felt->object, felt->contact ? 0 : -1);
  }
}

// As in the haptics node, a gap counts as 50 ms of scene time, and nothing moves while there is no force.
TEST(LocalPatch, SceneTimeStandsStillInAGapAndWithoutHaptics) {
  MovedFloor floor;
  const auto step_at = [&](std::int64_t ms) { return floor.local.step(sample_at(Vec3(0, 0, 0.2), ms * kMs)); };
  EXPECT_EQ(step_at(5000)->scene_time_ns, 700 * kMs);
  EXPECT_EQ(step_at(5001)->scene_time_ns, 701 * kMs);
  EXPECT_EQ(step_at(6001)->scene_time_ns, 751 * kMs);
  floor.orders.until_ns = 6000 * kMs;
  floor.local.publish(floor.orders);
  EXPECT_FALSE(step_at(6010));
  EXPECT_FALSE(step_at(6020));
  floor.orders.until_ns = 9000 * kMs;
  floor.local.publish(floor.orders);
  EXPECT_EQ(step_at(6021)->scene_time_ns, 752 * kMs);
}

// The device loop with a patch: it writes its own force in every cycle, however old the forces from the network are.
struct LoopWithPatch : testing::Test {
  SimulatedClock clock{1'000'000'000};
  BenchDevice device;
  LocalPatch local;
  std::unique_ptr<DeviceLoop> loop;

  void SetUp() override {
    device.clock = &clock;
    device.place = Vec3(0.001, 0.002, 0.001);
    loop = std::make_unique<DeviceLoop>(device, clock, DeviceLoop::Options{});
    loop->set_local_touch(&local);
  }
  DeviceCycle cycle() {
    clock.advance_ns(1 * kMs);
    loop->begin_cycle();
    loop->run_cycle();
    DeviceCycle last;
    while (loop->take_cycle(last)) {
    }
    return last;
  }
};

TEST_F(LoopWithPatch, WritesTheForceOfEverySample) {
  local.offer(sheet_patch(0.0));
  local.publish(orders_until(clock.now_ns() + 10'000 * kMs));
  for (int n = 0; n < 300; ++n) {
    device.place.z() = std::max(device.place.z() - 2e-5, -0.003);
    const DeviceCycle last = cycle();
    ASSERT_TRUE(last.local);
  }
  EXPECT_NEAR(device.written.back().force_n.z(), 3.0, 1e-6);
  EXPECT_EQ(loop->collect_stats().governor.counters.command_timeouts, 0U);
}

TEST_F(LoopWithPatch, ReleasesTheForceWhenHapticsIsSilent) {
  local.offer(sheet_patch(0.0));
  local.publish(orders_until(clock.now_ns() + 400 * kMs));
  for (int n = 0; n < 380; ++n) {
    device.place.z() = std::max(device.place.z() - 2e-5, -0.003);
    cycle();
  }
  EXPECT_GT(device.written.back().force_n.z(), 2.9);
  for (int n = 0; n < 50; ++n) cycle();
  EXPECT_EQ(device.written.back().force_n, Vec3(Vec3::Zero()));
}

TEST_F(LoopWithPatch, AForceFromTheNetworkIsNotUsedMeanwhile) {
  local.offer(sheet_patch(0.0));
  local.publish(orders_until(clock.now_ns() + 10'000 * kMs));
  for (int n = 0; n < 300; ++n) {
    device.place.z() = std::max(device.place.z() - 2e-5, -0.003);
    const DeviceCycle last = cycle();
    loop->post({{.force_n = Vec3(5, 0, 0)}, last.sample.time_ns});
  }
  EXPECT_EQ(device.written.back().force_n.x(), 0.0);
  EXPECT_EQ(loop->collect_stats().commands_unused, 300U);
}

// Patches are wanted. For a second none reaches the hand, then one does, and later they start again: the network's force fills each gap.
TEST_F(LoopWithPatch, TheForceOfTheNetworkGoesOnUntilAPatchReachesTheHand) {
  PatchOrders orders = orders_until(clock.now_ns() + 100'000 * kMs);
  local.publish(orders);
  double least_n = 1e9;
  double largest_change_n = 0.0;
  Vec3 last_written_n = Vec3::Zero();
  for (int n = 0; n < 3000; ++n) {
    device.place.z() = std::max(device.place.z() - 2e-5, -0.003);
    if (n == 500) local.offer(sheet_patch(0.0, 0.0005));
    if (n % 200 == 199) {
      ++orders.start_serial;
      orders.start_ns = clock.now_ns();
      orders.p_WP = Vec3(device.place.x(), device.place.y(), std::max(device.place.z(), 0.0));
      orders.outward_W = device.place.z() < 0.0 ? Vec3(Vec3::UnitZ()) : Vec3(Vec3::Zero());
      local.publish(orders);
    }
    if (n == 1200) local.offer(sheet_patch(0.0));
    if (n == 2000) local.set_generation(1);
    local.free_retired();
    const DeviceCycle now = cycle();
    EXPECT_EQ(now.local.has_value(), n >= 1200 && n < 2000) << n;
    if (!now.local) loop->post({{.force_n = Vec3(0, 0, std::max(-900.0 * now.sample.p_WD.z(), 0.0))}, now.sample.time_ns});
    const Vec3 written_n = device.written.back().force_n;
    if (n > 400) largest_change_n = std::max(largest_change_n, (written_n - last_written_n).norm());
    if (n > 400) least_n = std::min(least_n, written_n.z());
    last_written_n = written_n;
  }
  EXPECT_GT(least_n, 2.6);
  EXPECT_LT(largest_change_n, 2.0 * 0.3 / 0.1 * 1e-3 + 1e-9) << "0.3 N over 0.1 s, for two cycles at once";
}

// When the force changes from patch to network and back, no cycle changes it by more than the fade's share.
TEST_F(LoopWithPatch, TheForceHasNoJumpWhereTheSourceChanges) {
  local.offer(sheet_patch(0.0));
  PatchOrders orders = orders_until(clock.now_ns() + 100'000 * kMs);
  local.publish(orders);
  Vec3 last_written_n = Vec3::Zero();
  double largest_change_n = 0.0;
  for (int n = 0; n < 2000; ++n) {
    device.place.z() = std::max(device.place.z() - 2e-5, -0.003);
    if (n == 600 || n == 1200) {
      orders.is_wanted = n == 1200;
      // As PatchLink does: the patch starts where the haptics node has the probe.
      orders.start_serial += n == 1200 ? 1 : 0;
      orders.p_WP = Vec3(0.001, 0.002, 0.0);
      orders.outward_W = Vec3::UnitZ();
      local.publish(orders);
    }
    const DeviceCycle now = cycle();
    if (!now.local) loop->post({{.force_n = Vec3(0, 0, 2.5)}, now.sample.time_ns});
    const Vec3 written_n = device.written.back().force_n;
    if (n > 400) largest_change_n = std::max(largest_change_n, (written_n - last_written_n).norm());
    last_written_n = written_n;
  }
  // 0.5 N over 0.1 s, for two cycles at once: on simulated time, the cycle that finds no local force keeps the force from before. When the
  // network's force comes, no time has passed that would allow a change, and the next cycle makes up for it.
  EXPECT_LT(largest_change_n, 2.0 * 0.5 / 0.1 * 1e-3 + 1e-9);
  EXPECT_NEAR(last_written_n.z(), 3.0, 1e-6);
}

TEST(LocalPatch, ASampleThatIsNotFiniteChangesNothing) {
  LocalPatch local;
  local.offer(sheet_patch(0.0));
  local.publish(orders_until(1000 * kMs));
  ASSERT_TRUE(local.step(sample_at(Vec3(0, 0, 0.001), 1 * kMs)));
  ASSERT_TRUE(local.step(sample_at(Vec3(0, 0, -0.002), 2 * kMs))->contact);
  (void)local.step(sample_at(Vec3::Constant(std::numeric_limits<double>::quiet_NaN()), 3 * kMs));
  const auto felt = local.step(sample_at(Vec3(0, 0, -0.002), 4 * kMs));
  ASSERT_TRUE(felt);
  EXPECT_TRUE(felt->contact);
}

// In 1 ms, a device that was away comes back in one step, from behind the sheet; in 4 ms, a fast hand goes through the sheet.
TEST(LocalPatch, AHandThatMayHaveGoneAroundIsNotPulledBack) {
  for (const std::int64_t gap_ns : {1 * kMs, 4 * kMs}) {
    LocalPatch local;
    local.offer(sheet_patch(0.0));
    local.publish(orders_until(1000 * kMs));
    for (int n = 1; n <= 10; ++n) ASSERT_TRUE(local.step(sample_at(Vec3(0, 0, 0.015), n * kMs)));
    const auto felt = local.step(sample_at(Vec3(0, 0, -0.015), 10 * kMs + gap_ns));
    ASSERT_TRUE(felt);
    EXPECT_EQ(felt->contact, gap_ns == 4 * kMs);
  }
}

}  // namespace
}  // namespace hapton
