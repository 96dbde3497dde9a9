#include "devices/vendor_device.h"

#include <gtest/gtest.h>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

// A device for which the test acts as the driver.
class DrivenDevice final : public VendorDevice {
 public:
  std::string_view name() const noexcept override { return "driven"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }

  // One cycle of the servo, which commands 2 N, and of the driver; returns the force that the driver applies.
  double force_n_at(std::int64_t t_ms) {
    DeviceExchange::Reading reading;
    reading.sample.time_ns = t_ms * kMs;
    reading.status = DeviceStatus::ready;
    exchange_.publish(reading);
    read(t_ms * kMs);
    write({.force_n = Vec3(0, 0, 2)}, t_ms * kMs);
    return exchange_.wrench(t_ms * kMs).force_n.z();
  }

 private:
  DeviceLimits limits_;
};

TEST(VendorDevice, ACutTakesTheForceFromItsDriverUntilItIsRestored) {
  DrivenDevice device;
  for (std::int64_t t_ms = 0; t_ms < 300; ++t_ms) device.force_n_at(t_ms);
  ASSERT_EQ(device.force_n_at(300), 2.0);
  EXPECT_EQ(device.status(), DeviceStatus::ready);
  EXPECT_TRUE(device.cut());
  for (std::int64_t t_ms = 301; t_ms < 310; ++t_ms) EXPECT_EQ(device.force_n_at(t_ms), 0.0) << t_ms;
  device.restore();
  EXPECT_EQ(device.force_n_at(310), 0.0) << "without a jump";
  for (std::int64_t t_ms = 311; t_ms < 510; ++t_ms) device.force_n_at(t_ms);
  EXPECT_EQ(device.force_n_at(510), 2.0);
}

// No other process can reach the device. Its driver, or that of the library, notices that the handle was closed.
TEST(VendorDevice, IsReleasedByTheEndOfItsProcess) {
  DrivenDevice device;
  HeartbeatPage page;
  device.use_heartbeat_page(page);
  EXPECT_EQ(page.means.load(), CutMeans::kill);
}

}  // namespace
}  // namespace hapton
