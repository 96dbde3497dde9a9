#include "devices/hid_device.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "runtime/log.h"
#include "tests/devices/device_runner.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/fake_hid.h"
#include "tests/support/patience.h"

namespace hapton {
namespace {

// Input report: {position in mm, status}; output report: {0, whether the device may exert force, force x in N}.
class PlainBackend final : public HidBackend {
 public:
  Result<void> on_open(HidTransport&) override { return {}; }
  bool decode(std::span<const std::uint8_t> report, std::int64_t, DeviceExchange::Reading& reading) noexcept override {
    if (report.size() != 2) return false;
    reading.sample.p_WD = Vec3(1e-3 * report[0], 0, 0);
    reading.status = static_cast<DeviceStatus>(report[1]);
    reading.is_calibrated = true;
    return true;
  }
  std::size_t encode(const Wrench& wrench, bool is_live, std::int64_t, std::span<std::uint8_t> into) noexcept override {
    into[0] = 0;
    into[1] = is_live ? 1 : 0;
    into[2] = static_cast<std::uint8_t>(wrench.force_n.x());
    return 3;
  }
  std::string_view name() const noexcept override { return "plain"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceCondition condition() const noexcept override { return {}; }

 private:
  DeviceLimits limits_;
};

// A device that reports all the time, as real ones do, at a position set by the test.
class Reporter {
 public:
  explicit Reporter(FakeHid& hid)
      : thread_([this, &hid] {
          SteadyClock clock;
          while (!ends_) {
            if (!is_silent_) hid.send({position_mm_, static_cast<std::uint8_t>(status_.load())});
            clock.sleep_until_ns(clock.now_ns() + kNanosecondsPerMillisecond);
          }
        }) {}
  ~Reporter() {
    ends_ = true;
    thread_.join();
  }
  void set_position(std::uint8_t mm) { position_mm_ = mm; }
  void set_status(DeviceStatus status) { status_ = status; }
  void set_silent(bool is_silent) { is_silent_ = is_silent; }

 private:
  std::atomic<bool> ends_ = false, is_silent_ = false;
  std::atomic<std::uint8_t> position_mm_ = 1;
  std::atomic<DeviceStatus> status_ = DeviceStatus::ready;
  std::thread thread_;
};

class HidDeviceTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { start_log("test"); }
  void SetUp() override {
    auto opened = HidDevice::open(std::make_unique<PlainBackend>(), hid_.opener());
    ASSERT_TRUE(opened) << opened.error().what;
    device_ = std::move(*opened);
  }
  template <class Condition>
  bool serve_until(Condition&& holds, double force_n = 100.0) {
    return runner_.serve_until(*device_, holds, {.force_n = Vec3(force_n, 0, 0)});
  }
  bool is_pushing() {
    const auto written = hid_.take_written();
    return !written.empty() && written.back()[1] == 1 && written.back()[2] == 100;
  }
  bool is_releasing() {
    const auto written = hid_.take_written();
    return !written.empty() && written.back()[2] == 0;
  }

