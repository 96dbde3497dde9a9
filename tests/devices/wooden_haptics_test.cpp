#include "devices/wooden_haptics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/support/fake_hid.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;
using Bytes = FakeHid::Bytes;
using Reading = DeviceExchange::Reading;

HidDescription description(std::size_t bytes) {
  HidDescription device;
  device.path = "/dev/fake";
  device.vid = 0x1234;
  device.pid = 0x0006;
  device.serial = "W1";
  if (bytes != 0) device.layout.reports = {{0, bytes, bytes, 0}};
  return device;
}

Bytes report(const std::vector<int>& numbers) {
  Bytes bytes;
  for (const int number : numbers) {
    bytes.push_back(static_cast<std::uint8_t>(number));
    bytes.push_back(static_cast<std::uint8_t>(number >> 8));
  }
  return bytes;
}

int int16_at(const Bytes& bytes, std::size_t at) {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(bytes[at] | (bytes[at + 1] << 8)));
}

class Wooden : public ::testing::Test {
 protected:
  explicit Wooden(std::size_t bytes = 8) : hid_(description(bytes)) {}

  void open(const WoodenSettings& settings = WoodenSettings::make_default()) {
    backend_ = std::make_unique<WoodenHapticsBackend>(settings);
    open_again();
  }
  void open_again() {
    auto transport = hid_.opener()();
    const auto begun = backend_->on_open(**transport);
    ASSERT_TRUE(begun) << begun.error().what;
  }
  Reading receive(const std::vector<int>& numbers) {
    EXPECT_TRUE(backend_->decode(report(numbers), now_ns_, reading_));
    now_ns_ += kMs;
    return reading_;
  }
  Vec3 currents_ma(const Vec3& force_n, bool is_live = true) {
    Bytes into(64, 0xEE);
    into.resize(backend_->encode({.force_n = force_n}, is_live, now_ns_, into));
    now_ns_ += kMs;
    EXPECT_EQ(into.size(), 9U);
    EXPECT_EQ(into[0], 0);
    EXPECT_EQ(int16_at(into, 7), 0);
    return Vec3(int16_at(into, 1), int16_at(into, 3), int16_at(into, 5));
  }
  // The currents once gravity compensation has ramped up in full.
  Vec3 settled_currents_ma(const Vec3& force_n) {
    for (int n = 0; n < 1000; ++n) (void)currents_ma(force_n);
    return currents_ma(force_n);
  }

  FakeHid hid_;
  std::unique_ptr<WoodenHapticsBackend> backend_;
  Reading reading_;
  std::int64_t now_ns_ = kNanosecondsPerSecond;
};

WoodenSettings weightless() {
  WoodenSettings settings = WoodenSettings::make_default();
  settings.has_gravity_compensation = false;
  return settings;
}

// Counts at which both arms lean far out (b 40 degrees, c 35 degrees) and the device point is near the middle of the workspace.
const std::vector<int> kMiddleCounts = {0, 2667, 2333, 7};

TEST_F(Wooden, IsReadyAtOnceAndAtThePositionOfItsKinematics) {
  open();
  const Reading reading = receive(kMiddleCounts);
  EXPECT_EQ(reading.status, DeviceStatus::ready);
  EXPECT_TRUE(reading.is_calibrated);
  const WoodenKinematics arm{WoodenArm{}};
  const Vec3 p = arm.position_m(arm.angles_rad({0, 2667, 2333}));
  EXPECT_LT((reading.sample.p_WD - Vec3(p.y(), p.z(), p.x())).norm(), 1e-12);
  EXPECT_LT(reading.sample.p_WD.norm(), 0.1);
  EXPECT_EQ(backend_->condition().serial, "W1");
}

// W: x right, y up, z towards the person. The base's x points from the column to the person.
TEST_F(Wooden, TheAxesOfTheWorldAreThoseOfThePerson) {
  open();
  const Vec3 middle = receive(kMiddleCounts).sample.p_WD;
  const Vec3 turned_left = receive({200, 2667, 2333, 8}).sample.p_WD;
  EXPECT_GT(turned_left.x(), middle.x() + 0.005);
  const Vec3 lower_arm_up = receive({0, 2667, 2533, 9}).sample.p_WD;
  EXPECT_GT(lower_arm_up.y(), middle.y() + 0.005);
  EXPECT_GT(lower_arm_up.z(), middle.z() + 0.005);
}

