// Uses a stand-in for libdrd with a point mass as the device.
#include "devices/force_dimension_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <numbers>
#include <string>

#include "devices/dhd_library.h"
#include "runtime/clock.h"
#include "tests/devices/served_device.h"
#include "tests/standins/board.h"
#include "tests/standins/paths.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

struct ForceDimension : ServedDevice {
  ScratchFolder folder;
  standin::BoardFile board{folder.path() / "board"};

  std::string library = "forcedimension/libdrd.so";

  using ServedDevice::make;
  Result<std::unique_ptr<Device>> make(const std::string& id) override {
    DeviceSettings settings;
    settings.id = id;
    return make_force_dimension(settings, {standin::library(library), warning_s});
  }
  double warning_s = 0.1;  // time from the warning to the motion
};

TEST_F(ForceDimension, LimitsDependOnTheType) {
  open();
  EXPECT_EQ(device->limits().max_force_n, 12.0);
  EXPECT_EQ(device->limits().max_torque_nm, 0.0);
  device.reset();
  board->system_type = 104;  // sigma.7
  open();
  EXPECT_EQ(device->limits().max_force_n, 20.0);
  EXPECT_EQ(device->limits().max_torque_nm, 0.4);
}

// For a sigma.7, Hapton chooses the limits that the library does not report. Force above the continuous force warms up the motors.
TEST_F(ForceDimension, ASigma7HasTheLimitsThatHaptonChooses) {
  board->system_type = 104;
  open();
  const DeviceLimits& limits = device->limits();
  EXPECT_EQ(limits.continuous_force_n, 10.0);
  EXPECT_EQ(limits.peak_s, 10.0);
  EXPECT_NEAR(limits.max_slew_n_per_s, 5000.0, 1e-6);
  EXPECT_NEAR(limits.max_torque_slew_nm_per_s, 100.0, 1e-9);
  EXPECT_EQ(limits.max_stiffness_n_per_m, 2000.0);
  EXPECT_EQ(limits.max_speed_m_per_s, 5.0);
  EXPECT_EQ(limits.workspace_min_m, -limits.workspace_max_m);
  EXPECT_GT(limits.workspace_max_m.minCoeff(), 0.05);
}

TEST_F(ForceDimension, AnUnknownTypeGetsLowLimitsAndIsReported) {
  board->system_type = 999;
  testing::internal::CaptureStderr();
  open();
  EXPECT_EQ(device->limits().max_force_n, 3.0);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("type 999"));
}

TEST_F(ForceDimension, ItsAxesBecomeThoseOfTheWorld) {
  board->follows_hand = 0;
  const double towards_user = 0.01, right = 0.02, up = 0.03;
  board->hand_m[0] = towards_user;
  board->hand_m[1] = right;
  board->hand_m[2] = up;
  board->buttons = 1;
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_TRUE(runner.sample().p_WD.isApprox(Vec3(right, up, towards_user), 1e-12));
  EXPECT_EQ(runner.sample().buttons, 1U);
  const Wrench push = {.force_n = Vec3(0.1, 0.2, 0.3)};
  EXPECT_TRUE(serve_until([&] { return std::abs(board->force[1] - 0.1) < 1e-12; }, push));
  EXPECT_NEAR(board->force[2], 0.2, 1e-12);
  EXPECT_NEAR(board->force[0], 0.3, 1e-12);
}

TEST_F(ForceDimension, ItsOrientationTurnsWithTheAxes) {
  board->turn_rad[2] = std::numbers::pi / 2;  // about the device's z, which points up
  open();
  ASSERT_TRUE(serve_until_ready());
  const Quat expected(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY()));
  EXPECT_LT(runner.sample().q_WT.angularDistance(expected), 1e-9);
}

TEST_F(ForceDimension, TorquesTurnWithTheAxesToo) {
  board->system_type = 104;
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_TRUE(serve_until([&] { return std::abs(board->torque[2] - 0.1) < 1e-12; }, {.torque_nm = Vec3(0, 0.1, 0)}));
}

TEST_F(ForceDimension, TheFirmwaresWatchdogIsSet) {
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_EQ(board->watchdog, 255);
  EXPECT_EQ(board->enabled, 1);
}

