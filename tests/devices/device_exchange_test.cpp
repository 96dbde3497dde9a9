#include "devices/device_exchange.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/support/allocation_guard.h"
#include "tests/support/system_call_guard.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

DeviceExchange::Reading ready_at(std::int64_t time_ns, const Vec3& p = Vec3::Zero()) {
  DeviceExchange::Reading reading;
  reading.sample.time_ns = time_ns;
  reading.sample.p_WD = p;
  reading.status = DeviceStatus::ready;
  return reading;
}

TEST(DeviceExchange, TheNewestSampleAndTheNewestWrenchPass) {
  DeviceExchange exchange;
  exchange.publish(ready_at(1000 * kMs));
  exchange.publish(ready_at(1001 * kMs, Vec3(1, 2, 3)));
  const DeviceSample sample = exchange.read(1002 * kMs);
  EXPECT_EQ(sample.p_WD, Vec3(1, 2, 3));
  EXPECT_EQ(sample.time_ns, 1002 * kMs);
  EXPECT_EQ(exchange.status(), DeviceStatus::ready);
  for (std::int64_t t = 1000; t < 1300; ++t) {
    exchange.publish(ready_at(t * kMs));
    exchange.read(t * kMs);
    exchange.write({.force_n = Vec3(0, 0, 2), .torque_nm = Vec3(0.01, 0, 0)}, t * kMs);
    exchange.wrench(t * kMs);
  }
  const Wrench wrench = exchange.wrench(1299 * kMs);
  EXPECT_EQ(wrench.force_n, Vec3(0, 0, 2));
  EXPECT_EQ(wrench.torque_nm, Vec3(0.01, 0, 0));
}

TEST(DeviceExchange, ADeviceThatHasBecomeReadyGetsItsForceOverTheRamp) {
  DeviceExchange exchange;
  exchange.publish(ready_at(0));
  double before_n = 0.0;
  for (std::int64_t t = 0; t <= 300; ++t) {
    exchange.write({.force_n = Vec3(0, 0, 2)}, t * kMs);
    const double n = exchange.wrench(t * kMs).force_n.norm();
    EXPECT_LE(n - before_n, 2.0 / 200.0 + 1e-9);
    before_n = n;
  }
  EXPECT_DOUBLE_EQ(before_n, 2.0);
}

// The driver may stand still between its first sample and its first command, or after a restart of the ramp.
TEST(DeviceExchange, TheRampBeginsWithTheFirstCommandHoweverLateThatIs) {
  DeviceExchange exchange;
  std::int64_t t = 0;
  for (int round = 0; round < 3; ++round) {
    exchange.publish(ready_at(t * kMs));
    t += 150;
    for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      exchange.write({.force_n = Vec3(0, 0, 2)}, t * kMs);
      EXPECT_DOUBLE_EQ(exchange.wrench(t * kMs).force_n.z(), 2.0 * share) << round;
      t += 50;
    }
    exchange.restart_ramp();
  }
}

TEST(DeviceExchange, NoForceWhileTheDeviceIsNotReady) {
  for (const DeviceStatus status : {DeviceStatus::calibrating, DeviceStatus::away, DeviceStatus::fault, DeviceStatus::ended}) {
    DeviceExchange exchange;
    DeviceExchange::Reading reading = ready_at(0);
    reading.status = status;
    exchange.publish(reading);
    for (std::int64_t t = 0; t < 500; ++t) {
      exchange.read(t * kMs);
      exchange.write({.force_n = Vec3(0, 0, 2)}, t * kMs);
      ASSERT_EQ(exchange.wrench(t * kMs).force_n, Vec3::Zero());
    }
  }
}

TEST(DeviceExchange, AServoThatTimedOutExertsNoForceAndRampsUpAgain) {
  DeviceExchange exchange;
  std::int64_t t = 0;
  exchange.publish(ready_at(0));
  for (; t <= 300; ++t) {
    exchange.write({.force_n = Vec3(0, 0, 2)}, t * kMs);
    exchange.wrench(t * kMs);
  }
  t = 300;
  EXPECT_EQ(exchange.wrench((t + 20) * kMs).force_n, Vec3(0, 0, 2));
  EXPECT_EQ(exchange.wrench((t + 21) * kMs).force_n, Vec3::Zero());
  exchange.read((t + 40) * kMs);
  EXPECT_LT(exchange.wrench((t + 40) * kMs).force_n.norm(), 0.5);
}