TEST_F(Wooden, AForceBecomesTheCurrentsOfItsTorques) {
  open(weightless());
  receive(kMiddleCounts);
  const WoodenKinematics arm{WoodenArm{}};
  const Vec3 expected = arm.motor_current_a(arm.joint_torque_nm(arm.angles_rad({0, 2667, 2333}), Vec3(3, 1, 2)));
  EXPECT_LT((currents_ma(Vec3(1, 2, 3)) - 1e3 * expected).cwiseAbs().maxCoeff(), 0.51);
}

TEST_F(Wooden, AForceBeyondTheMotorsKeepsItsDirection) {
  WoodenSettings settings = weightless();
  settings.max_current_a = 1.0;
  open(settings);
  receive(kMiddleCounts);
  const Vec3 small = currents_ma(Vec3(0.1, 0.2, 0.3));
  const Vec3 large = currents_ma(Vec3(100, 200, 300));
  EXPECT_NEAR(large.cwiseAbs().maxCoeff(), 1000.0, 0.51);
  EXPECT_LT((large.normalized() - small.normalized()).norm(), 0.02);
}

TEST_F(Wooden, GravityCompensationRampsUpAndEndsAtOnce) {
  open();
  receive(kMiddleCounts);
  const double first_ma = currents_ma(Vec3::Zero()).norm();
  const WoodenKinematics arm{WoodenArm{}};
  const Vec3 weight = 1e3 * arm.motor_current_a(arm.gravity_torque_nm(arm.angles_rad({0, 2667, 2333})));
  EXPECT_GT(weight.norm(), 30.0);
  EXPECT_LT(first_ma, 0.05 * weight.norm());
  EXPECT_LT((settled_currents_ma(Vec3::Zero()) - weight).cwiseAbs().maxCoeff(), 0.51);
  EXPECT_EQ(currents_ma(Vec3(1, 1, 1), false), Vec3::Zero());
  EXPECT_LT(currents_ma(Vec3::Zero()).norm(), 0.05 * weight.norm()) << "it ramps up from zero again";
}

TEST_F(Wooden, GravityCompensationTakesPrecedenceWhereAMotorSaturates) {
  WoodenSettings settings = WoodenSettings::make_default();
  settings.max_current_a = 0.5;
  open(settings);
  receive(kMiddleCounts);
  const Vec3 weight = settled_currents_ma(Vec3::Zero());
  const Vec3 pushed = settled_currents_ma(Vec3(0, -500, 0));
  EXPECT_LE(pushed.cwiseAbs().maxCoeff(), 500.0);
  const WoodenKinematics arm{WoodenArm{}};
  const Vec3 push = arm.motor_current_a(arm.joint_torque_nm(arm.angles_rad({0, 2667, 2333}), Vec3(0, 0, -500)));
  EXPECT_GT((pushed - weight).norm(), 50.0);
  EXPECT_LT(((pushed - weight).normalized() - push.normalized()).norm(), 0.02);
}

TEST_F(Wooden, AForceThatIsNotFiniteOrTooLargeGivesFiniteCurrents) {
  open(weightless());
  receive(kMiddleCounts);
  EXPECT_EQ(currents_ma(Vec3(std::numeric_limits<double>::quiet_NaN(), 0, 0)), Vec3::Zero());
  EXPECT_EQ(currents_ma(Vec3(0, std::numeric_limits<double>::infinity(), 0)), Vec3::Zero());
  EXPECT_LE(currents_ma(Vec3(1e300, -1e300, 1e300)).cwiseAbs().maxCoeff(), 3000.0);
}

TEST_F(Wooden, ReportsOfAnotherLengthAreIgnored) {
  open();
  receive(kMiddleCounts);
  const Vec3 before = reading_.sample.p_WD;
  for (const std::size_t size : {0, 1, 7, 9, 14, 64}) EXPECT_FALSE(backend_->decode(Bytes(size, 0x55), now_ns_, reading_));
  EXPECT_EQ(reading_.sample.p_WD, before);
}

TEST_F(Wooden, AnyEightBytesGiveAFinitePositionAndCurrentsWithinTheLimit) {
  open();
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 50'000; ++trial) {
    Bytes bytes(8);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    ASSERT_TRUE(backend_->decode(bytes, now_ns_, reading_));
    ASSERT_TRUE(reading_.sample.p_WD.allFinite());
    ASSERT_LT(reading_.sample.p_WD.norm(), 1.0);
    ASSERT_LE(currents_ma(Vec3(5, -5, 5)).cwiseAbs().maxCoeff(), 3000.0);
  }
}

// --- the zero of the encoders ---

TEST_F(Wooden, GoesOnWhereItWasWhenItsElectronicsKeptTheirPower) {
  open();
  const Vec3 before = receive(kMiddleCounts).sample.p_WD;
  open_again();
  EXPECT_EQ(receive({0, 2700, 2300, 0}).status, DeviceStatus::ready);
  EXPECT_EQ(receive(kMiddleCounts).sample.p_WD, before);
}

