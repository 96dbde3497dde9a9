// Against a stand-in of the Haply Inverse Service.
#include "devices/haply_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "runtime/log.h"
#include "tests/devices/servo_hand.h"
#include "tests/standins/haply_service.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

struct Haply : testing::Test {
  static void SetUpTestSuite() { start_log("test"); }

  std::unique_ptr<HaplyService> service = std::make_unique<HaplyService>();
  std::unique_ptr<Device> device;
  ServoHand hand;

  Result<std::unique_ptr<Device>> make(const std::string& id = "") {
    DeviceSettings settings;
    settings.id = id + "@" + service->address();
    return make_haply(settings);
  }
  void open() {
    auto made = make();
    ASSERT_TRUE(made) << made.error().what;
    device = std::move(*made);
  }
  template <class Condition>
  bool serve_until(Condition&& holds, const Wrench& wrench = {}) {
    return hand.serve_until(*device, holds, wrench);
  }
  bool serve_until_ready() {
    return serve_until([&] { return device->status() == DeviceStatus::ready; });
  }
};

TEST_F(Haply, GivesPositionOrientationAndButtonsInTheWorld) {
  service->position_m[2] = 0.16;
  service->buttons = 3;
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_TRUE(hand.sample().p_WD.isApprox(Vec3(0, 0.01, 0), 1e-9));
  EXPECT_EQ(hand.sample().buttons, 3U);
  EXPECT_TRUE((hand.sample().q_WT * Vec3::UnitZ()).isApprox(Vec3::UnitX(), 1e-9));
  EXPECT_EQ(device->condition().serial, "049D");
  EXPECT_EQ(device->condition().firmware, "7.4.0");
}

TEST_F(Haply, IntroducesItselfOnceAndThenSendsForcesAlone) {
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_THAT(service->first_message(), HasSubstr("org.hapton:io_node"));
  EXPECT_EQ(service->connections, 1U);
}

TEST_F(Haply, ForcesArriveInTheServicesAxes) {
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_TRUE(serve_until([&] { return std::abs(service->force_n[2] - 1.0) < 1e-9; }, {.force_n = Vec3(0.5, 1.0, 0.25)}));
  EXPECT_NEAR(service->force_n[0], 0.5, 1e-9);
  EXPECT_NEAR(service->force_n[1], -0.25, 1e-9);
}

TEST_F(Haply, SendsEveryTickWithoutAForceToo) {
  open();
  ASSERT_TRUE(serve_until_ready());
  const std::uint64_t messages = service->messages;
  EXPECT_TRUE(serve_until([&] { return service->messages > messages + 50; }));
  EXPECT_EQ(service->largest_force_n, 0.0);
}

TEST_F(Haply, WorksWithoutAGrip) {
  service->has_grip = false;
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_EQ(hand.sample().q_WT.coeffs(), Quat::Identity().coeffs());
}

TEST_F(Haply, ExertsNoForceUntilItIsCalibratedAndSaysWhatToDo) {
  service->is_calibrated = false;
  testing::internal::CaptureStderr();
  open();
  const std::uint64_t messages = service->messages;
  ASSERT_TRUE(serve_until([&] { return service->messages > messages + 50; }, {.force_n = Vec3(0, 1, 0)}));
  EXPECT_EQ(device->status(), DeviceStatus::calibrating);
  EXPECT_EQ(service->largest_force_n, 0.0);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("calibrate"));
  service->is_calibrated = true;
  EXPECT_TRUE(serve_until([&] { return service->force_n[2] > 0.5; }, {.force_n = Vec3(0, 1, 0)}));
}

TEST_F(Haply, UnpluggedInContactItIsAwayAndFoundAgain) {
  open();
  const Wrench push = {.force_n = Vec3(0, 1, 0)};
  ASSERT_TRUE(serve_until([&] { return std::abs(service->force_n[2] - 1.0) < 1e-9; }, push));
  service->is_plugged = false;
  ASSERT_TRUE(serve_until([&] { return device->status() == DeviceStatus::away && service->force_n[2] == 0.0; }, push));
  service->is_plugged = true;
  EXPECT_TRUE(serve_until([&] { return device->status() == DeviceStatus::ready; }, push));
  EXPECT_TRUE(serve_until([&] { return std::abs(service->force_n[2] - 1.0) < 1e-9; }, push));
}

TEST_F(Haply, AServiceThatEndsIsLookedForAndFoundAgain) {
  open();
  ASSERT_TRUE(serve_until_ready());
  const std::uint16_t port = service->port();
  testing::internal::CaptureStderr();
  service.reset();
  ASSERT_TRUE(serve_until([&] { return device->status() == DeviceStatus::away; }));
  service = std::make_unique<HaplyService>(port);
  EXPECT_TRUE(serve_until_ready());
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_THAT(said, HasSubstr("is disconnected"));
  EXPECT_THAT(said, HasSubstr("reconnected"));
}

TEST_F(Haply, AServiceThatStopsAnsweringIsConnectedAgain) {
  open();
  ASSERT_TRUE(serve_until_ready());
  service->is_silent = true;
  ASSERT_TRUE(serve_until([&] { return device->status() == DeviceStatus::away; }));
  service->is_silent = false;
  EXPECT_TRUE(serve_until([&] { return device->status() == DeviceStatus::ready && service->connections > 1; }));
}

TEST_F(Haply, JunkMessagesAreTolerated) {
  open();
  ASSERT_TRUE(serve_until_ready());
  service->sends_junk = true;
  const std::uint64_t messages = service->messages;
  ASSERT_TRUE(serve_until([&] { return service->messages > messages + 150; }));
  EXPECT_EQ(device->status(), DeviceStatus::away);
  service->sends_junk = false;
  EXPECT_TRUE(serve_until_ready());
}

TEST_F(Haply, AServoThatDiesLeavesNoForce) {
  open();
  ASSERT_TRUE(serve_until([&] { return service->force_n[2] > 0.5; }, {.force_n = Vec3(0, 1, 0)}));
  EXPECT_TRUE(ServoHand::wait_until([&] { return service->force_n[2] == 0.0; }));
}

TEST_F(Haply, TheLastMessageIsNoForce) {
  open();
  ASSERT_TRUE(serve_until([&] { return service->force_n[2] > 0.5; }, {.force_n = Vec3(0, 1, 0)}));
  device.reset();
  EXPECT_TRUE(ServoHand::wait_until([&] { return service->force_n[2] == 0.0; }));
}

TEST_F(Haply, AMissingServiceIsOneClearLine) {
  const std::string address = service->address();
  service.reset();
  DeviceSettings settings;
  settings.id = "@" + address;
  const auto made = make_haply(settings);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().what, HasSubstr("does not answer at " + address + ": Connection refused"));
  EXPECT_THAT(made.error().what, HasSubstr("systemctl start haply-inverse-service"));
}

TEST_F(Haply, AMissingDeviceIsOneClearLine) {
  EXPECT_THAT(make("FFFF").error().what, HasSubstr("no Inverse3 of that --device-id"));
  service->is_plugged = false;
  EXPECT_THAT(make().error().what, HasSubstr("no Inverse3;"));
}

TEST_F(Haply, TheServosSideUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_EQ(ServoHand::count_heap_use(*device), 0U);
}

}  // namespace
}  // namespace hapton