TEST_F(ForceDimension, TimeGuardAndSaturationAreNoErrors) {
  open();
  for (const int result : {1, 2}) {
    board->result = result;
    const std::uint64_t ticks = board->ticks;
    ASSERT_TRUE(serve_until([&] { return board->ticks > ticks + 50 && device->status() == DeviceStatus::ready; }));
  }
  EXPECT_EQ(board->closed, 0U);
}

TEST_F(ForceDimension, CalibratesByMotorAfterHavingSaidSo) {
  board->calibration = 1;
  testing::internal::CaptureStderr();
  const std::int64_t begin_ns = SteadyClock().now_ns();
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_GE(SteadyClock().now_ns() - begin_ns, static_cast<std::int64_t>(1e9 * warning_s)) << "it moved before the warning time had passed";
  EXPECT_EQ(board->moved_by_itself, 1);
  EXPECT_EQ(board->pushed_unasked, 0U);
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("move by itself"));
  EXPECT_THAT(log, HasSubstr("is calibrated"));
}

TEST_F(ForceDimension, ThatCannotCalibrateExertsNoForce) {
  board->calibration = 1;
  board->updates_until_good = 0;
  open();
  ASSERT_TRUE(serve_until([&] { return board->moved_by_itself == 1; }));
  const std::uint64_t ticks = board->ticks;
  ASSERT_TRUE(serve_until([&] { return board->ticks > ticks + 100; }, {.force_n = Vec3(0, 0, 2)}));
  EXPECT_EQ(device->status(), DeviceStatus::calibrating);
  EXPECT_EQ(board->pushed_ticks, 0U);
  EXPECT_EQ(board->kept_forces, 0);
}

// The library keeps only the reason of its last call.
TEST_F(ForceDimension, AFailedCalibrationIsReportedWithItsOwnReason) {
  board->calibration = 1;
  board->updates_until_good = 0;
  testing::internal::CaptureStderr();
  open();
  const bool was_stopped = serve_until([&] { return board->kept_forces == 0 && board->ticks > 100; });
  device.reset();
  const std::string log = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(was_stopped);
  EXPECT_THAT(log, HasSubstr("stand-in omega could not calibrate: the stand-in's own words; remove obstacles and start again"));
}

TEST_F(ForceDimension, OneThatMovesAndIsNotCalibratedThenExertsNoForce) {
  board->calibration = 1;
  board->updates_until_good = 0;
  board->claims_success = 1;
  testing::internal::CaptureStderr();
  open();
  const bool was_stopped = serve_until([&] { return board->kept_forces == 0 && board->ticks > 200; }, {.force_n = Vec3(0, 0, 2)});
  const DeviceStatus status = device->status();
  device.reset();
  const std::string log = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(was_stopped);
  EXPECT_EQ(status, DeviceStatus::calibrating);
  EXPECT_EQ(board->pushed_ticks, 0U);
  EXPECT_EQ(board->enabled, 0);
  EXPECT_THAT(log, HasSubstr("has moved to calibrate, but is still not calibrated; start again"));
}

// The program ends before the device has moved; after that the device does not move.
TEST_F(ForceDimension, TheEndOfTheProgramEndsTheWarning) {
  board->calibration = 1;
  warning_s = 1e6;
  open();
  device.reset();
  EXPECT_EQ(board->moved_by_itself, 0);
  EXPECT_EQ(board->kept_forces, -1);
  EXPECT_EQ(board->closed, 1U);
}

// libdhd cannot move the arm, and knows only that the device waits in its RESET mode.
TEST_F(ForceDimension, WithoutLibdrdItExertsNoForceUntilSomebodyHasCalibratedIt) {
  library = "dhd_alone/libdhd.so";
  board->calibration = 2;
  const Wrench push = {.force_n = Vec3(0, 0, 2)};
  testing::internal::CaptureStderr();
  open();
  ASSERT_TRUE(serve_until([&] { return board->ticks > 300; }, push));
  EXPECT_EQ(device->status(), DeviceStatus::calibrating);
  EXPECT_EQ(board->pushed_ticks, 0U);
  EXPECT_EQ(board->enabled, 0);
  board->calibration = 0;
  ASSERT_TRUE(serve_until_ready());
  EXPECT_TRUE(serve_until([&] { return board->pushed_ticks > 0; }, push));
  EXPECT_EQ(board->enabled, 1);
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("rest position"));
  EXPECT_THAT(log, HasSubstr("is calibrated"));
}

