// Uses a stand-in for the Haply Inverse Service.
#include "devices/haply_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "tests/devices/served_device.h"
#include "tests/standins/haply_service.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

struct Haply : ServedDevice {
  std::unique_ptr<HaplyService> service = std::make_unique<HaplyService>();

  using ServedDevice::make;
  Result<std::unique_ptr<Device>> make(const std::string& id) override {
    DeviceSettings settings;
    settings.id = id + "@" + service->address();
    return make_haply(settings);
  }
};

TEST_F(Haply, GivesPositionOrientationAndButtonsInTheWorld) {
  service->position_m[2] = 0.16;
  service->buttons = 3;
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_TRUE(runner.sample().p_WD.isApprox(Vec3(0, 0.01, 0), 1e-9));
  EXPECT_EQ(runner.sample().buttons, 3U);
  EXPECT_TRUE((runner.sample().q_WT * Vec3::UnitZ()).isApprox(Vec3::UnitX(), 1e-9));
  EXPECT_EQ(device->condition().serial, "049D");
  EXPECT_EQ(device->condition().firmware, "7.4.0");
}

// The service reports no limits. With a slew limit twice as high, a blow would be twice as hard.
TEST_F(Haply, ItsLimitsAreTheCarefulOnesOfTheDocuments) {
  open();
  const DeviceLimits& limits = device->limits();
  EXPECT_EQ(limits.max_force_n, 5.0);
  EXPECT_EQ(limits.continuous_force_n, 2.0);
  EXPECT_EQ(limits.peak_s, 5.0);
  EXPECT_NEAR(limits.max_slew_n_per_s, 1250.0, 1e-6) << "full force in 4 ms";
  EXPECT_EQ(limits.max_stiffness_n_per_m, 600.0);
  EXPECT_EQ(limits.max_speed_m_per_s, 5.0);
  EXPECT_EQ(limits.workspace_min_m, Vec3::Constant(-0.1));
  EXPECT_EQ(limits.workspace_max_m, Vec3::Constant(0.1));
  EXPECT_EQ(limits.max_torque_nm, 0.0);
}

TEST_F(Haply, IntroducesItselfOnceAndThenSendsForcesAlone) {
  // If the service stands still for half a second, the device connects again, as it should; then the test tries again.
  for (int attempt = 0; attempt < 10; ++attempt) {
    device.reset();
    service = std::make_unique<HaplyService>();
    open();
    ASSERT_TRUE(serve_until_ready());
    EXPECT_THAT(service->first_message(), HasSubstr("org.hapton:io_node"));
    if (service->connections == 1U) break;
  }
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
  EXPECT_EQ(runner.sample().q_WT.coeffs(), Quat::Identity().coeffs());
}

TEST_F(Haply, AFewStatesWithoutTheArmAreNotAnAbsence) {
  open();
  ASSERT_TRUE(serve_until_ready());
  bool was_away = false;
  service->absent_states = 10;
  ASSERT_TRUE(serve_until([&] {
    was_away = was_away || device->status() != DeviceStatus::ready;
    return service->absent_states == 0;
  }));
  EXPECT_FALSE(was_away);
  service->absent_states = 1000;
  EXPECT_TRUE(serve_until([&] { return device->status() == DeviceStatus::away; }));
}

// A dead man's switch on the grip must not stay held.
TEST_F(Haply, AGripThatIsGoneHoldsNoButton) {
  service->buttons = 1;
  open();
  ASSERT_TRUE(serve_until_ready());
  ASSERT_TRUE(serve_until([&] { return runner.sample().buttons == 1U; }));
  service->has_grip = false;
  EXPECT_TRUE(serve_until([&] { return runner.sample().buttons == 0U; }));
  EXPECT_EQ(device->status(), DeviceStatus::ready);
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
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("is disconnected"));
  EXPECT_THAT(log, HasSubstr("reconnected"));
}

// The service was updated meanwhile: another version might accept the messages and ignore the forces.
TEST_F(Haply, AServiceThatComesBackInAnotherVersionIsNotDriven) {
  open();
  ASSERT_TRUE(serve_until_ready());
  const std::uint16_t port = service->port();
  testing::internal::CaptureStderr();
  service.reset();
  service = std::make_unique<HaplyService>(port, "4.0.0");
  const bool was_tried = serve_until([&] { return service->connections >= 2; });
  const std::string log = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(was_tried);
  EXPECT_EQ(device->status(), DeviceStatus::away);
  EXPECT_EQ(service->messages, 0U);
  const std::string line = "searching: the Haply Inverse Service at " + service->address() + " is version 4.0; ";
  EXPECT_THAT(log, HasSubstr(line));
  EXPECT_EQ(log.find(line), log.rfind(line)) << "once, not at each attempt";
  testing::internal::CaptureStderr();
  service.reset();
  service = std::make_unique<HaplyService>(port, "");
  const bool is_driven = serve_until_ready();
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("does not report its version"));
  EXPECT_TRUE(is_driven) << "a service without a version is accepted, as at the start";
}

// If it were tried again at once, the servo might not notice that the device was away, and the force would continue without a ramp.
TEST_F(Haply, ALostConnectionIsTriedAgainAQuarterOfASecondLater) {
  open();
  ASSERT_TRUE(serve_until_ready());
  const std::uint16_t port = service->port();
  const std::int64_t ended_ns = SteadyClock().now_ns();
  service.reset();
  service = std::make_unique<HaplyService>(port);
  ASSERT_TRUE(serve_until([&] { return service->connections == 1 && device->status() == DeviceStatus::ready; }));
  const std::int64_t took_ns = SteadyClock().now_ns() - ended_ns;
  EXPECT_GE(took_ns, kNanosecondsPerSecond / 4);
}

