// Uses a stand-in for libHD with a point mass as the device, with its own scheduler thread, clock and errors.
#include "devices/open_haptics_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <memory>
#include <numbers>

#include "runtime/clock.h"
#include "tests/devices/served_device.h"
#include "tests/standins/board.h"
#include "tests/standins/paths.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/system_call_guard.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct OpenHaptics : ServedDevice {
  ScratchFolder folder;
  standin::BoardFile board{folder.path() / "board"};

  using ServedDevice::make;
  Result<std::unique_ptr<Device>> make(const std::string& id) override {
    DeviceSettings settings;
    settings.id = id;
    return make_open_haptics(settings, standin::library("openhaptics/libHD.so"));
  }
};

TEST_F(OpenHaptics, LimitsAreTheDevicesOwn) {
  board->max_force_n = 7.5;
  open();
  const DeviceLimits& limits = device->limits();
  EXPECT_DOUBLE_EQ(limits.max_force_n, 7.5);
  EXPECT_DOUBLE_EQ(limits.continuous_force_n, 0.88);
  EXPECT_DOUBLE_EQ(limits.max_stiffness_n_per_m, 1260.0);
  // 160 x 120 x 70 mm, with the origin in the middle.
  EXPECT_TRUE(limits.workspace_max_m.isApprox(Vec3(0.08, 0.06, 0.035)));
  EXPECT_TRUE(limits.workspace_min_m.isApprox(Vec3(-0.08, -0.06, -0.035)));
  EXPECT_EQ(limits.max_torque_nm, 0.0);
}

TEST_F(OpenHaptics, LimitsThatTheDeviceDoesNotReportAreThoseOfTheDocument) {
  board->max_force_n = 7.5;
  open();
  EXPECT_NEAR(device->limits().max_slew_n_per_s, 1875.0, 1e-6) << "full force in 4 ms";
  EXPECT_EQ(device->limits().peak_s, 5.0);
  EXPECT_EQ(device->limits().max_speed_m_per_s, 5.0);
}

TEST_F(OpenHaptics, AStiffnessThatNoDeviceHasIsBounded) {
  for (const auto& [reported, used] : {std::pair{0.15, 150.0}, {0.01, 100.0}, {50.0, 5000.0}}) {
    board->max_stiffness = reported;
    open();
    EXPECT_NEAR(device->limits().max_stiffness_n_per_m, used, 1e-9) << reported;
    device.reset();
  }
}

// In DeviceLimits, zero would mean that the motors may exert the largest force for ever.
TEST_F(OpenHaptics, AContinuousForceThatNoDeviceHasIsAQuarterOfTheMaximum) {
  board->max_force_n = 8.0;
  for (const double reported_n : {0.0, -0.88, std::numeric_limits<double>::quiet_NaN()}) {
    board->continuous_force_n = reported_n;
    open();
    EXPECT_EQ(device->limits().continuous_force_n, 2.0) << reported_n;
    device.reset();
  }
  board->continuous_force_n = 9.0;
  open();
  EXPECT_EQ(device->limits().continuous_force_n, 8.0);
}

TEST_F(OpenHaptics, SaysWhatItIs) {
  open();
  ASSERT_TRUE(serve_until_ready());
  const DeviceCondition condition = device->condition();
  EXPECT_EQ(condition.model, "Stand-in Touch");
  EXPECT_EQ(condition.serial, "SN-0042");
  EXPECT_EQ(condition.firmware, "4.5");
  EXPECT_TRUE(condition.is_calibrated);
  EXPECT_DOUBLE_EQ(condition.motor_temperature, 0.2);
  board->motor_temperature = 0.9;
  EXPECT_TRUE(serve_until([&] { return device->condition().motor_temperature == 0.9; })) << "the warmest motor counts";
}

TEST_F(OpenHaptics, WhatItDoesNotSayOfItselfIsLeftOut) {
  board->has_texts = 0;
  testing::internal::CaptureStderr();
  open();
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("OpenHaptics: unknown model, serial ?, firmware ?, at most"));
  EXPECT_EQ(device->condition().model, "unknown model");
  EXPECT_EQ(device->condition().serial, "");
  EXPECT_EQ(device->condition().firmware, "");
}