TEST_F(ForceDimension, AFalconIsCalibratedByHand) {
  board->system_type = dhd::kFalcon;
  board->calibration = 2;
  board->updates_until_good = 50;
  testing::internal::CaptureStderr();
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_EQ(board->moved_by_itself, 0);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("pull the grip all the way out"));
  EXPECT_EQ(device->limits().max_force_n, 8.0);
  EXPECT_EQ(board->watchdog, 255);
  EXPECT_EQ(board->enabled, 1);
}

TEST_F(ForceDimension, AFalconThatNobodyCalibratesExertsNoForce) {
  board->system_type = dhd::kFalcon;
  board->calibration = 2;
  board->updates_until_good = 0;
  open();
  const Wrench push = {.force_n = Vec3(0, 0, 2)};
  ASSERT_TRUE(serve_until([&] { return board->calibration_updates > 100; }, push));
  EXPECT_EQ(device->status(), DeviceStatus::calibrating);
  EXPECT_EQ(board->pushed_ticks, 0U);
  EXPECT_EQ(board->enabled, 0);
}

TEST_F(ForceDimension, AFalconThatIsUnpluggedWhileItWaitsForTheHandIsFoundAgain) {
  board->system_type = dhd::kFalcon;
  board->calibration = 2;
  board->updates_until_good = 0;
  open();
  ASSERT_TRUE(serve_until([&] { return board->calibration_updates > 20; }, {}));
  board->is_plugged = 0;
  ASSERT_TRUE(serve_until([&] { return device->status() == DeviceStatus::away; }, {}));
  board->updates_until_good = 50;
  board->is_plugged = 1;
  EXPECT_TRUE(serve_until_ready());
}

TEST_F(ForceDimension, AForceThatTheFirmwareReleasedIsReportedWithItsCauseAndReturns) {
  open();
  const Wrench push = {.force_n = Vec3(0, 0, 2)};
  ASSERT_TRUE(serve_until_ready());
  ASSERT_TRUE(serve_until([&] { return board->force[0] == 2.0; }, push));
  testing::internal::CaptureStderr();
  board->force_off_cause = 2;
  EXPECT_TRUE(serve_until([&] { return board->force_off_cause == 0; }, push));
  EXPECT_TRUE(serve_until([&] { return board->force[0] == 2.0; }, push));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("velocity threshold"));
}

TEST_F(ForceDimension, AForceThatThePersonSwitchedOffStaysOff) {
  open();
  ASSERT_TRUE(serve_until_ready());
  const Wrench push = {.force_n = Vec3(0, 0, 2)};
  ASSERT_TRUE(serve_until([&] { return board->force[0] == 2.0; }, push));
  board->force_off_cause = 1;
  ASSERT_TRUE(serve_until([&] { return board->force[0] == 0.0; }, push));
  board->largest_force = 0.0;
  const std::uint64_t ticks = board->ticks;
  ASSERT_TRUE(serve_until([&] { return board->ticks > ticks + 300; }, push));
  EXPECT_EQ(board->force_off_cause, 1);
  EXPECT_EQ(board->largest_force, 0.0) << "no ramp runs meanwhile, so that the force returns from zero";
  board->force_off_cause = 0;
  ASSERT_TRUE(serve_until([&] { return board->force[0] == 2.0; }, push));
}

TEST_F(ForceDimension, AnErrorInsteadOfACountIsNoDevice) {
  board->is_plugged = -1;
  const auto made = make("0");
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().what, HasSubstr("finds 0 devices"));
}

