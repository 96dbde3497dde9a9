#include "devices/space_mouse_device.h"

#include <gtest/gtest.h>

#include "link/messages.h"
#include "tests/devices/device_runner.h"
#include "tests/support/fake_hid.h"
#include "tests/support/patience.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

// The report of a cap that is moved by these counts along and about the device's own axes.
FakeHid::Bytes cap_report(int x, int y, int z, int rx, int ry, int rz) {
  FakeHid::Bytes report = {1};
  for (const int axis : {x, y, z, rx, ry, rz}) {
    report.push_back(static_cast<std::uint8_t>(axis));
    report.push_back(static_cast<std::uint8_t>(axis >> 8));
  }
  return report;
}

HidDescription navigator() {
  HidDescription description;
  description.path = "/dev/hidraw3";
  description.serial = "SN-7";
  description.product = "SpaceNavigator";
  return description;
}

class SpaceMouseHand : public ::testing::Test {
 protected:
  void SetUp() override {
    auto reader = std::make_unique<SpaceMouseReader>(hid_.opener());
    ASSERT_TRUE(reader->open());
    device_ = std::make_unique<SpaceMouseDevice>(std::move(reader));
  }
  // Holds the cap in this position until the condition is true.
  template <class Condition>
  bool hold_until(int x, int y, int z, int rx, int ry, int rz, Condition&& holds, const Vec3& force_n = Vec3::Zero()) {
    const FakeHid::Bytes report = cap_report(x, y, z, rx, ry, rz);
    return runner_.serve_until(*device_,
                               [&] {
                                 if (hid_.is_drained()) hid_.send(report);
                                 return holds();
                               },
                               {.force_n = force_n});
  }
  const Vec3& p() const { return runner_.sample().p_WD; }
  // Holds the cap from now on. Returns once the device knows this, as its buttons show, before any time passes for the device.
  void hold(const FakeHid::Bytes& report) {
    ASSERT_TRUE(hid_.send(report) && hid_.send({3, ++marker_}));
    ASSERT_TRUE(wait_until([&] { return device_->read(time_ns_).buttons == marker_; }));
  }
  DeviceSample read_after(std::int64_t more_ns) { return device_->read(time_ns_ += more_ns); }

  FakeHid hid_{navigator()};
  // Behind the reader's clock, so that no report is stale.
  std::int64_t time_ns_ = SteadyClock().now_ns();
  std::uint8_t marker_ = 0;
  std::unique_ptr<SpaceMouseDevice> device_;
  DeviceRunner runner_;
};

TEST_F(SpaceMouseHand, GoesTheWayTheCapIsPushedAndNoFartherThanItsWorkspace) {
  EXPECT_TRUE(hold_until(350, 0, 0, 0, 0, 0, [&] { return p().x() > 0.02; }));
  EXPECT_EQ(p().y(), 0.0);
  EXPECT_TRUE(hold_until(0, -350, -350, 0, 0, 0, [&] { return p().y() > 0.02; }));
  EXPECT_LT(p().z(), 0.9 * device_->limits().workspace_max_m.z());
  EXPECT_TRUE(hold_until(350, 0, 0, 0, 0, 0, [&] { return p().x() == device_->limits().workspace_max_m.x(); }));
}

TEST_F(SpaceMouseHand, SaysThatThereIsNoForceToRelease) {
  HeartbeatPage page;
  device_->use_heartbeat_page(page);
  EXPECT_EQ(page.means.load(), CutMeans::no_motors);
}

TEST_F(SpaceMouseHand, HasANameThatTheHapticsNodeGetsWhole) { EXPECT_LT(device_->name().size(), LoopFacts().device.size()); }

TEST_F(SpaceMouseHand, TurnsAsTheCapIsTurned) {
  EXPECT_TRUE(hold_until(0, 0, 0, 0, 0, -350, [&] { return runner_.sample().q_WT.angularDistance(Quat::Identity()) > 0.2; }));
  const Eigen::AngleAxisd turned(runner_.sample().q_WT);
  EXPECT_LT((turned.axis() - Vec3::UnitY()).norm(), 1e-6);
}

TEST_F(SpaceMouseHand, StopsNearASurfaceThatItIsPushedInto) {
  // A wall of 1000 N/m at z = 0.05; the cap is pushed away from the person.
  const auto depth_m = [&] { return 0.05 - p().z(); };
  int rests = 0;
  double before_m = 0.0;
  EXPECT_TRUE(DeviceRunner::wait_until([&] {
    const Vec3 force_n(0, 0, std::max(1000.0 * depth_m(), 0.0));
    hold_until(
        0, -350, 0, 0, 0, 0, [] { return true; }, force_n);
    rests = depth_m() > 0.0 && std::abs(depth_m() - before_m) < 1e-6 ? rests + 1 : 0;
    before_m = depth_m();
    return rests > 100;
  }));
  EXPECT_NEAR(0.05 - p().z(), SpaceMouseDevice::kFullSpeedMPerS * SpaceMouseDevice::kDampingNsPerM / 1000.0, 1e-3);
}

