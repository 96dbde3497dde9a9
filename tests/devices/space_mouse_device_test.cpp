#include "devices/space_mouse_device.h"

#include <gtest/gtest.h>

#include "tests/devices/servo_hand.h"
#include "tests/support/fake_hid.h"

namespace hapton {
namespace {

class SpaceMouseHand : public ::testing::Test {
 protected:
  void SetUp() override {
    auto reader = std::make_unique<SpaceMouseReader>(hid_.opener());
    ASSERT_TRUE(reader->open());
    device_ = std::make_unique<SpaceMouseDevice>(std::move(reader));
  }
  // Holds the cap, in counts of the device's own axes, until the condition holds.
  template <class Condition>
  bool hold_until(int x, int y, int z, int rx, int ry, int rz, Condition&& holds, const Vec3& force_n = Vec3::Zero()) {
    FakeHid::Bytes report = {1};
    for (const int axis : {x, y, z, rx, ry, rz}) {
      report.push_back(static_cast<std::uint8_t>(axis));
      report.push_back(static_cast<std::uint8_t>(axis >> 8));
    }
    return hand_.serve_until(*device_,
                             [&] {
                               if (hid_.is_drained()) hid_.send(report);
                               return holds();
                             },
                             {.force_n = force_n});
  }
  const Vec3& p() const { return hand_.sample().p_WD; }

  FakeHid hid_;
  std::unique_ptr<SpaceMouseDevice> device_;
  ServoHand hand_;
};

TEST_F(SpaceMouseHand, GoesTheWayTheCapIsPushedAndNoFartherThanItsWorkspace) {
  EXPECT_TRUE(hold_until(350, 0, 0, 0, 0, 0, [&] { return p().x() > 0.02; }));
  EXPECT_EQ(p().y(), 0.0);
  EXPECT_TRUE(hold_until(0, -350, -350, 0, 0, 0, [&] { return p().y() > 0.02; }));
  EXPECT_LT(p().z(), 0.9 * device_->limits().workspace_max_m.z());
  EXPECT_TRUE(hold_until(350, 0, 0, 0, 0, 0, [&] { return p().x() == device_->limits().workspace_max_m.x(); }));
}

TEST_F(SpaceMouseHand, TurnsAsTheCapIsTurned) {
  EXPECT_TRUE(hold_until(0, 0, 0, 0, 0, -350, [&] { return hand_.sample().q_WT.angularDistance(Quat::Identity()) > 0.2; }));
  const Eigen::AngleAxisd turned(hand_.sample().q_WT);
  EXPECT_LT((turned.axis() - Vec3::UnitY()).norm(), 1e-6);
}

TEST_F(SpaceMouseHand, StopsNearASurfaceThatItIsPushedInto) {
  // A wall of 1000 N/m at z = 0.05; the cap is pushed away from the person.
  const auto depth_m = [&] { return 0.05 - p().z(); };
  int rests = 0;
  double before_m = 0.0;
  EXPECT_TRUE(ServoHand::wait_until([&] {
    const Vec3 force_n(0, 0, std::max(1000.0 * depth_m(), 0.0));
    hold_until(
        0, -350, 0, 0, 0, 0, [] { return true; }, force_n);
    rests = depth_m() > 0.0 && std::abs(depth_m() - before_m) < 1e-6 ? rests + 1 : 0;
    before_m = depth_m();
    return rests > 100;
  }));
  EXPECT_NEAR(0.05 - p().z(), SpaceMouseDevice::kFullSpeedMPerS * SpaceMouseDevice::kOilNsPerM / 1000.0, 1e-3);
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

}  // namespace
}  // namespace hapton