TEST_F(ForceDimension, APositionThatIsNotFiniteReachesTheGovernor) {
  open();
  ASSERT_TRUE(serve_until_ready());
  board->follows_hand = 0;
  board->hand_m[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(serve_until([&] { return !runner.sample().p_WD.allFinite(); }));
  EXPECT_EQ(device->status(), DeviceStatus::ready);
  board->hand_m[1] = 0.0;
  EXPECT_TRUE(serve_until([&] { return runner.sample().p_WD.allFinite(); }));
}

// The device reports a matrix of half the length, or of NaN: the stylus keeps its orientation, and its position still follows.
TEST_F(ForceDimension, AnOrientationThatIsNoRotationIsLeftOut) {
  board->follows_hand = 0;
  board->turn_rad[2] = std::numbers::pi / 2;
  open();
  ASSERT_TRUE(serve_until_ready());
  const Quat before = runner.sample().q_WT;
  board->turn_rad[2] = 0.0;
  board->frame_scale = 0.5;
  board->hand_m[2] = 0.01;
  ASSERT_TRUE(serve_until([&] { return runner.sample().p_WD.y() == 0.01; }));
  EXPECT_EQ(runner.sample().q_WT.coeffs(), before.coeffs());
  board->frame_scale = std::numeric_limits<double>::quiet_NaN();
  board->hand_m[2] = 0.02;
  ASSERT_TRUE(serve_until([&] { return runner.sample().p_WD.y() == 0.02; }));
  EXPECT_EQ(runner.sample().q_WT.coeffs(), before.coeffs());
  board->frame_scale = 1.0;
  EXPECT_TRUE(serve_until([&] { return runner.sample().q_WT.angularDistance(Quat::Identity()) < 1e-9; }));
}

TEST_F(ForceDimension, CallsThatFailAgainAndAgainAreAnUnpluggedCable) {
  open();
  for (const int call : {1, 2}) {  // orientation, force
    ASSERT_TRUE(serve_until_ready());
    testing::internal::CaptureStderr();
    board->failing_call = call;
    const bool is_away =
        serve_until([&] { return device->status() == DeviceStatus::away && board->closed >= static_cast<unsigned>(call); });
    board->failing_call = 0;
    const std::string log = testing::internal::GetCapturedStderr();
    ASSERT_TRUE(is_away) << call;
    EXPECT_THAT(log, HasSubstr("is disconnected (the stand-in's own words); trying to reconnect"));
  }
  EXPECT_TRUE(serve_until_ready());
}

// The status is requested only ten times a second, and is not necessary to drive the device.
TEST_F(ForceDimension, AStatusThatCannotBeReadChangesNothing) {
  open();
  ASSERT_TRUE(serve_until_ready());
  board->failing_call = 3;  // status
  const std::uint64_t ticks = board->ticks;
  EXPECT_TRUE(serve_until([&] { return board->ticks > ticks + 250 && board->force[0] == 2.0; }, {.force_n = Vec3(0, 0, 2)}));
  EXPECT_EQ(board->closed, 0U);
}

TEST_F(ForceDimension, OneThatReportsToBeDisconnectedIsAwayThoughItReplies) {
  open();
  ASSERT_TRUE(serve_until_ready());
  testing::internal::CaptureStderr();
  board->is_connected = 0;
  const bool is_away = serve_until([&] { return device->status() == DeviceStatus::away && board->closed >= 1U; });
  board->is_connected = 1;
  const std::string log = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(is_away);
  EXPECT_THAT(log, HasSubstr("is disconnected (it reports that it is not connected)"));
  EXPECT_TRUE(serve_until_ready());
}

TEST_F(ForceDimension, AForceThatIsOffWithoutPowerIsReportedAsThat) {
  open();
  ASSERT_TRUE(serve_until_ready());
  testing::internal::CaptureStderr();
  board->has_power = 0;
  board->force_off_cause = 1;
  const std::uint64_t ticks = board->ticks;
  const bool was_checked = serve_until([&] { return board->ticks > ticks + 250; }, {.force_n = Vec3(0, 0, 2)});
  const std::string log = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(was_checked);
  EXPECT_THAT(log, HasSubstr("has released its force: its power is off; it returns by itself"));
}

TEST_F(ForceDimension, UnpluggedInContactItIsAwayAndFoundAgain) {
  open();
  const Wrench push = {.force_n = Vec3(0, 0, 2)};
  ASSERT_TRUE(serve_until_ready());
  ASSERT_TRUE(serve_until([&] { return board->force[0] == 2.0; }, push));
  EXPECT_TRUE(ramps_up(
      [&](std::uint64_t attempt) {
        board->is_plugged = 0;
        ASSERT_TRUE(serve_until([&] { return device->status() == DeviceStatus::away && board->closed == attempt; }, push));
        board->largest_force = 0.0;
        board->is_plugged = 1;
        ASSERT_TRUE(serve_until([&] { return device->status() == DeviceStatus::ready; }, push));
      },
      [&] { return board->largest_force < 0.5; }));
  EXPECT_TRUE(serve_until([&] { return board->force[0] == 2.0; }, push));
  EXPECT_EQ(board->wrong_calls, 0U);
}

TEST_F(ForceDimension, AServoThatDiesLeavesNoForce) {
  open();
  ASSERT_TRUE(serve_until_ready());
  ASSERT_TRUE(serve_until([&] { return board->force[0] == 2.0; }, {.force_n = Vec3(0, 0, 2)}));
  EXPECT_TRUE(DeviceRunner::wait_until([&] { return board->force[0] == 0.0; }));
}

TEST_F(ForceDimension, AMissingDeviceOrAnotherNumberIsReported) {
  EXPECT_THAT(make("1").error().what, HasSubstr("is number 1"));
  EXPECT_THAT(make("left").error().what, HasSubstr("not 'left'"));
  EXPECT_THAT(make("-1").error().what, HasSubstr("not '-1'"));
  EXPECT_THAT(make("31").error().what, HasSubstr("is number 31"));
  EXPECT_THAT(make("32").error().what, HasSubstr("not '32'"));
  EXPECT_THAT(make("0x").error().what, HasSubstr("not '0x'"));
  board->is_plugged = 0;
  EXPECT_THAT(make().error().what, HasSubstr("finds 0 devices"));
}

TEST_F(ForceDimension, ADeviceInUseIsReported) {
  open();
  const std::string what = make().error().what;
  EXPECT_THAT(what, HasSubstr("another program"));
  EXPECT_THAT(what, HasSubstr("the stand-in's own words"));
}

TEST_F(ForceDimension, TheServosSideUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_EQ(DeviceRunner::count_heap_use(*device), 0U);
}

// After its watchdog, the firmware keeps the force off until it is enabled again.
TEST_F(ForceDimension, AForceThatItsWatchdogReleasedReturns) {
  open();
  const Wrench push = {.force_n = Vec3(0, 0, 2)};
  ASSERT_TRUE(serve_until_ready());
  ASSERT_TRUE(serve_until([&] { return board->force[0] == 2.0; }, push));
  testing::internal::CaptureStderr();
  board->force_off_cause = 3;
  EXPECT_TRUE(serve_until([&] { return board->force_off_cause == 0; }, push));
  EXPECT_TRUE(serve_until([&] { return board->force[0] == 2.0; }, push));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("its watchdog"));
}