TEST_F(SpaceMouseHand, UnpluggedStaysWhereItIs) {
  EXPECT_TRUE(hold_until(350, 0, 0, 0, 0, 0, [&] { return p().x() > 0.01; }));
  hid_.unplug();
  EXPECT_TRUE(hold_until(0, 0, 0, 0, 0, 0, [&] { return device_->status() == DeviceStatus::away; }));
  const Vec3 there = p();
  EXPECT_TRUE(hold_until(350, 0, 0, 0, 0, 0, [&, cycles = 0]() mutable { return ++cycles > 50; }));
  EXPECT_EQ(p(), there);
  hid_.plug_in();
  EXPECT_TRUE(hold_until(-350, 0, 0, 0, 0, 0, [&] { return p().x() < there.x() - 0.005; }));
  EXPECT_EQ(device_->status(), DeviceStatus::ready);
}

TEST_F(SpaceMouseHand, HalfThePushIsAQuarterOfTheSpeed) {
  hold(cap_report(180, 0, 0, 0, 0, 0));  // half of the range beyond the dead band
  EXPECT_NEAR(read_after(10 * kMs).p_WD.x(), 0.01 * SpaceMouseDevice::kFullSpeedMPerS / 4.0, 1e-12);
  hold(cap_report(350, 0, 0, 0, 0, 180));
  EXPECT_NEAR(Eigen::AngleAxisd(read_after(10 * kMs).q_WT).angle(), 0.01 * SpaceMouseDevice::kFullTurnRadPerS / 4.0, 1e-12);
}

TEST_F(SpaceMouseHand, ALateReadMovesThePointByThreeMillimetresAtMostAndAnEarlierTimeNotAtAll) {
  hold(cap_report(350, 0, 0, 0, 0, 0));
  EXPECT_NEAR(read_after(100 * kMs).p_WD.x(), 0.003, 1e-12);
  EXPECT_NEAR(read_after(-50 * kMs).p_WD.x(), 0.003, 1e-12);
}

TEST_F(SpaceMouseHand, NoForceTakesItOutOfTheWorkspace) {
  const DeviceLimits& limits = device_->limits();
  EXPECT_TRUE(limits.workspace_max_m.isApprox(Vec3(0.15, 0.12, 0.15)));
  EXPECT_TRUE(limits.workspace_min_m.isApprox(Vec3(-0.15, -0.12, -0.15)));
  EXPECT_EQ(limits.max_force_n, 8.0);
  EXPECT_EQ(limits.max_slew_n_per_s, 2000.0);
  read_after(0);
  device_->write({.force_n = Vec3::Constant(-1e6)}, time_ns_);
  EXPECT_EQ(read_after(10 * kMs).p_WD, limits.workspace_min_m);
  device_->write({.force_n = Vec3::Constant(1e6)}, time_ns_);
  EXPECT_EQ(read_after(10 * kMs).p_WD, limits.workspace_max_m);
}

TEST_F(SpaceMouseHand, EachTurnIsAboutTheAxesOfTheWorld) {
  hold(cap_report(0, 0, 0, 0, 0, -350));
  read_after(20 * kMs);
  hold(cap_report(0, 0, 0, 350, 0, 0));
  const double angle = 0.02 * SpaceMouseDevice::kFullTurnRadPerS;
  const Quat expected = Quat(Eigen::AngleAxisd(angle, Vec3::UnitX())) * Quat(Eigen::AngleAxisd(angle, Vec3::UnitY()));
  EXPECT_LT(read_after(20 * kMs).q_WT.angularDistance(expected), 1e-9);
}

TEST_F(SpaceMouseHand, WhileItIsUnpluggedNoForceMovesIt) {
  hid_.unplug();
  ASSERT_TRUE(wait_until([&] {
    device_->read(time_ns_);
    return device_->status() == DeviceStatus::away;
  }));
  const Vec3 there = read_after(0).p_WD;
  device_->write({.force_n = Vec3(5, 0, 0)}, time_ns_);
  EXPECT_EQ(read_after(10 * kMs).p_WD, there);
}

TEST_F(SpaceMouseHand, SaysWhatItIs) {
  EXPECT_EQ(device_->condition().model, "SpaceNavigator");
  EXPECT_EQ(device_->condition().serial, "SN-7");
}

}  // namespace
}  // namespace hapton