TEST_F(OpenHaptics, ATemperatureThatIsNoNumberIsLeftOut) {
  board->motor_temperature = std::numeric_limits<double>::quiet_NaN();
  open();
  EXPECT_TRUE(serve_until([&] { return device->condition().motor_temperature == 0.1; })) << "that of the other motors";
}

// Each tick reads only as many errors as it has time for. The force stays off meanwhile, and returns afterwards.
TEST_F(OpenHaptics, ALibraryThatReportsErrorsWithoutEndHoldsNoTickUp) {
  open();
  const Wrench push = {.force_n = Vec3(0, 0, 2)};
  ASSERT_TRUE(serve_until_ready());
  ASSERT_TRUE(serve_until([&] { return board->force[2] == 2.0; }, push));
  board->endless_error = 0x200;  // HD_WARM_MOTORS
  ASSERT_TRUE(serve_until([&] { return board->force[2] == 0.0; }, push));
  const std::uint64_t ticks = board->ticks;
  EXPECT_TRUE(serve_until([&] { return board->ticks > ticks + 50; }, push));
  EXPECT_EQ(board->force[2], 0.0);
  board->endless_error = 0;
  EXPECT_TRUE(serve_until([&] { return board->force[2] == 2.0; }, push));
}

TEST_F(OpenHaptics, MillimetresBecomeMetresFromTheMiddleOfTheWorkspace) {
  board->follows_hand = 0;
  const double at_m[] = {0.010, 0.050, -0.003};
  for (std::size_t axis = 0; axis < 3; ++axis) board->hand_m[axis] = at_m[axis];
  board->buttons = 0x13;  // bit 4 is not a button
  open();
  ASSERT_TRUE(serve_until_ready());
  const DeviceSample sample = runner.sample();
  EXPECT_TRUE(sample.p_WD.isApprox(Vec3(0.010, 0.030, -0.003), 1e-12)) << sample.p_WD.transpose();
  EXPECT_EQ(sample.buttons, 3U);
}

TEST_F(OpenHaptics, TheTransformIsReadColumnByColumn) {
  board->turn_rad[2] = std::numbers::pi / 2;
  open();
  ASSERT_TRUE(serve_until_ready());
  // A quarter turn about z takes x to y; transposed it would take it to -y.
  EXPECT_TRUE((runner.sample().q_WT * Vec3::UnitX()).isApprox(Vec3::UnitY(), 1e-9));
}

TEST_F(OpenHaptics, ForcesArriveInNewtonsAfterTheRampAndNeverFaster) {
  constexpr double kTickS = 1e-3;  // of the library's scheduler
  EXPECT_TRUE(ramps_up(
      [&](std::uint64_t) {
        device.reset();
        open();
        ASSERT_TRUE(serve_until_ready());
        board->largest_step = 0.0;
        ASSERT_TRUE(serve_until([&] { return std::abs(board->force[1] - 1.5) < 1e-12; }, {.force_n = Vec3(0, 1.5, 0)}));
        ASSERT_LT(device->limits().max_slew_n_per_s * kTickS, 1.5) << "a jump to the whole force would pass";
      },
      [&] { return board->largest_step <= device->limits().max_slew_n_per_s * kTickS; }));
  EXPECT_EQ(board->force[0], 0.0);
  EXPECT_LE(board->largest_force, 1.5 + 1e-12);
}

TEST_F(OpenHaptics, TorquesArriveInMillinewtonMetresWhereThereAreMotorsForThem) {
  board->output_dof = 6;
  open();
  ASSERT_GT(device->limits().max_torque_nm, 0.0);
  ASSERT_TRUE(serve_until_ready());
  EXPECT_TRUE(serve_until([&] { return std::abs(board->torque[2] - 50.0) < 1e-9; }, {.torque_nm = Vec3(0, 0, 0.05)}));
}