// Hapton has the limits of the device that was there before, which may be wrong for the other one.
TEST_F(ForceDimension, AnotherDeviceInItsPlaceIsNotDriven) {
  open();
  const Wrench push = {.force_n = Vec3(0, 0, 2)};
  ASSERT_TRUE(serve_until_ready());
  board->is_plugged = 0;
  ASSERT_TRUE(serve_until([&] { return device->status() == DeviceStatus::away && board->closed == 1U; }, push));
  board->largest_force = 0.0;
  board->system_type = dhd::kFalcon;
  board->is_plugged = 1;
  ASSERT_TRUE(serve_until([&] { return board->closed >= 3U; }, push)) << "it is opened, and closed again";
  EXPECT_EQ(device->status(), DeviceStatus::away);
  EXPECT_EQ(board->largest_force, 0.0);
  board->system_type = 33;
  EXPECT_TRUE(serve_until_ready());
}

// A device of the same type, but another arm.
TEST_F(ForceDimension, OneOfAnotherSerialNumberInItsPlaceIsNotDriven) {
  open();
  EXPECT_EQ(device->condition().serial, "42");
  ASSERT_TRUE(serve_until_ready());
  board->is_plugged = 0;
  ASSERT_TRUE(serve_until([&] { return device->status() == DeviceStatus::away && board->closed == 1U; }));
  board->serial = 43;
  board->largest_force = 0.0;
  board->is_plugged = 1;
  ASSERT_TRUE(serve_until([&] { return board->closed >= 3U; }, {.force_n = Vec3(0, 0, 2)}));
  EXPECT_EQ(device->status(), DeviceStatus::away);
  EXPECT_EQ(board->largest_force, 0.0);
  board->serial = 42;
  EXPECT_TRUE(serve_until_ready());
}

TEST_F(ForceDimension, ASerialNumberThatItDoesNotTellIsEmpty) {
  board->serial = -1;
  open();
  EXPECT_EQ(device->condition().serial, "");
}

TEST_F(ForceDimension, EndsWithoutAForce) {
  open();
  ASSERT_TRUE(serve_until_ready());
  ASSERT_TRUE(serve_until([&] { return board->force[0] == 2.0; }, {.force_n = Vec3(0, 0, 2)}));
  device.reset();
  EXPECT_EQ(board->force[0], 0.0);
  EXPECT_EQ(board->closed, 1U);
}

}  // namespace
}  // namespace hapton
