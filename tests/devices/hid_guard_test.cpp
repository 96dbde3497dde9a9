// What a HID device tells the watchdog process, and what it reports about its motors.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <memory>
#include <string>
#include <thread>

#include "devices/hid_device.h"
#include "tests/support/fake_hid.h"
#include "tests/support/patience.h"

namespace hapton {
namespace {

// With this the test delays a device while it is being opened.
struct Opening {
  std::atomic<bool> is_blocked = false, has_begun = false;
};

// Input report: {temperature in hundredths, whether the device is calibrated}; output report: {7, whether it may exert force, 9}.
class WarmBackend final : public HidBackend {
 public:
  explicit WarmBackend(Opening& opening) : opening_(opening) {}
  Result<void> on_open(HidTransport&) override {
    opening_.has_begun = true;
    SteadyClock clock;
    while (opening_.is_blocked) clock.sleep_until_ns(clock.now_ns() + kNanosecondsPerMillisecond);
    return {};
  }
  bool decode(std::span<const std::uint8_t> report, std::int64_t, DeviceExchange::Reading& reading) noexcept override {
    if (report.size() != 2) return false;
    reading.status = DeviceStatus::ready;
    reading.motor_temperature = 0.01 * report[0];
    reading.is_calibrated = report[1] != 0;
    return true;
  }
  std::size_t encode(const Wrench&, bool is_live, std::int64_t, std::span<std::uint8_t> into) noexcept override {
    into[0] = 7;
    into[1] = is_live ? 1 : 0;
    into[2] = 9;
    return 3;
  }
  std::string_view name() const noexcept override { return "warm"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceCondition condition() const noexcept override { return {}; }

 private:
  Opening& opening_;
  DeviceLimits limits_;
};

HidDescription warm_description() {
  HidDescription description;
  description.path = "/dev/hidraw-warm";
  return description;
}

struct GuardedHid : testing::Test {
  void SetUp() override {
    reporter = std::thread([this] {
      SteadyClock clock;
      while (!ends) {
        hid.send({temperature_percent.load(), is_calibrated.load()});
        clock.sleep_until_ns(clock.now_ns() + kNanosecondsPerMillisecond);
      }
    });
    auto opened = HidDevice::open(std::make_unique<WarmBackend>(opening), hid.opener());
    ASSERT_TRUE(opened) << opened.error().what;
    device = std::move(*opened);
  }
  void TearDown() override {
    device.reset();
    ends = true;
    reporter.join();
  }
  // The condition after a new read.
  DeviceCondition condition() {
    (void)device->read(SteadyClock().now_ns());
    return device->condition();
  }
  void expect_the_means_to_turn_it_off() const {
    EXPECT_EQ(page->means.load(), CutMeans::hid);
    EXPECT_EQ(page->generation.load() % 2, 0U);
    std::string path;
    for (const auto& letter : page->path) {
      if (letter.load() == '\0') break;
      path += letter.load();
    }
    EXPECT_EQ(path, "/dev/hidraw-warm");
    ASSERT_EQ(page->report_size.load(), 3U);
    EXPECT_EQ(page->report[0].load(), 7);
    EXPECT_EQ(page->report[1].load(), 0) << "no force";
    EXPECT_EQ(page->report[2].load(), 9);
  }

  FakeHid hid{warm_description()};
  Opening opening;
  std::atomic<std::uint8_t> temperature_percent = 20, is_calibrated = 1;
  std::atomic<bool> ends = false;
  std::thread reporter;
  const std::unique_ptr<HeartbeatPage> page = std::make_unique<HeartbeatPage>();
  std::unique_ptr<HidDevice> device;
};

TEST_F(GuardedHid, ThePageGetsItsNodeAndTheReportThatTurnsItOff) {
  device->use_heartbeat_page(*page);
  expect_the_means_to_turn_it_off();
}

// When it is plugged in again, the device may have another device node.
TEST_F(GuardedHid, ThePageGetsTheMeansAnewWhenTheDeviceIsPluggedInAgain) {
  device->use_heartbeat_page(*page);
  const std::uint32_t before = page->generation.load();
  page->set_means(CutMeans::none);
  hid.unplug();
  hid.plug_in();
  ASSERT_TRUE(wait_until([&] { return page->generation.load() > before && page->generation.load() % 2 == 0; }));
  expect_the_means_to_turn_it_off();
}

// Otherwise io_node would report that there are no means to cut the device.
TEST_F(GuardedHid, APageThatComesWhileItIsUnpluggedHasItsMeans) {
  hid.unplug();
  ASSERT_TRUE(wait_until([&] {
    (void)device->read(SteadyClock().now_ns());
    return device->status() == DeviceStatus::away;
  }));
  device->use_heartbeat_page(*page);
  EXPECT_EQ(page->means.load(), CutMeans::hid);
  hid.plug_in();
  ASSERT_TRUE(wait_until([&] { return page->path[0].load() != '\0' && page->generation.load() % 2 == 0; }));
  expect_the_means_to_turn_it_off();
}

// A device that is unplugged and plugged in while io_node starts would otherwise stay without the watchdog process.
TEST_F(GuardedHid, APageThatComesWhileTheDeviceIsOpenedAgainGetsTheMeansToo) {
  opening.has_begun = false;
  opening.is_blocked = true;
  hid.unplug();
  hid.plug_in();
  EXPECT_TRUE(wait_until([&] { return opening.has_begun.load(); }));
  std::thread owner([&] { device->use_heartbeat_page(*page); });
  SteadyClock clock;
  clock.sleep_until_ns(clock.now_ns() + 50 * kNanosecondsPerMillisecond);  // by then the owner waits until the device is open
  opening.is_blocked = false;
  owner.join();
  expect_the_means_to_turn_it_off();
}

// With the temperature the governor judges whether the motors are too hot.
TEST_F(GuardedHid, SaysHowWarmItsMotorsAreAndWhetherItIsCalibrated) {
  EXPECT_TRUE(wait_until([&] { return std::abs(condition().motor_temperature - 0.2) < 1e-9 && condition().is_calibrated; }));
  temperature_percent = 95;
  is_calibrated = 0;
  EXPECT_TRUE(wait_until([&] { return std::abs(condition().motor_temperature - 0.95) < 1e-9 && !condition().is_calibrated; }));
}

}  // namespace
}  // namespace hapton