TEST_F(OpenHaptics, OneFrameATickOnTheSchedulersThreadAlone) {
  open();
  ASSERT_TRUE(serve_until_ready());
  ASSERT_TRUE(serve_until([&] { return board->ticks > 200; }, {.force_n = Vec3(1, 0, 0)}));
  device.reset();
  EXPECT_EQ(board->wrong_calls, 0U);
  EXPECT_EQ(board->opened, board->closed);
  EXPECT_EQ(board->is_running, 0);
}

TEST_F(OpenHaptics, TheUsualNamesAreTriedOneAfterTheOther) {
  for (const int known : {0, 1, 2}) {
    board->known_name = known;
    open();
    device.reset();
  }
  EXPECT_EQ(board->opened, 3U);
}

TEST_F(OpenHaptics, ErrorsOfANameThatFailedAreNotThoseOfTheNext) {
  board->errors_a_refusal = 3;
  board->known_name = 1;
  open();
  EXPECT_EQ(board->opened, 1U);
}

TEST_F(OpenHaptics, ANameThatWasGivenIsTheOnlyOneTried) {
  board->known_name = 3;
  ASSERT_TRUE(make("Left Hand"));
  EXPECT_FALSE(make());
  board->known_name = 0;
  const auto made = make("Left Hand");
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().what, HasSubstr("'Left Hand'"));
  EXPECT_THAT(made.error().what, Not(HasSubstr("Default")));
}

TEST_F(OpenHaptics, AFailureIsReportedByNameWithTheLibrarysTextAndARemedy) {
  board->open_error = 0x302;
  const std::string what = make().error().what;
  EXPECT_THAT(what, HasSubstr("HD_COMM_ERROR (0x302)"));
  EXPECT_THAT(what, HasSubstr("the stand-in's own words"));
  EXPECT_THAT(what, HasSubstr("cable"));
  EXPECT_THAT(what, Not(HasSubstr("\n")));
  board->open_error = 0x600;
  EXPECT_THAT(make().error().what, HasSubstr("licence"));
  board->open_error = 0x301;
  EXPECT_THAT(make().error().what, HasSubstr("another program"));
}

TEST_F(OpenHaptics, ADeviceWithImpossibleDataIsRejected) {
  board->max_force_n = 0.0;
  EXPECT_THAT(make().error().what, HasSubstr("impossible workspace"));
  EXPECT_THAT(make().error().what, HasSubstr("0.16 x 0.12 x 0.07 m and 0 N"));
  for (const double reported_n : {-1.0, 100.5, std::numeric_limits<double>::quiet_NaN()}) {
    board->max_force_n = reported_n;
    EXPECT_FALSE(make()) << reported_n;
  }
  board->max_force_n = 100.0;
  for (const double low_mm : {-std::numeric_limits<double>::infinity(), 75.0}) {
    board->box_low_mm = low_mm;
    EXPECT_FALSE(make()) << low_mm;
  }
  EXPECT_EQ(board->opened, board->closed);
  board->box_low_mm = -80.0;
  EXPECT_TRUE(make());
}

TEST_F(OpenHaptics, ExertsNoForceUntilItIsCalibratedAndSaysWhatToDo) {
  board->calibration = 2;
  board->calibration_style = 4;  // inkwell
  testing::internal::CaptureStderr();
  open();
  ASSERT_TRUE(serve_until([&] { return board->ticks > 250; }, {.force_n = Vec3(0, 2, 0)}));
  EXPECT_EQ(device->status(), DeviceStatus::calibrating);
  EXPECT_FALSE(device->condition().is_calibrated);
  EXPECT_EQ(board->pushed_ticks, 0U);
  // The stylus has been put into the inkwell: the device requests its calibration update.
  board->calibration = 1;
  EXPECT_TRUE(serve_until_ready());
  EXPECT_EQ(board->last_update_style, 4);
  EXPECT_TRUE(serve_until([&] { return board->force[1] > 1.0; }, {.force_n = Vec3(0, 2, 0)}));
  EXPECT_EQ(board->pushed_unasked, 0U);
  device.reset();
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("put the stylus into its inkwell"));
}

