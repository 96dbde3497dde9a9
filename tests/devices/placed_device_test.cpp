#include "devices/placed_device.h"

#include <gtest/gtest.h>

#include <memory>
#include <numbers>
#include <vector>

namespace hapton {
namespace {

// A device that stays where it is put and records its commands, in its own base frame.
class StillDevice final : public Device {
 public:
  StillDevice() {
    limits_.workspace_min_m = Vec3(-0.1, -0.2, -0.3);
    limits_.workspace_max_m = Vec3(0.1, 0.2, 0.3);
    sample.p_WD = Vec3(0.01, 0.02, 0.03);
  }
  std::string_view name() const noexcept override { return "still"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceSample read(std::int64_t) noexcept override { return sample; }
  void write(const Wrench& wrench, std::int64_t) noexcept override { last_wrench = wrench; }
  DeviceStatus status() const noexcept override { return DeviceStatus::calibrating; }
  bool set_hand_target(const std::optional<Vec3>& p_WH) noexcept override {
    hand_target = p_WH;
    return true;
  }
  bool cut() noexcept override { return is_cut = true; }
  void restore() noexcept override { is_cut = false; }
  void use_heartbeat_page(HeartbeatPage& page) noexcept override { page.set_means(CutMeans::kill); }
  DeviceCondition condition() const noexcept override {
    DeviceCondition warm;
    warm.motor_temperature = 0.5;
    return warm;
  }
  bool press_hand_buttons(std::uint32_t buttons) noexcept override {
    hand_buttons = buttons;
    return true;
  }
  bool turn_hand(const Vec3& turn_rad) noexcept override {
    hand_turn_rad = turn_rad;
    return true;
  }
  bool aim_hand(std::span<const Vec3> p_WA) noexcept override {
    aims.assign(p_WA.begin(), p_WA.end());
    return true;
  }

  DeviceSample sample;
  Wrench last_wrench;
  std::optional<Vec3> hand_target;
  bool is_cut = false;
  std::uint32_t hand_buttons = 0;
  Vec3 hand_turn_rad = Vec3::Zero();
  std::vector<Vec3> aims;

 private:
  DeviceLimits limits_;
};

// A quarter turn about y: the device's x axis points to W's -z, its z axis to W's x.
Pose quarter_turn_beside() {
  Pose X_WB = Pose::Identity();
  X_WB.linear() = Eigen::AngleAxisd(std::numbers::pi / 2.0, Vec3::UnitY()).toRotationMatrix();
  X_WB.translation() = Vec3(1.0, 0.0, 0.0);
  return X_WB;
}

struct PlacedDevices : testing::Test {
  StillDevice* inner = new StillDevice;
  PlacedDevice device{std::unique_ptr<Device>(inner), quarter_turn_beside()};
};

TEST_F(PlacedDevices, AreReadInTheWorld) {
  const DeviceSample sample = device.read(5);
  EXPECT_LT((sample.p_WD - Vec3(1.03, 0.02, -0.01)).norm(), 1e-12);
  EXPECT_LT((sample.q_WT * Vec3::UnitZ() - Vec3::UnitX()).norm(), 1e-12);
}

TEST_F(PlacedDevices, GetTheWrenchInTheirOwnFrame) {
  device.write({.force_n = Vec3(0, 0, -2), .torque_nm = Vec3(3, 0, 0)}, 5);
  EXPECT_LT((inner->last_wrench.force_n - Vec3(2, 0, 0)).norm(), 1e-12);
  EXPECT_LT((inner->last_wrench.torque_nm - Vec3(0, 0, 3)).norm(), 1e-12);
}

TEST_F(PlacedDevices, AreLedToAPlaceInTheWorld) {
  EXPECT_TRUE(device.set_hand_target(Vec3(1.03, 0.02, -0.01)));
  EXPECT_LT((*inner->hand_target - Vec3(0.01, 0.02, 0.03)).norm(), 1e-12);
  device.set_hand_target(std::nullopt);
  EXPECT_FALSE(inner->hand_target);
}

TEST_F(PlacedDevices, HaveTheirWorkspaceInTheWorld) {
  EXPECT_LT((device.limits().workspace_min_m - Vec3(0.7, -0.2, -0.1)).norm(), 1e-12);
  EXPECT_LT((device.limits().workspace_max_m - Vec3(1.3, 0.2, 0.1)).norm(), 1e-12);
}

TEST_F(PlacedDevices, AreOtherwiseAsTheyWere) {
  EXPECT_EQ(device.name(), "still");
  EXPECT_EQ(device.status(), DeviceStatus::calibrating);
}

// The means that release the force when the governor cannot must reach the device wherever it is placed.
TEST_F(PlacedDevices, AreCutRestoredAndWatchedAsTheyWere) {
  EXPECT_TRUE(device.cut());
  EXPECT_TRUE(inner->is_cut);
  device.restore();
  EXPECT_FALSE(inner->is_cut);
  HeartbeatPage page;
  device.use_heartbeat_page(page);
  EXPECT_EQ(page.means.load(), CutMeans::kill);
  EXPECT_EQ(device.condition().motor_temperature, 0.5);
}

TEST_F(PlacedDevices, AreAimedAtPlacesInTheWorldAndPressedAndTurnedAsTheyWere) {
  const std::vector<Vec3> p_WA(Device::kMaxAims + 1, Vec3(1.03, 0.02, -0.01));
  EXPECT_TRUE(device.aim_hand(p_WA));
  ASSERT_EQ(inner->aims.size(), p_WA.size() - 1);
  for (const Vec3& p_BA : inner->aims) EXPECT_LT((p_BA - Vec3(0.01, 0.02, 0.03)).norm(), 1e-12);
  EXPECT_TRUE(device.press_hand_buttons(5));
  EXPECT_EQ(inner->hand_buttons, 5U);
  EXPECT_TRUE(device.turn_hand(Vec3(1, 2, 3)));
  EXPECT_EQ(inner->hand_turn_rad, Vec3(1, 2, 3));
}

}  // namespace
}  // namespace hapton