TEST(DeviceExchange, ACutReleasesTheForceAndItRampsUpOnceItIsRestored) {
  DeviceExchange exchange;
  exchange.publish(ready_at(0));
  const auto force_n_at = [&](std::int64_t t) {
    exchange.write({.force_n = Vec3(0, 0, 2)}, t * kMs);
    return exchange.wrench(t * kMs).force_n.z();
  };
  EXPECT_FALSE(exchange.is_cut());
  EXPECT_EQ(force_n_at(0), 0.0);
  ASSERT_EQ(force_n_at(300), 2.0);
  exchange.cut();
  EXPECT_TRUE(exchange.is_cut());
  EXPECT_EQ(force_n_at(301), 0.0);
  EXPECT_EQ(force_n_at(399), 0.0);
  exchange.restore();
  EXPECT_FALSE(exchange.is_cut());
  EXPECT_EQ(force_n_at(400), 0.0) << "without a jump";
  EXPECT_DOUBLE_EQ(force_n_at(450), 0.5);
  EXPECT_DOUBLE_EQ(force_n_at(600), 2.0);
}

TEST(DeviceExchange, AServoThatOnlyReadsHoldsItsForce) {
  DeviceExchange exchange;
  exchange.publish(ready_at(0));
  exchange.write({.force_n = Vec3(0, 0, 2)}, 0);
  for (std::int64_t t = 0; t <= 400; ++t) {
    exchange.read(t * kMs);
    exchange.publish(ready_at(t * kMs));
    exchange.wrench(t * kMs);
  }
  EXPECT_EQ(exchange.wrench(400 * kMs).force_n, Vec3(0, 0, 2));
}

TEST(DeviceExchange, ADriverThatFellSilentIsAwayAndItsLastSampleStays) {
  DeviceExchange exchange;
  exchange.publish(ready_at(1000 * kMs, Vec3(1, 2, 3)));
  EXPECT_EQ(exchange.read(1100 * kMs).p_WD, Vec3(1, 2, 3));
  EXPECT_EQ(exchange.status(), DeviceStatus::ready);
  EXPECT_EQ(exchange.read(1101 * kMs).p_WD, Vec3(1, 2, 3));
  EXPECT_EQ(exchange.status(), DeviceStatus::away);
  exchange.publish(ready_at(1102 * kMs));
  exchange.read(1102 * kMs);
  EXPECT_EQ(exchange.status(), DeviceStatus::ready);
}

TEST(DeviceExchange, AFaultStaysAFault) {
  DeviceExchange exchange;
  DeviceExchange::Reading reading = ready_at(0);
  reading.status = DeviceStatus::fault;
  exchange.publish(reading);
  exchange.read(5000 * kMs);
  EXPECT_EQ(exchange.status(), DeviceStatus::fault);
}

void use_both_ends(DeviceExchange& exchange) {
  for (std::int64_t t = 0; t < 1000; ++t) {
    exchange.publish(ready_at(t * kMs));
    exchange.read(t * kMs);
    exchange.write({.force_n = Vec3(0, 0, 1)}, t * kMs);
    exchange.wrench(t * kMs);
  }
}

TEST(DeviceExchange, UsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  const auto exchange = std::make_unique<DeviceExchange>();
  const AllocationGuard guard;
  use_both_ends(*exchange);
  EXPECT_EQ(guard.count(), 0U);
}

TEST(DeviceExchange, MakesNoSystemCall) {
  if (!SystemCallGuard::is_available()) GTEST_SKIP() << "system calls cannot be forbidden in this build or on this kernel";
  std::unique_ptr<DeviceExchange> exchange;
  EXPECT_EQ(SystemCallGuard::run([&] { exchange = std::make_unique<DeviceExchange>(); }, [&] { use_both_ends(*exchange); }), "");
}

}  // namespace
}  // namespace hapton