TEST_F(OpenHaptics, TheNeutralPoseIsTakenWhenTheButtonSaysSo) {
  board->calibration = 2;
  board->calibration_style = 1;
  open();
  ASSERT_TRUE(serve_until([&] { return board->ticks > 250; }));
  EXPECT_EQ(board->calibration_updates, 0U) << "only the person knows the pose";
  board->buttons = 1;
  EXPECT_TRUE(serve_until_ready());
  EXPECT_EQ(board->last_update_style, 1);
}

TEST_F(OpenHaptics, AForceErrorReleasesTheForceForAMomentAndItRampsUpAgain) {
  open();
  const Wrench push = {.force_n = Vec3(0, 0, 2)};
  ASSERT_TRUE(serve_until_ready());
  ASSERT_TRUE(serve_until([&] { return board->force[2] == 2.0; }, push));
  board->error_once = 0x200;
  EXPECT_TRUE(serve_until([&] { return board->force[2] == 0.0 && device->status() == DeviceStatus::ready; }, push));
  EXPECT_TRUE(serve_until([&] { return board->force[2] == 2.0; }, push));
}

TEST_F(OpenHaptics, MotorsThatStayWarmGetNoForceAndAreReported) {
  open();
  ASSERT_TRUE(serve_until_ready());
  testing::internal::CaptureStderr();
  board->error_each_tick = 0x200;
  const Wrench push = {.force_n = Vec3(0, 0, 2)};
  // A tick that began before the errors may still push.
  const std::uint64_t before = board->ticks;
  ASSERT_TRUE(serve_until([&] { return board->force[2] == 0.0 && board->ticks > before + 100; }, push));
  const std::uint64_t pushed = board->pushed_ticks;
  const std::uint64_t ticks = board->ticks;
  ASSERT_TRUE(serve_until([&] { return board->ticks > ticks + 300; }, push));
  EXPECT_EQ(board->pushed_ticks, pushed);
  device.reset();
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("HD_WARM_MOTORS"));
}

TEST_F(OpenHaptics, UnpluggedInContactItIsAwayAndFoundAgain) {
  open();
  const Wrench push = {.force_n = Vec3(0, 0, 2)};
  ASSERT_TRUE(serve_until_ready());
  ASSERT_TRUE(serve_until([&] { return board->force[2] == 2.0; }, push));
  const Vec3 last = runner.sample().p_WD;
  EXPECT_TRUE(ramps_up(
      [&](std::uint64_t attempt) {
        board->is_plugged = 0;
        ASSERT_TRUE(serve_until([&] { return device->status() == DeviceStatus::away; }, push));
        if (attempt == 1) {
          EXPECT_LT((runner.sample().p_WD - last).norm(), 0.05) << "the last sample stays";
        }
        ASSERT_TRUE(serve_until([&] { return board->closed == attempt; }, push));
        board->largest_force = 0.0;
        board->is_plugged = 1;
        ASSERT_TRUE(serve_until([&] { return device->status() == DeviceStatus::ready; }, push));
      },
      [&] { return board->largest_force < 0.5; }));
  EXPECT_TRUE(serve_until([&] { return board->force[2] == 2.0; }, push));
  EXPECT_EQ(board->wrong_calls, 0U);
}

TEST_F(OpenHaptics, AnotherOneOfTheSameModelInItsPlaceIsNotDriven) {
  open();
  const Wrench push = {.force_n = Vec3(0, 0, 2)};
  ASSERT_TRUE(serve_until_ready());
  board->is_plugged = 0;
  ASSERT_TRUE(serve_until([&] { return device->status() == DeviceStatus::away && board->closed == 1U; }, push));
  testing::internal::CaptureStderr();
  board->largest_force = 0.0;
  board->is_another = 1;
  board->is_plugged = 1;
  EXPECT_TRUE(serve_until([&] { return board->closed >= 3U || device->status() == DeviceStatus::ready; }, push));
  EXPECT_EQ(device->status(), DeviceStatus::away);
  EXPECT_EQ(board->largest_force, 0.0);
  board->is_another = 0;
  EXPECT_TRUE(serve_until_ready());
  device.reset();
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("another device is connected than before; connect serial SN-0042 again"));
  EXPECT_EQ(log.find("another device"), log.rfind("another device")) << "once";
}

