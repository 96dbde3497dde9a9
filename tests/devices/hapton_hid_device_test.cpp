#include "devices/hapton_hid_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "docs/hid/hapton_hid_device.h"
#include "tests/support/fake_hid.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;
using Bytes = FakeHid::Bytes;

hapton_hid_limits maker_limits() {
  hapton_hid_limits limits = {};
  limits.has_orientation = true;
  limits.rate_hz = 1000;
  limits.watchdog_ms = 20;
  for (int n = 0; n < 3; ++n) {
    limits.workspace_min_m[n] = -0.1f;
    limits.workspace_max_m[n] = 0.1f;
  }
  limits.max_force_n = 6.0f;
  limits.continuous_force_n = 2.0f;
  limits.max_slew_n_per_s = 2000.0f;
  limits.model = "Arm";
  limits.serial = "7";
  limits.firmware = "1.0";
  return limits;
}

// The backend and the device maker's own code, one at each end of a simulated connection.
class HaptonHid : public ::testing::Test {
 protected:
  void SetUp() override {
    set_limits(maker_limits());
    measured_.is_calibrated = true;
    measured_.orientation[3] = 1.0f;
  }
  void set_limits(const hapton_hid_limits& limits) {
    hapton_hid_init(&device_, &limits);
    for (const std::uint8_t id : {hapton_hid::kLimitsId, hapton_hid::kNamesId}) {
      Bytes report(64);
      report.resize(hapton_hid_feature(&device_, id, report.data(), report.size()));
      hid_.set_feature(id, report);
    }
  }
  Result<void> open() {
    auto transport = hid_.opener()();
    return backend_.on_open(**transport);
  }
  std::uint32_t now_us() const { return static_cast<std::uint32_t>(now_ns_ / 1000); }
  // One cycle of a millisecond in each direction; returns the motors' force after it, N.
  double cycle(const Vec3& force_n, bool is_live) {
    now_ns_ += kMs;
    Bytes state(HAPTON_HID_STATE_BYTES);
    hapton_hid_state(&device_, &measured_, now_us(), state.data());
    EXPECT_TRUE(backend_.decode(state, now_ns_, reading_));
    Bytes force(64);
    force.resize(backend_.encode({.force_n = force_n, .torque_nm = Vec3(1, 1, 1)}, is_live, now_ns_, force));
    EXPECT_TRUE(hapton_hid_take_force(&device_, force.data(), force.size(), now_us()));
    float motor_force[3], motor_torque[3];
    hapton_hid_motors(&device_, now_us(), motor_force, motor_torque);
    EXPECT_EQ(motor_torque[0], 0.0f) << "it has no such motors";
    return Vec3(motor_force[0], motor_force[1], motor_force[2]).norm();
  }

  FakeHid hid_;
  HaptonHidBackend backend_;
  hapton_hid_device device_;
  hapton_hid_measured measured_ = {};
  DeviceExchange::Reading reading_;
  std::int64_t now_ns_ = kNanosecondsPerSecond;
};

TEST_F(HaptonHid, IsWhatItsMakerSays) {
  ASSERT_TRUE(open());
  EXPECT_EQ(backend_.limits().max_force_n, 6.0);
  EXPECT_EQ(backend_.limits().continuous_force_n, 2.0);
  EXPECT_LT((backend_.limits().workspace_max_m - Vec3::Constant(0.1)).norm(), 1e-6);
  EXPECT_EQ(backend_.condition().model, "Arm");
  EXPECT_EQ(backend_.condition().serial, "7");
  EXPECT_EQ(backend_.condition().firmware, "1.0");
}