TEST_F(Wooden, WithCountsResetInUseIsNotTrustedUntilItHasBeenAtRest) {
  open();
  receive(kMiddleCounts);
  open_again();
  EXPECT_EQ(receive({0, 3, -2, 0}).status, DeviceStatus::calibrating);
  EXPECT_THAT(std::string(backend_->advice()), HasSubstr("rest pose"));
  // A hand carries the arm to its rest pose: 2667 and 2333 counts back.
  for (int n = 0; n <= 1000; ++n) EXPECT_EQ(receive({0, -2667 * n / 1000, -2333 * n / 1000, n}).status, DeviceStatus::calibrating);
  int samples_at_rest = 0;
  while (receive({0, -2667, -2333, 0}).status == DeviceStatus::calibrating) ASSERT_LT(++samples_at_rest, 3000);
  EXPECT_GE(samples_at_rest, 1990) << "two seconds";
  EXPECT_LT((reading_.sample.p_WD - Vec3(0, -0.04, -0.22)).norm(), 1e-9);
  EXPECT_LT(receive({0, 0, 0, 0}).sample.p_WD.norm(), 0.1) << "where it had been when it was plugged in";
}

TEST_F(Wooden, PluggedInAgainDuringItsRestBeginsTheRestAnew) {
  open();
  receive(kMiddleCounts);
  open_again();
  for (int n = 0; n < 1500; ++n) EXPECT_EQ(receive({0, 0, 0, 0}).status, DeviceStatus::calibrating);
  open_again();
  int samples_at_rest = 0;
  while (receive({0, 0, 0, 0}).status == DeviceStatus::calibrating) ASSERT_LT(++samples_at_rest, 3000);
  EXPECT_GE(samples_at_rest, 1990);
}