TEST_F(OpenHaptics, AStalledSchedulerIsAwayAndRestarted) {
  open();
  ASSERT_TRUE(serve_until_ready());
  board->stands_still = 1;
  ASSERT_TRUE(serve_until([&] { return device->status() == DeviceStatus::away; }));
  ASSERT_TRUE(serve_until([&] { return board->closed == 1U; }));
  board->stands_still = 0;
  EXPECT_TRUE(serve_until_ready());
}

TEST_F(OpenHaptics, ASlowDeviceSlowsNoOther) {
  open();
  ASSERT_TRUE(serve_until_ready());
  board->slow_us = 20'000;
  // A read that waited for the device would never be faster than its ticks; on a busy machine it may be slow now and then.
  std::uint64_t reads = 0;
  for (int attempt = 0; attempt < 20 && reads <= 10; ++attempt) {
    const std::uint64_t ticks = board->ticks;
    reads = 0;
    ASSERT_TRUE(serve_until([&] {
      ++reads;
      return board->ticks > ticks + 5;
    }));
  }
  EXPECT_GT(reads, 10U);
  EXPECT_TRUE(serve_until_ready());
}

TEST_F(OpenHaptics, TwoAtOnceGetEachItsOwnForce) {
  const standin::BoardFile second_board(folder.path() / "second", standin::kSecondBoardVariable);
  open();
  ASSERT_TRUE(serve_until([&] { return board->force[2] == 2.0; }, {.force_n = Vec3(0, 0, 2)}));
  // The second device is opened while the first is in contact.
  auto made = make("Second Device");
  ASSERT_TRUE(made) << made.error().what;
  const std::unique_ptr<Device> second = std::move(*made);
  const auto serve_both_until = [&](auto&& holds) {
    return serve_until(
        [&] {
          const std::int64_t now_ns = SteadyClock().now_ns();
          second->read(now_ns);
          second->write({.force_n = Vec3(1, 0, 0)}, now_ns);
          return holds();
        },
        {.force_n = Vec3(0, 0, 2)});
  };
  EXPECT_TRUE(serve_both_until([&] { return board->force[2] == 2.0 && second_board->force[0] == 1.0; }));
  EXPECT_EQ(board->force[0], 0.0);
  EXPECT_EQ(second_board->largest_force, 1.0);
  // One is unplugged, and the other continues.
  second_board->is_plugged = 0;
  EXPECT_TRUE(serve_both_until([&] { return second->status() == DeviceStatus::away && second_board->closed == 1U; }));
  EXPECT_TRUE(serve_both_until([&] { return device->status() == DeviceStatus::ready && board->force[2] == 2.0; }));
  EXPECT_EQ(board->wrong_calls, 0U);
  EXPECT_EQ(second_board->wrong_calls, 0U);
  ::unsetenv(standin::kSecondBoardVariable);
}

TEST_F(OpenHaptics, AServoThatDiesLeavesNoForce) {
  open();
  ASSERT_TRUE(serve_until_ready());
  ASSERT_TRUE(serve_until([&] { return board->force[2] == 2.0; }, {.force_n = Vec3(0, 0, 2)}));
  // The servo no longer writes; the device releases by itself.
  EXPECT_TRUE(DeviceRunner::wait_until([&] { return board->force[2] == 0.0; }));
}