// Each number is different, so that the test fails if two are interchanged.
TEST_F(HaptonHid, EveryLimitOfItsMakerIsKept) {
  hapton_hid_limits stated = maker_limits();
  stated.has_torque = true;
  stated.max_stiffness_n_per_m = 900.0f;
  stated.peak_s = 3.0f;
  stated.max_torque_nm = 0.25f;
  stated.max_torque_slew_nm_per_s = 40.0f;
  stated.max_speed_m_per_s = 2.5f;
  for (int n = 0; n < 3; ++n) {
    stated.workspace_min_m[n] = -0.05f - 0.01f * static_cast<float>(n);
    stated.workspace_max_m[n] = 0.15f + 0.01f * static_cast<float>(n);
  }
  set_limits(stated);
  ASSERT_TRUE(open());
  const DeviceLimits limits = backend_.limits();
  EXPECT_NEAR(limits.max_force_n, 6.0, 1e-6);
  EXPECT_NEAR(limits.max_slew_n_per_s, 2000.0, 1e-3);
  EXPECT_NEAR(limits.max_stiffness_n_per_m, 900.0, 1e-3);
  EXPECT_NEAR(limits.continuous_force_n, 2.0, 1e-6);
  EXPECT_NEAR(limits.peak_s, 3.0, 1e-6);
  EXPECT_NEAR(limits.max_torque_nm, 0.25, 1e-6);
  EXPECT_NEAR(limits.max_torque_slew_nm_per_s, 40.0, 1e-3);
  EXPECT_NEAR(limits.max_speed_m_per_s, 2.5, 1e-6);
  EXPECT_LT((limits.workspace_min_m - Vec3(-0.05, -0.06, -0.07)).norm(), 1e-6);
  EXPECT_LT((limits.workspace_max_m - Vec3(0.15, 0.16, 0.17)).norm(), 1e-6);
}

TEST_F(HaptonHid, ExertsTheRequestedForce) {
  ASSERT_TRUE(open());
  EXPECT_EQ(cycle(Vec3(1, 2, 2), true), 0.0) << "not before it was commanded off";
  EXPECT_EQ(cycle(Vec3::Zero(), false), 0.0);
  EXPECT_EQ(reading_.status, DeviceStatus::ready);
  EXPECT_EQ(cycle(Vec3(1, 2, 2), true), 3.0);
}

TEST_F(HaptonHid, WithATrippedWatchdogIsAwayUntilSwitchedOff) {
  ASSERT_TRUE(open());
  cycle(Vec3::Zero(), false);
  cycle(Vec3(1, 0, 0), true);
  now_ns_ += 100 * kMs;
  cycle(Vec3(1, 0, 0), true);
  EXPECT_EQ(reading_.status, DeviceStatus::away);
  EXPECT_EQ(cycle(Vec3::Zero(), false), 0.0);
  EXPECT_EQ(cycle(Vec3(1, 0, 0), true), 1.0);
  EXPECT_EQ(reading_.status, DeviceStatus::ready);
}

TEST_F(HaptonHid, ReportsItsMeasurementsAndItsState) {
  ASSERT_TRUE(open());
  measured_.position_m[1] = 0.05f;
  measured_.buttons = 3;
  measured_.temperature = 0.25f;
  cycle(Vec3::Zero(), false);
  EXPECT_LT((reading_.sample.p_WD - Vec3(0, 0.05, 0)).norm(), 1e-7);
  EXPECT_EQ(reading_.sample.buttons, 3U);
  EXPECT_EQ(reading_.motor_temperature, 0.25);
  EXPECT_TRUE(reading_.sample.is_held) << "it cannot tell";
  measured_.is_calibrated = false;
  cycle(Vec3::Zero(), false);
  EXPECT_EQ(reading_.status, DeviceStatus::calibrating);
  measured_.has_fault = true;
  cycle(Vec3::Zero(), false);
  EXPECT_EQ(reading_.status, DeviceStatus::fault);
}

TEST_F(HaptonHid, RepeatedStatesAreNoNews) {
  ASSERT_TRUE(open());
  Bytes state(HAPTON_HID_STATE_BYTES);
  hapton_hid_state(&device_, &measured_, 0, state.data());
  EXPECT_TRUE(backend_.decode(state, now_ns_, reading_));
  EXPECT_FALSE(backend_.decode(state, now_ns_, reading_));
}