  FakeHid hid_;
  Reporter reporter_{hid_};
  std::unique_ptr<HidDevice> device_;
  DeviceRunner runner_;
};

TEST_F(HidDeviceTest, GivesTheNewestPositionAndTakesTheNewestForce) {
  EXPECT_TRUE(serve_until([&] { return device_->status() == DeviceStatus::ready && is_pushing(); }));
  reporter_.set_position(77);
  EXPECT_TRUE(serve_until([&] { return runner_.sample().p_WD.x() == 0.077; }));
}

TEST_F(HidDeviceTest, ReleasesTheForceWhenTheServoIsSilent) {
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
  EXPECT_TRUE(wait_until([&] { return is_releasing(); }));
  (void)hid_.take_written();
  EXPECT_TRUE(wait_until([&] { return hid_.written() >= 5; })) << "and keeps sending that";
  for (const auto& report : hid_.take_written()) EXPECT_EQ(report[1], 0);
}

TEST_F(HidDeviceTest, ACutTurnsOffWhatTheDriverAddsUntilItIsRestored) {
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
  EXPECT_TRUE(device_->cut());
  EXPECT_TRUE(serve_until([&] {
    const auto written = hid_.take_written();
    return !written.empty() && written.back()[1] == 0 && written.back()[2] == 0;
  }));
  (void)hid_.take_written();
  EXPECT_TRUE(serve_until([&] { return hid_.written() >= 5; })) << "the servo keeps writing";
  for (const auto& report : hid_.take_written()) EXPECT_EQ(report[1], 0);
  device_->restore();
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
}

// What a driver adds by itself (gravity compensation) would be computed from outdated angles.
TEST_F(HidDeviceTest, WithoutReportsTheDeviceMayExertNothing) {
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
  reporter_.set_silent(true);
  EXPECT_TRUE(serve_until([&] { return device_->status() == DeviceStatus::away; }));
  (void)hid_.take_written();
  EXPECT_TRUE(serve_until([&] { return hid_.written() >= 5; })) << "the servo keeps writing";
  for (const auto& report : hid_.take_written()) EXPECT_EQ(report[1], 0);
  reporter_.set_silent(false);
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
}

// The device does not use up a CPU by writing the same report again and again.
TEST_F(HidDeviceTest, RepeatsWhatItWroteEveryTwoMilliseconds) {
  constexpr std::size_t kReports = 100;
  const SteadyClock clock;
  EXPECT_TRUE(wait_until([&] { return hid_.written() > 0; }));
  const std::int64_t begin_ns = clock.now_ns();
  (void)hid_.take_written();
  EXPECT_TRUE(wait_until([&] { return hid_.written() >= kReports; }));
  EXPECT_GE(clock.now_ns() - begin_ns, static_cast<std::int64_t>(kReports - 2) * HidDevice::kRepeatNs);
}

TEST_F(HidDeviceTest, UnpluggedInContactItIsAwayAndPluggedInAgainRampsUpFromZero) {
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
  const Vec3 last = runner_.sample().p_WD;
  // If a thread of the device stands still for the whole ramp, the test sees only few steps of it, and tries again.
  int steps = 0;
  for (int attempt = 0; attempt < 10 && steps < 3; ++attempt) {
    hid_.unplug();
    EXPECT_TRUE(serve_until([&] { return device_->status() == DeviceStatus::away; }));
    EXPECT_EQ(runner_.sample().p_WD, last);
    (void)hid_.take_written();
    hid_.plug_in();
    std::vector<FakeHid::Bytes> reports;
    bool was_ready = false, was_away_again = false;
    EXPECT_TRUE(serve_until([&] {
      const auto written = hid_.take_written();
      reports.insert(reports.end(), written.begin(), written.end());
      const bool is_ready = device_->status() == DeviceStatus::ready;
      was_away_again = was_away_again || (was_ready && !is_ready);
      was_ready = was_ready || is_ready;
      return is_ready && !reports.empty() && reports.back()[2] == 100;
    }));
    ASSERT_FALSE(reports.empty());
    EXPECT_EQ(reports.front()[1], 0) << "the first report after it was opened is not a force";
    EXPECT_EQ(reports.front()[2], 0);
    // On a busy machine the servo may have sent no command for half the time for which the device waits for one, or the device no report.
    // Then the force may have been released in between, and only the last ramp counts.
    std::size_t ramp_begin = 0;
    if (runner_.longest_gap_ns() > DeviceExchange::kServoTimeoutNs / 2 || was_away_again) {
      for (ramp_begin = reports.size() - 1; ramp_begin > 0 && reports[ramp_begin][2] != 0;) --ramp_begin;
    }
    steps = 0;
    for (std::size_t n = ramp_begin + 1; n < reports.size(); ++n) {
      EXPECT_GE(reports[n][2], reports[n - 1][2]) << "the ramp only rises";
      steps += reports[n][2] != reports[n - 1][2] ? 1 : 0;
    }
  }
  EXPECT_GE(steps, 3);
}

TEST_F(HidDeviceTest, AWriteThatHangsHoldsNeitherTheServoNorTheReadingUp) {
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
  hid_.block_writes(true);
  EXPECT_TRUE(serve_until([&] { return hid_.has_waiting_writer(); }));
  reporter_.set_position(33);
  EXPECT_TRUE(serve_until([&] { return runner_.sample().p_WD.x() == 0.033 && device_->status() == DeviceStatus::ready; }));
  hid_.block_writes(false);
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
}

TEST_F(HidDeviceTest, UnpluggedWhileAWriteHangsItStillComesBack) {
  hid_.block_writes(true);
  EXPECT_TRUE(serve_until([&] { return hid_.has_waiting_writer(); }));
  hid_.unplug();
  EXPECT_TRUE(serve_until([&] { return device_->status() == DeviceStatus::away; }));
  hid_.block_writes(false);
  hid_.plug_in();
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
}

TEST_F(HidDeviceTest, ADeviceThatTakesNoReportsIsReopened) {
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
  hid_.refuse_writes(true);
  EXPECT_TRUE(serve_until([&] { return hid_.openings() >= 2; }));
  hid_.refuse_writes(false);
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
}

// While a write hangs, the writer does not notice that the device was plugged in again. It must not close it for earlier rejections.
TEST_F(HidDeviceTest, WhatWasRejectedBeforeItWasOpenedAgainDoesNotCount) {
  constexpr int kRejectedEachTime = HidDevice::kMaxRejected * 6 / 10;
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
  hid_.refuse_next(kRejectedEachTime, true);
  EXPECT_TRUE(serve_until([&] { return hid_.has_waiting_writer(); }));
  hid_.unplug();
  EXPECT_TRUE(serve_until([&] { return device_->status() == DeviceStatus::away; }));
  hid_.plug_in();
  EXPECT_TRUE(serve_until([&] { return hid_.openings() == 2 && device_->status() == DeviceStatus::ready; }));
  hid_.refuse_next(kRejectedEachTime);
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
  EXPECT_EQ(hid_.openings(), 2);
}

TEST_F(HidDeviceTest, SilentThoughPluggedInItIsAwayAndItsForceRampsInAgainAfterwards) {
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
  // If a thread of the device stands still for the whole ramp, the test sees nothing of the ramp, and tries again.
  bool saw_ramp = false;
  for (int attempt = 0; attempt < 10 && !saw_ramp; ++attempt) {
    reporter_.set_silent(true);
    EXPECT_TRUE(serve_until([&] { return device_->status() == DeviceStatus::away; }));
    (void)hid_.take_written();
    reporter_.set_silent(false);
    EXPECT_TRUE(serve_until([&] {
      const auto written = hid_.take_written();
      for (const auto& report : written) saw_ramp = saw_ramp || (report[2] > 0 && report[2] < 100);
      return device_->status() == DeviceStatus::ready && !written.empty() && written.back()[2] == 100;
    }));
  }
  EXPECT_TRUE(saw_ramp);
}

TEST_F(HidDeviceTest, AnUncalibratedOrBrokenDeviceGetsNoForce) {
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
  for (const DeviceStatus status : {DeviceStatus::calibrating, DeviceStatus::fault}) {
    reporter_.set_status(status);
    EXPECT_TRUE(serve_until([&] { return device_->status() == status; }));
    // A report from before the change of status may be on its way.
    (void)hid_.take_written();
    EXPECT_TRUE(serve_until([&] { return hid_.written() >= 1; }));
    (void)hid_.take_written();
    EXPECT_TRUE(serve_until([&] { return hid_.written() >= 5; }));
    for (const auto& report : hid_.take_written()) EXPECT_EQ(report[1], 0);
  }
}

TEST_F(HidDeviceTest, LogsOnceThatItCalibratesThatItHasAndThatItIsBroken) {
  EXPECT_TRUE(serve_until([&] { return device_->status() == DeviceStatus::ready; }));
  testing::internal::CaptureStderr();
  for (const DeviceStatus status : {DeviceStatus::calibrating, DeviceStatus::ready, DeviceStatus::fault}) {
    reporter_.set_status(status);
    EXPECT_TRUE(serve_until([&, reads = 0]() mutable { return device_->status() == status && ++reads > 20; }));
  }
  device_.reset();
  const std::string log = testing::internal::GetCapturedStderr();
  const auto count = [&](const std::string& words) {
    int times = 0;
    for (std::size_t at = log.find(words); at != std::string::npos; at = log.find(words, at + 1)) ++times;
    return times;
  };
  EXPECT_EQ(count("plain: not calibrated yet: wait until it has finished calibrating"), 1) << log;
  EXPECT_EQ(count("plain: calibrated"), 1) << log;
  EXPECT_EQ(count("plain: it reports a device fault; switch it off and on"), 1) << log;
}

TEST_F(HidDeviceTest, EndsWithAReportThatReleasesTheForce) {
  EXPECT_TRUE(serve_until([&] { return is_pushing(); }));
  device_.reset();
  EXPECT_EQ(hid_.take_written().back()[1], 0);
}

TEST_F(HidDeviceTest, ReadAndWriteUseNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  EXPECT_TRUE(serve_until([&] { return device_->status() == DeviceStatus::ready; }));
  SteadyClock clock;
  const AllocationGuard guard;
  for (int n = 0; n < 1000; ++n) {
    (void)device_->read(clock.now_ns());
    device_->write({.force_n = Vec3(1, 0, 0)}, clock.now_ns());
    (void)device_->status();
    (void)device_->condition();
  }
  EXPECT_EQ(guard.count(), 0U);
}

TEST(HidDevice, ASilentOrInvalidDeviceIsAnErrorInOneLine) {
  HidDescription description;
  description.path = "/dev/fake";
  FakeHid hid(description);
  std::atomic<bool> ends = false;
  std::thread nonsense([&] {
    while (!ends) {
      hid.send({1, 2, 3});
      SteadyClock().sleep_until_ns(SteadyClock().now_ns() + kNanosecondsPerMillisecond);
    }
  });
  const auto opened = HidDevice::open(std::make_unique<PlainBackend>(), hid.opener());
  ends = true;
  nonsense.join();
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().what.find("plain at /dev/fake: its reports are invalid"), std::string::npos) << opened.error().what;
}

TEST_F(HidDeviceTest, HasAPositionFromTheFirstReadOn) {
  SteadyClock clock;
  EXPECT_EQ(device_->read(clock.now_ns()).p_WD.x(), 0.001);
  EXPECT_TRUE(device_->status() == DeviceStatus::ready || device_->status() == DeviceStatus::away) << "away: its reporter stands still";
}

TEST(HidDevice, AMissingDeviceIsAnErrorInOneLine) {
  FakeHid hid;
  hid.unplug();
  const auto opened = HidDevice::open(std::make_unique<PlainBackend>(), hid.opener());
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().what, "the fake device is not plugged in");
}

}  // namespace
}  // namespace hapton
