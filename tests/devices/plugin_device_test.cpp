#include "devices/plugin_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "devices/device_maker.h"
#include "safety/safety_governor.h"
#include "tests/standins/paths.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

Result<std::unique_ptr<Device>> make_odd_device(const std::string& parameters = "") {
  DeviceSettings settings;
  settings.name = "plugin:" + standin::library("plugins/odd_device.so") + (parameters.empty() ? "" : ":" + parameters);
  return make_device(settings);
}

TEST(PluginDevice, IsReadAndDrivenWithinItsLimits) {
  const auto device = std::move(*make_odd_device());
  EXPECT_EQ(device->name(), "plugin line");
  EXPECT_EQ(device->limits().max_force_n, 3.0);
  EXPECT_EQ(device->limits().workspace_max_m, Vec3(1, 1, 1));
  device->write({.force_n = {0, 0.5, 0}}, 1000);
  const DeviceSample sample = device->read(1'000'000'000);
  EXPECT_EQ(sample.time_ns, 1'000'000'000);
  EXPECT_NEAR(sample.p_WD.x(), 0.1, 1e-12);
  EXPECT_EQ(sample.p_WD.y(), 0.5);
  EXPECT_EQ(sample.buttons, 5U);
  EXPECT_TRUE(sample.is_held);
  EXPECT_EQ(device->status(), DeviceStatus::ready);
}

TEST(PluginDevice, GetsAForceOfZeroBeforeItIsClosed) {
  const auto device = std::move(*make_odd_device());
  device->write({.force_n = {0, 2, 0}}, 1000);
  EXPECT_EQ(device->read(2000).p_WD.y(), 2.0);
}  // the stand-in aborts otherwise

TEST(PluginDevice, WhatItSaysOfItselfIsItsStatus) {
  const auto status_of = [](const char* does) {
    const auto device = std::move(*make_odd_device(std::string("does=") + does));
    device->read(1000);
    device->write({}, 1000);
    return device->status();
  };
  EXPECT_EQ(status_of("fault"), DeviceStatus::fault);
  EXPECT_EQ(status_of("ended"), DeviceStatus::ended);
  EXPECT_EQ(status_of("unknown"), DeviceStatus::fault);
  EXPECT_EQ(status_of("exception"), DeviceStatus::fault);
  EXPECT_EQ(status_of("write_exception"), DeviceStatus::fault);
}

TEST(PluginDevice, AwayRepeatsTheLastSample) {
  const auto device = std::move(*make_odd_device("does=away"));
  const Vec3 first = device->read(1'000'000'000).p_WD;
  EXPECT_EQ(device->status(), DeviceStatus::ready);
  EXPECT_EQ(device->read(2'000'000'000).p_WD, first);
  EXPECT_EQ(device->status(), DeviceStatus::away);
  EXPECT_NE(device->read(3'000'000'000).p_WD, first);
}

// After a fault, the plug-in's own memory may be damaged.
TEST(PluginDevice, AfterAFaultItIsReadNoMore) {
  const auto device = std::move(*make_odd_device("does=write_exception"));
  const Vec3 first = device->read(1'000'000'000).p_WD;
  device->write({}, 1'000'000'000);
  const DeviceSample after = device->read(2'000'000'000);
  EXPECT_EQ(device->status(), DeviceStatus::fault);
  EXPECT_EQ(after.p_WD, first);
  EXPECT_EQ(after.time_ns, 2'000'000'000);
}

TEST(PluginDevice, AQuaternionThatIsRoundedIsNormalized) { EXPECT_EQ((*make_odd_device("does=nearly"))->read(1000).q_WT.norm(), 1.0); }

// The governor is used as in io_node.
TEST(PluginDevice, NonsenseReachesNoMotor) {
  for (const char* does : {"nan", "q"}) {
    const auto device = std::move(*make_odd_device(std::string("after=100,does=") + does));
    SafetyGovernor governor(device->limits());
    double last_force_n = 0.0;
    double largest_force_n = 0.0;
    for (std::int64_t now_ns = 1'000'000; now_ns < 1'000'000'000; now_ns += 1'000'000) {
      governor.observe(device->read(now_ns), device->status());
      const WrenchCommand command{.wrench = {.force_n = {1, 0, 0}}, .sample_time_ns = now_ns};
      device->write(governor.step(command, now_ns), now_ns);
      last_force_n = governor.output().force_n.norm();
      largest_force_n = std::max(largest_force_n, last_force_n);
    }
    EXPECT_GT(largest_force_n, 0.5) << does;
    EXPECT_EQ(last_force_n, 0.0) << does;
    EXPECT_NE(governor.fault(), SafetyFault::none) << does;
  }
}

TEST(PluginDevice, EachFaultAtTheStartIsOneLine) {
  EXPECT_THAT(make_odd_device("does=reject").error().what, HasSubstr("plugin line does not start: nothing is plugged in"));
  EXPECT_THAT(make_odd_device("does=open_exception").error().what, HasSubstr("odd_device.so: plugin line threw a C++ exception in open"));
  EXPECT_THAT(make_odd_device("does=strong").error().what, HasSubstr("max_force_n of nan"));
  EXPECT_THAT(make_odd_device("does=no_slew").error().what, HasSubstr("no max_slew_n_per_s"));
  EXPECT_THAT(make_odd_device("does=no_box").error().what, HasSubstr("no workspace"));
  DeviceSettings settings;
  settings.name = "plugin";
  EXPECT_THAT(make_device(settings).error().what, HasSubstr("--device plugin:FILE.so"));
  settings.name = "plugin:" + standin::library("plugins/odd_effect.so");
  EXPECT_THAT(make_device(settings).error().what, AllOf(HasSubstr("exports no hapton_device"), HasSubstr("an effect")));
}

TEST(PluginDevice, OurSideUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "allocations cannot be counted in this build";
  const auto device = std::move(*make_odd_device());
  const AllocationGuard heap;
  for (std::int64_t n = 1; n < 1000; ++n) {
    device->read(n * 1'000'000);
    device->write({}, n * 1'000'000);
  }
  EXPECT_EQ(heap.count(), 0U);
}

// Each number is different, so that the test fails if two are interchanged.
TEST(PluginDevice, EveryLimitThatItStatesIsKept) {
  const DeviceLimits limits = (*make_odd_device("does=full"))->limits();
  EXPECT_EQ(limits.max_force_n, 3.0);
  EXPECT_EQ(limits.max_slew_n_per_s, 3000.0);
  EXPECT_EQ(limits.max_stiffness_n_per_m, 900.0);
  EXPECT_EQ(limits.max_torque_nm, 0.25);
  EXPECT_EQ(limits.max_torque_slew_nm_per_s, 40.0);
  EXPECT_EQ(limits.continuous_force_n, 1.5);
  EXPECT_EQ(limits.peak_s, 7.0);
  EXPECT_EQ(limits.max_speed_m_per_s, 2.5);
  EXPECT_EQ(limits.workspace_min_m, Vec3(-1, -1, -1));
}

TEST(PluginDevice, ForceAndTorqueArriveAsSuch) {
  const auto device = std::move(*make_odd_device("does=full"));
  device->write({.force_n = {0, 0.5, 0.1}, .torque_nm = {0, 0.2, 0.125}}, 1000);
  EXPECT_EQ(device->read(2000).p_WD.y(), 0.5);
  EXPECT_EQ(device->read(3000).p_WD.z(), 0.125);
}

TEST(PluginDevice, AHandThatLetsGoAndACalibrationAreReported) {
  const auto released = std::move(*make_odd_device("does=released,after=1"));
  EXPECT_TRUE(released->read(1000).is_held);
  EXPECT_FALSE(released->read(2000).is_held);
  EXPECT_EQ(released->status(), DeviceStatus::ready);
  const auto calibrating = std::move(*make_odd_device("does=calibrating,after=1"));
  calibrating->read(1000);
  EXPECT_EQ(calibrating->status(), DeviceStatus::ready);
  calibrating->read(2000);
  EXPECT_EQ(calibrating->status(), DeviceStatus::calibrating);
}

TEST(PluginDevice, TheEndOfTheProcessReleasesItsForce) {
  HeartbeatPage page;
  (*make_odd_device())->use_heartbeat_page(page);
  EXPECT_EQ(page.means.load(), CutMeans::kill);
}

}  // namespace
}  // namespace hapton