// A device that was switched off and on may begin with the same number of its state.
TEST_F(HaptonHid, AfterItWasOpenedAgainTheSameStateIsNews) {
  ASSERT_TRUE(open());
  Bytes state(HAPTON_HID_STATE_BYTES);
  hapton_hid_state(&device_, &measured_, 0, state.data());
  ASSERT_TRUE(backend_.decode(state, now_ns_, reading_));
  ASSERT_TRUE(open());
  EXPECT_TRUE(backend_.decode(state, now_ns_, reading_));
}

TEST_F(HaptonHid, EachForceIsNumberedAndNamesTheNewestState) {
  ASSERT_TRUE(open());
  const auto number_at = [](const Bytes& report, std::size_t at) { return report[at] | (report[at + 1] << 8); };
  const auto next = [&] {
    Bytes force(hapton_hid::kForceBytes);
    EXPECT_EQ(backend_.encode({}, false, now_ns_, force), force.size());
    return force;
  };
  const Bytes first = next(), second = next();
  EXPECT_EQ(number_at(second, 2), number_at(first, 2) + 1);
  EXPECT_EQ(number_at(first, 4), 0) << "none yet";
  Bytes state(HAPTON_HID_STATE_BYTES);
  for (int n = 0; n < 300; ++n) hapton_hid_state(&device_, &measured_, 0, state.data());
  ASSERT_TRUE(backend_.decode(state, now_ns_, reading_));
  ASSERT_GT(number_at(state, 2), 0xFF);
  EXPECT_EQ(number_at(next(), 4), number_at(state, 2));
  ASSERT_TRUE(open());
  EXPECT_EQ(number_at(next(), 4), 0) << "none since it was opened again";
  Bytes small(hapton_hid::kForceBytes - 1);
  EXPECT_EQ(backend_.encode({}, false, now_ns_, small), 0U);
}

// The bit for a held stylus has no meaning for such a device: if it counted, a dead man's switch would never be held.
TEST_F(HaptonHid, OneThatCannotSenseAHandIsAlwaysHeld) {
  ASSERT_TRUE(open());
  Bytes state(HAPTON_HID_STATE_BYTES);
  hapton_hid_state(&device_, &measured_, 0, state.data());
  state[1] = 1;  // calibrated, and nothing else
  ASSERT_TRUE(backend_.decode(state, now_ns_, reading_));
  EXPECT_TRUE(reading_.sample.is_held);
}

TEST_F(HaptonHid, ThatComesBackAsAnotherDeviceIsNotDriven) {
  ASSERT_TRUE(open());
  ASSERT_TRUE(open()) << "the same one is";
  hapton_hid_limits limits = maker_limits();
  limits.max_force_n = 60.0f;
  set_limits(limits);
  EXPECT_THAT(open().error().what, HasSubstr("not the same device as before"));
  limits = maker_limits();
  limits.serial = "8";
  set_limits(limits);
  EXPECT_THAT(open().error().what, HasSubstr("Arm 8"));
}

TEST_F(HaptonHid, WithImpossibleLimitsIsRejected) {
  hapton_hid_limits limits = maker_limits();
  limits.watchdog_ms = 2000;
  set_limits(limits);
  EXPECT_THAT(open().error().what, HasSubstr("watchdog takes 2000 ms"));
  hid_.set_feature(HAPTON_HID_LIMITS_ID, {HAPTON_HID_LIMITS_ID});
  EXPECT_THAT(open().error().what, HasSubstr("HAPT"));
}

TEST_F(HaptonHid, UnpluggedBeforeItHasStatedItsLimitsIsRejected) {
  const auto transport = hid_.opener()();
  ASSERT_TRUE(transport);
  hid_.unplug();
  const auto opened = backend_.on_open(**transport);
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().what, HasSubstr("no such feature report"));
}