TEST_F(Haply, AServiceThatStopsReplyingIsConnectedAgain) {
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
  ASSERT_TRUE(serve_until([&] { return service->messages > messages + 150 && device->status() == DeviceStatus::away; }));
  service->sends_junk = false;
  EXPECT_TRUE(serve_until_ready());
}

TEST_F(Haply, AServoThatDiesLeavesNoForce) {
  open();
  ASSERT_TRUE(serve_until([&] { return service->force_n[2] > 0.5; }, {.force_n = Vec3(0, 1, 0)}));
  EXPECT_TRUE(DeviceRunner::wait_until([&] { return service->force_n[2] == 0.0; }));
}

TEST_F(Haply, TheLastMessageIsNoForce) {
  open();
  ASSERT_TRUE(serve_until([&] { return service->force_n[2] > 0.5; }, {.force_n = Vec3(0, 1, 0)}));
  device.reset();
  EXPECT_TRUE(DeviceRunner::wait_until([&] { return service->force_n[2] == 0.0; }));
}

TEST_F(Haply, ClosesTheConnectionInOrder) {
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_EQ(service->closed_in_order, 0U);
  device.reset();
  EXPECT_TRUE(DeviceRunner::wait_until([&] { return service->closed_in_order == 1; }));
}

TEST_F(Haply, AServiceOfAnotherVersionIsReportedInOneLine) {
  for (const auto& [version, line] : {std::pair("3.1.1.0", "is version 3.1; this io_node needs 3.5 or later"),
                                      std::pair("4.0.0", "is version 4.0; this io_node knows 3.5 and later versions of 3 only")}) {
    service->version = version;
    const auto made = make();
    ASSERT_FALSE(made);
    EXPECT_THAT(made.error().what, HasSubstr(line));
  }
  service->version = "";
  testing::internal::CaptureStderr();
  EXPECT_TRUE(make());
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("does not report its version (HTTP status 404 for /version)"));
}

// The session turns the device by 90 degrees about the service's z and moves it; position and force of the hand stay the same.
TEST_F(Haply, StaysAtTheDeviceWhereASessionPlacesIt) {
  const double half = std::sqrt(0.5);
  service->mount = R"({"position":{"x":0.5,"y":0,"z":0},"rotation":{"w":)" + std::to_string(half) + R"(,"x":0,"y":0,"z":)" +
                   std::to_string(half) + R"(},"scale":{"x":1,"y":1,"z":1}})";
  service->transform = R"({"position":{"x":0,"y":0,"z":0.25}})";
  // The cursor is 1 cm above its home: (0, -0.12, 0.16), turned and moved.
  service->position_m[0] = 0.62;
  service->position_m[1] = 0.0;
  service->position_m[2] = 0.41;
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_TRUE(runner.sample().p_WD.isApprox(Vec3(0, 0.01, 0), 1e-5)) << runner.sample().p_WD.transpose();
  EXPECT_TRUE(serve_until([&] { return std::abs(service->force_n[2] - 1.0) < 1e-5; }, {.force_n = Vec3(0.5, 1.0, 0.25)}));
  EXPECT_NEAR(service->force_n[0], 0.25, 1e-5);
  EXPECT_NEAR(service->force_n[1], 0.5, 1e-5);
}

TEST_F(Haply, ASessionWithAScaleHasNoForce) {
  testing::internal::CaptureStderr();
  open();
  ASSERT_TRUE(serve_until([&] { return service->force_n[2] > 0.5; }, {.force_n = Vec3(0, 1, 0)}));
  service->is_scaled = true;
  ASSERT_TRUE(
      serve_until([&] { return device->status() == DeviceStatus::away && service->force_n[2] == 0.0; }, {.force_n = Vec3(0, 1, 0)}));
  service->is_scaled = false;
  EXPECT_TRUE(serve_until([&] { return service->force_n[2] > 0.5; }, {.force_n = Vec3(0, 1, 0)}));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("has a scale"));
}

TEST_F(Haply, AMissingServiceIsReportedInOneLine) {
  const std::string address = service->address();
  service.reset();
  DeviceSettings settings;
  settings.id = "@" + address;
  const auto made = make_haply(settings);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().what, HasSubstr("does not reply at " + address + ": Connection refused"));
  EXPECT_THAT(made.error().what, HasSubstr("systemctl start haply-inverse-service"));
}

TEST_F(Haply, AMissingDeviceIsReportedInOneLine) {
  EXPECT_THAT(make("FFFF").error().what, HasSubstr("no Inverse3 with that --device-id"));
  service->is_plugged = false;
  EXPECT_THAT(make().error().what, HasSubstr("no Inverse3;"));
}

TEST_F(Haply, AServiceThatSendsNoInventoryIsReportedInOneLine) {
  service->sends_junk = true;
  EXPECT_EQ(make().error().what, "the Haply Inverse Service sent something that is not a JSON object");
  service->sends_junk = false;
  service->hangs_up = true;
  const std::string what = make().error().what;
  EXPECT_THAT(what, HasSubstr("the Haply Inverse Service at " + service->address() + " sends no data: "));
  EXPECT_THAT(what, HasSubstr("systemctl start haply-inverse-service"));
}

TEST_F(Haply, AnArmThatDoesNotSayWhatItIsIsAnInverse3) {
  service->type = "";
  open();
  EXPECT_EQ(device->condition().model, "inverse3");
  device.reset();
  service->type = "minverse";
  open();
  EXPECT_EQ(device->condition().model, "minverse");
}

TEST_F(Haply, TheServosSideUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  open();
  ASSERT_TRUE(serve_until_ready());
  EXPECT_EQ(DeviceRunner::count_heap_use(*device), 0U);
}

}  // namespace
}  // namespace hapton