TEST_F(OpenHaptics, AnUnpluggedDeviceIsLookedForAgainAndAgain) {
  open();
  ASSERT_TRUE(serve_until_ready());
  board->is_plugged = 0;
  ASSERT_TRUE(serve_until([&] { return device->status() == DeviceStatus::away && board->refused > 0; }));
  testing::internal::CaptureStderr();
  const std::uint64_t refused = board->refused;
  const bool was_refused = serve_until([&] { return board->refused > refused; });
  const std::string log_meanwhile = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(was_refused);
  EXPECT_EQ(device->status(), DeviceStatus::away);
  EXPECT_THAT(log_meanwhile, Not(HasSubstr("is back")));
  board->is_plugged = 1;
  EXPECT_TRUE(serve_until_ready());
}

TEST_F(OpenHaptics, TheServosSideUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_EQ(DeviceRunner::count_heap_use(*device), 0U);
}

TEST_F(OpenHaptics, TurnsOnTheForceAndTheLibrarysOwnLimits) {
  board->output_dof = 6;
  open();
  EXPECT_EQ(board->enabled, 0b1111) << "force output, force clamping, force ramping, software limit";
  EXPECT_EQ(device->limits().max_torque_nm, 0.1);
  EXPECT_NEAR(device->limits().max_torque_slew_nm_per_s, 25.0, 1e-9) << "all of the torque in 4 ms";
}

TEST_F(OpenHaptics, AfterAForceErrorTheForceComesBackLaterInSmallSteps) {
  const SteadyClock clock;
  std::int64_t paused_ns = 0;  // 100 ms is the device's pause
  open();
  const Wrench push = {.force_n = Vec3(0, 0, 2)};
  ASSERT_TRUE(serve_until_ready());
  ASSERT_TRUE(serve_until([&] { return board->force[2] == 2.0; }, push));
  EXPECT_TRUE(ramps_up(
      [&](std::uint64_t) {
        const std::int64_t error_ns = clock.now_ns();
        board->error_once = 0x200;
        ASSERT_TRUE(serve_until([&] { return board->force[2] == 0.0; }, push));
        // The release itself is one large step.
        const std::uint64_t released = board->ticks;
        ASSERT_TRUE(serve_until([&] { return board->ticks > released + 2; }, push));
        board->largest_step = 0.0;
        ASSERT_TRUE(serve_until([&] { return board->force[2] > 0.0; }, push));
        paused_ns = clock.now_ns() - error_ns;
        ASSERT_TRUE(serve_until([&] { return board->force[2] == 2.0; }, push));
      },
      [&] { return board->largest_step < 0.5 && paused_ns > 50 * kNanosecondsPerMillisecond; }));
}

// The scheduler pauses like this when another device is opened: the ticks return before the device would be opened again.
TEST_F(OpenHaptics, AfterAPauseOfTheSchedulerTheForceBeginsAtZero) {
  open();
  const Wrench push = {.force_n = Vec3(0, 0, 2)};
  ASSERT_TRUE(serve_until_ready());
  ASSERT_TRUE(serve_until([&] { return board->force[2] == 2.0; }, push));
  bool saw_small_force = false;
  EXPECT_TRUE(ramps_up(
      [&](std::uint64_t) {
        board->stands_still = 1;
        ASSERT_TRUE(serve_until([&] { return device->status() == DeviceStatus::away; }, push));
        board->stands_still = 0;
        ASSERT_TRUE(serve_until(
            [&] {
              saw_small_force = saw_small_force || board->force[2] < 1.0;
              return device->status() == DeviceStatus::ready && board->force[2] == 2.0;
            },
            push));
      },
      [&] { return saw_small_force; }));
}

TEST_F(OpenHaptics, OneThatCalibratesWhileItMovesIsUpdatedWhenItRequestsIt) {
  board->calibration = 2;
  board->calibration_style = 2;
  testing::internal::CaptureStderr();
  open();
  ASSERT_TRUE(serve_until([&] { return board->ticks > 250; }));
  EXPECT_EQ(board->calibration_updates, 0U);
  board->calibration = 1;
  EXPECT_TRUE(serve_until_ready());
  EXPECT_EQ(board->last_update_style, 2);
  device.reset();
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("move the stylus slowly through its whole workspace"));
}

}  // namespace
}  // namespace hapton