TEST_F(HaptonHid, AnyBytesAreSafeBeforeAndAfterItWasOpened) {
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 20'000; ++trial) {
    if (trial == 10'000) {
      ASSERT_TRUE(open());
    }
    Bytes bytes(random() % 70);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    if (!bytes.empty()) bytes[0] = HAPTON_HID_STATE_ID;
    (void)backend_.decode(bytes, now_ns_, reading_);
    ASSERT_TRUE(reading_.sample.p_WD.allFinite());
    ASSERT_NEAR(reading_.sample.q_WT.norm(), 1.0, 1e-9);
  }
}

TEST_F(HaptonHid, AHandThatLetsGoIsReportedWhereTheDeviceSensesIt) {
  hapton_hid_limits limits = maker_limits();
  limits.knows_held = true;
  set_limits(limits);
  ASSERT_TRUE(open());
  for (const bool is_held : {true, false, true}) {
    measured_.is_held = is_held;
    cycle(Vec3::Zero(), false);
    EXPECT_EQ(reading_.sample.is_held, is_held);
  }
}

TEST_F(HaptonHid, ItsOrientationCountsOnlyWhereItMeasuresOne) {
  const Quat turned(Eigen::AngleAxisd(0.5, Vec3(1, 2, 2) / 3.0));
  for (int n = 0; n < 4; ++n) measured_.orientation[n] = static_cast<float>(turned.coeffs()[n]);
  for (const bool has_orientation : {true, false}) {
    hapton_hid_limits limits = maker_limits();
    limits.has_orientation = has_orientation;
    set_limits(limits);
    backend_ = HaptonHidBackend();
    ASSERT_TRUE(open());
    cycle(Vec3::Zero(), false);
    EXPECT_LT(reading_.sample.q_WT.angularDistance(has_orientation ? turned : Quat::Identity()), 1e-4) << has_orientation;
  }
}

TEST_F(HaptonHid, TorquesArriveWhereThereAreMotorsForThem) {
  hapton_hid_limits limits = maker_limits();
  limits.has_torque = true;
  limits.max_torque_nm = 0.5f;
  limits.max_torque_slew_nm_per_s = 50.0f;
  set_limits(limits);
  ASSERT_TRUE(open());
  for (const bool is_live : {false, true}) {
    Bytes force(64);
    force.resize(backend_.encode({.torque_nm = Vec3(0.0, 0.25, 0.0)}, is_live, now_ns_, force));
    EXPECT_TRUE(hapton_hid_take_force(&device_, force.data(), force.size(), now_us()));
  }
  float motor_force[3], motor_torque[3];
  ASSERT_TRUE(hapton_hid_motors(&device_, now_us(), motor_force, motor_torque));
  EXPECT_FLOAT_EQ(motor_torque[1], 0.25f);
}

// The servo would wait for a device that is away; a fault latches.
TEST_F(HaptonHid, AFaultCountsMoreThanATrippedWatchdogAndThatMoreThanItsCalibration) {
  ASSERT_TRUE(open());
  constexpr int kIsCalibrated = 1, kHasTripped = 8, kHasFault = 32;
  struct Row {
    int bits;
    DeviceStatus status;
  };
  const Row rows[] = {{kIsCalibrated, DeviceStatus::ready},
                      {0, DeviceStatus::calibrating},
                      {kIsCalibrated | kHasTripped, DeviceStatus::away},
                      {kHasTripped, DeviceStatus::away},
                      {kIsCalibrated | kHasTripped | kHasFault, DeviceStatus::fault},
                      {kHasFault, DeviceStatus::fault}};
  for (const Row& row : rows) {
    Bytes state(HAPTON_HID_STATE_BYTES);
    hapton_hid_state(&device_, &measured_, now_us(), state.data());
    state[1] = static_cast<std::uint8_t>(row.bits);
    ASSERT_TRUE(backend_.decode(state, now_ns_, reading_));
    EXPECT_EQ(reading_.status, row.status) << row.bits;
    EXPECT_EQ(reading_.is_calibrated, (row.bits & kIsCalibrated) != 0) << row.bits;
  }
}

}  // namespace
}  // namespace hapton