TEST_F(Wooden, ThatTremblesIsNotAtRest) {
  open();
  receive(kMiddleCounts);
  open_again();
  for (int n = 0; n < 10'000; ++n) ASSERT_EQ(receive({0, n % 2 == 0 ? 0 : 4, 0, n}).status, DeviceStatus::calibrating);
}

TEST_F(Wooden, InItsRestPoseMayLoseItsCountsUnnoticed) {
  open();
  receive({5, -20, 30, 0});
  open_again();
  EXPECT_EQ(receive({0, 0, 0, 0}).status, DeviceStatus::ready);
}

// Counts were reset if they are within 50 of zero and were more than 200 before. One encoder alone shows this, in either direction.
TEST_F(Wooden, EachEncoderAloneShowsWhetherTheCountsWereReset) {
  const auto status_after = [&](const std::vector<int>& before, const std::vector<int>& after) {
    open();
    receive(before);
    open_again();
    return receive(after).status;
  };
  for (const std::size_t encoder : {0U, 1U, 2U}) {
    for (const int sign : {1, -1}) {
      const auto counts_of_one = [&](int counts) {
        std::vector<int> all = {0, 0, 0, 0};
        all[encoder] = sign * counts;
        return all;
      };
      EXPECT_EQ(status_after(counts_of_one(200), {0, 0, 0, 0}), DeviceStatus::ready) << encoder;
      EXPECT_EQ(status_after(counts_of_one(201), {0, 0, 0, 0}), DeviceStatus::calibrating) << encoder;
      EXPECT_EQ(status_after({1000, 1000, 1000, 0}, counts_of_one(50)), DeviceStatus::calibrating) << encoder;
      EXPECT_EQ(status_after({1000, 1000, 1000, 0}, counts_of_one(51)), DeviceStatus::ready) << encoder;
    }
  }
}

// --- the variants ---

TEST(WoodenVariants, AreKnownByTheirReportDescriptors) {
  for (const std::size_t bytes : {8U, 14U}) {
    FakeHid hid(description(bytes));
    WoodenHapticsBackend backend(WoodenSettings::make_default());
    ASSERT_TRUE(backend.on_open(**hid.opener()()));
    Bytes into(64);
    EXPECT_EQ(backend.encode({}, false, 0, into), bytes + 1);
    EXPECT_EQ(backend.encode({}, false, 0, std::span(into).first(bytes)), 0U);
  }
  FakeHid other(description(64));
  WoodenHapticsBackend backend(WoodenSettings::make_default());
  EXPECT_THAT(backend.on_open(**other.opener()()).error().what, HasSubstr("64 bytes; WoodenHaptics has 8 or 14"));
}

TEST(WoodenVariants, MayBeNamedWhereTheDescriptorCannotBeRead) {
  FakeHid hid(description(0));
  WoodenSettings settings = WoodenSettings::make_default();
  EXPECT_THAT(WoodenHapticsBackend(settings).on_open(**hid.opener()()).error().what, HasSubstr("report_bytes"));
  settings.report_bytes = 14;
  EXPECT_TRUE(WoodenHapticsBackend(settings).on_open(**hid.opener()()));
}

// The later edition has three more encoders, at its wrist.
class LaterWooden : public Wooden {
 protected:
  LaterWooden() : Wooden(14) {}
};

TEST_F(LaterWooden, GivesAnOrientationOnlyIfItsWristIsDescribed) {
  open();
  EXPECT_EQ(receive({0, 2667, 2333, 500, 500, 500, 0}).sample.q_WT.coeffs(), Quat::Identity().coeffs());
  WoodenSettings settings = WoodenSettings::make_default();
  settings.wrist = WoodenWrist{};
  settings.wrist->joints[0].axis = Vec3::UnitX();
  open(settings);
  // Both lower arms hang straight down; the base's x is the world's z.
  const Quat at_rest = receive({0, 0, 0, 0, 0, 0, 0}).sample.q_WT;
  const Quat turned = receive({0, 0, 0, 500, 0, 0, 0}).sample.q_WT;
  EXPECT_NEAR(at_rest.angularDistance(turned), 0.5 * 3.14159265358979, 1e-9);
  const Eigen::AngleAxisd in_world(turned * at_rest.conjugate());
  EXPECT_LT((in_world.axis() - Vec3::UnitZ()).norm(), 1e-9);
}

TEST_F(LaterWooden, AWristEncoderMayWrapAround) {
  WoodenSettings settings = WoodenSettings::make_default();
  settings.wrist = WoodenWrist{};
  open(settings);
  receive({0, 2667, 2333, 32'000, 0, 0, 0});
  open_again();
  int samples_at_rest = 0;
  while (receive({0, 0, 0, 32'000, 0, 0, 0}).status == DeviceStatus::calibrating) ASSERT_LT(++samples_at_rest, 3000);
  const Quat at_rest = reading_.sample.q_WT;
  // With 2,000 counts per turn, 500 counts are a quarter turn.
  EXPECT_NEAR(at_rest.angularDistance(receive({0, 0, 0, 32'500, 0, 0, 0}).sample.q_WT), 0.5 * 3.14159265358979, 1e-9);
  EXPECT_NEAR(at_rest.angularDistance(receive({0, 0, 0, 33'000 - 65'536, 0, 0, 0}).sample.q_WT), 3.14159265358979, 1e-6);
}

TEST_F(LaterWooden, ItsWristTurnsJointAfterJointEachInItsOwnDirection) {
  WoodenSettings settings = WoodenSettings::make_default();
  settings.wrist = WoodenWrist{};
  settings.wrist->joints[0].axis = Vec3::UnitX();
  settings.wrist->joints[1] = {.axis = Vec3::UnitY(), .counts_per_turn = 4000.0, .direction = -1.0};
  settings.wrist->joints[2].offset_rad = 0.3;
  open(settings);
  const Quat q_WT = receive({0, 2667, 2333, 100, 200, 300, 0}).sample.q_WT;
  const WoodenKinematics arm{WoodenArm{}};
  Mat3 base_axes_in_world;
  base_axes_in_world << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  const double turn_rad = 2.0 * 3.14159265358979;
  const Quat expected = Quat(base_axes_in_world) * arm.lower_arm(arm.angles_rad({0, 2667, 2333})) *
                        Quat(Eigen::AngleAxisd(turn_rad * 100 / 2000, Vec3::UnitX())) *
                        Quat(Eigen::AngleAxisd(-turn_rad * 200 / 4000, Vec3::UnitY())) *
                        Quat(Eigen::AngleAxisd(turn_rad * 300 / 2000 + 0.3, Vec3::UnitZ()));
  EXPECT_LT(q_WT.angularDistance(expected), 1e-9);
}

TEST_F(LaterWooden, SendsNoCommandBesidesItsCurrents) {
  open(weightless());
  receive({0, 2667, 2333, 1, 2, 3, 4});
  Bytes into(64, 0xEE);
  ASSERT_EQ(backend_->encode({.force_n = Vec3(1, 0, 0)}, true, now_ns_, into), 15U);
  EXPECT_NE(int16_at(into, 1), 0);
  EXPECT_THAT(Bytes(into.begin() + 7, into.begin() + 15), Each(0));
}

}  // namespace
}  // namespace hapton
