#include "devices/replay_device.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

std::vector<TrajectoryRow> two_rows() {
  std::vector<TrajectoryRow> rows(2);
  rows[0] = {10.0, Vec3(0, 0, 0), Quat::Identity()};
  rows[1] = {10.01, Vec3(0.01, 0.02, -0.03), Quat(Eigen::AngleAxisd(1.0, Vec3::UnitX()))};
  return rows;
}

TEST(ReplayDevice, InterpolatesToTheServoRateAndEnds) {
  ReplayDevice device(two_rows(), {});
  EXPECT_EQ(device.read(777).p_WD, Vec3::Zero());
  const DeviceSample quarter = device.read(777 + 2'500'000);
  EXPECT_TRUE(quarter.p_WD.isApprox(Vec3(0.0025, 0.005, -0.0075), 1e-9));
  EXPECT_LT(quarter.q_WT.angularDistance(Quat(Eigen::AngleAxisd(0.25, Vec3::UnitX()))), 1e-9);
  EXPECT_EQ(device.status(), DeviceStatus::ready);
  const DeviceSample last = device.read(777 + 10'000'000);
  EXPECT_TRUE(last.p_WD.isApprox(Vec3(0.01, 0.02, -0.03)));
  EXPECT_EQ(device.status(), DeviceStatus::ended);
  EXPECT_TRUE(device.read(777 + 99'000'000).p_WD.isApprox(Vec3(0.01, 0.02, -0.03)));
}

TEST(ReplayDevice, SaysThatThereIsNoForceToRelease) {
  HeartbeatPage page;
  ReplayDevice(two_rows(), {}).use_heartbeat_page(page);
  EXPECT_EQ(page.means.load(), CutMeans::no_motors);
}

TEST(ReplayDevice, Loops) {
  ReplayDevice device(two_rows(), {.loop = true});
  device.read(0);
  for (std::int64_t round = 0; round < 5; ++round) {
    const Vec3 p = device.read(round * 20'000'000 + 5'000'000).p_WD;
    EXPECT_TRUE(p.isApprox(Vec3(0.005, 0.01, -0.015), 1e-6)) << round;
  }
}

TEST(ReplayDevice, ALoopThatDoesNotCloseIsAwayForTheReadThatJumps) {
  ReplayDevice device(two_rows(), {.loop = true});
  device.read(0);
  device.read(9'000'000);
  EXPECT_EQ(device.status(), DeviceStatus::ready);
  device.read(21'000'000);
  EXPECT_EQ(device.status(), DeviceStatus::away);
  device.read(22'000'000);
  EXPECT_EQ(device.status(), DeviceStatus::ready);
  std::vector<TrajectoryRow> closed = two_rows();
  closed.push_back({10.02, Vec3(0, 0, 0), Quat::Identity()});
  ReplayDevice closes(closed, {.loop = true});
  for (std::int64_t now = 0; now < 100'000'000; now += 1'000'000) {
    closes.read(now);
    ASSERT_EQ(closes.status(), DeviceStatus::ready);
  }
}

TEST(ReplayDevice, OneRowIsAFixedPosition) {
  std::vector<TrajectoryRow> rows = {two_rows()[1]};
  ReplayDevice device(rows, {.loop = true});
  EXPECT_EQ(device.read(0).p_WD, rows[0].p_WD);
  EXPECT_EQ(device.read(1'000'000'000).p_WD, rows[0].p_WD);
  EXPECT_EQ(device.status(), DeviceStatus::ready);
}

TEST(ReplayDevice, HoldsTheButtonsOfARowUntilTheNext) {
  std::vector<TrajectoryRow> rows = two_rows();
  rows[0].buttons = 2;
  rows[1].buttons = 5;
  ReplayDevice device(rows, {});
  EXPECT_EQ(device.read(0).buttons, 2U);
  EXPECT_EQ(device.read(9'999'000).buttons, 2U);
  EXPECT_EQ(device.read(10'001'000).buttons, 5U);
}

// No part of a recording may lie so near the limits that the governor fades or brakes the force there.
TEST(ReplayDevice, ItsLimitsLeaveRoomAroundTheWholeRecording) {
  const ReplayDevice device(two_rows(), {});
  EXPECT_LT((device.limits().workspace_min_m - Vec3(-0.02, -0.02, -0.05)).norm(), 1e-12);
  EXPECT_LT((device.limits().workspace_max_m - Vec3(0.03, 0.04, 0.02)).norm(), 1e-12);
  EXPECT_GT(device.limits().max_speed_m_per_s, 1e5);
  EXPECT_LT(device.limits().max_speed_m_per_s, 1e9) << "beyond that it is not a limit, and the governor takes another";
}

TEST(ReplayDevice, NoHandToLead) {
  ReplayDevice device(two_rows(), {});
  EXPECT_FALSE(device.set_hand_target(Vec3(1, 2, 3)));
}

}  // namespace
}  // namespace hapton
