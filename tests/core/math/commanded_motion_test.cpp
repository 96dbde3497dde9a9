#include "core/math/commanded_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

const Vec3 kCommandPivot(0.02, -0.01, 0.03);

Keyframe command_key(const Vec3& p, double angle, double time_s = 0.0) {
  return {time_s, p, Quat(Eigen::AngleAxisd(angle, Vec3(1, 2, -1).normalized()))};
}

CommandedMove move_between(std::uint32_t serial, const Keyframe& from, const Keyframe& to) { return {serial, from, to}; }

TEST(CommandedMotion, IsAtRestUntilItIsCommanded) {
  const CommandedMotion motion(kCommandPivot);
  for (const double time : {-1.0, 0.0, 1e6}) EXPECT_EQ(motion.pose_at(time).matrix(), Pose::Identity().matrix()) << time;
  EXPECT_EQ(motion.newest().serial, 0U);
}

// The pivot moves on a straight line, the rotation is about one axis, and both are uniform in time.
TEST(CommandedMotion, MovesStraightAndEvenly) {
  CommandedMotion motion(kCommandPivot);
  const Vec3 to = kCommandPivot + Vec3(0.1, 0.0, -0.05);
  ASSERT_TRUE(motion.begin(move_between(1, command_key(kCommandPivot, 0.0, 2.0), command_key(to, 0.8, 6.0))));
  for (const double share : {0.1, 0.25, 0.5, 0.9}) {
    const Pose X_SO = motion.pose_at(2.0 + 4.0 * share);
    EXPECT_LT((X_SO * kCommandPivot - (kCommandPivot + share * (to - kCommandPivot))).norm(), 1e-15) << share;
    const Eigen::AngleAxisd turn(X_SO.linear());
    EXPECT_NEAR(turn.angle(), 0.8 * share, 1e-12) << share;
    EXPECT_LT((turn.axis() - Vec3(1, 2, -1).normalized()).norm(), 1e-12) << share;
  }
  EXPECT_EQ(motion.pose_at(2.0).matrix(), Pose::Identity().matrix()) << "it starts after that time";
  const Pose at_end = pose_of(command_key(to, 0.8), kCommandPivot);
  for (const double time : {6.0, 6.1, 1e5}) EXPECT_EQ(motion.pose_at(time).matrix(), at_end.matrix()) << "it stays, exactly";
}

// At the time of the takeover, the old move and the new one give the same pose to the last bit.
TEST(CommandedMotion, ANewerMoveTakesOverWithoutAJump) {
  CommandedMotion motion(kCommandPivot);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-0.1, 0.1);
  double time_s = 0.0;
  for (std::uint32_t serial = 1; serial <= 50; ++serial) {
    const Pose before = motion.pose_at(time_s);
    const CommandedMove move = make_move(
        motion, serial, time_s, command_key({number(random), number(random), number(random)}, 5.0 * number(random)), 0.02, 0.05, 0.25);
    ASSERT_TRUE(motion.begin(move));
    EXPECT_EQ(motion.pose_at(time_s).matrix(), before.matrix()) << serial;
    EXPECT_EQ(pose_of(move.from, kCommandPivot).matrix(), before.matrix()) << serial;
    const Pose soon = motion.pose_at(time_s + 1e-6);
    EXPECT_LT((soon * Vec3(0.03, 0, 0) - before * Vec3(0.03, 0, 0)).norm(), 0.25 * 1e-6 * 2.0) << serial;
    time_s += 0.01;
  }
}

// A picture may show a sample from a moment ago, before the newest move started.
TEST(CommandedMotion, RemembersEarlierMoves) {
  CommandedMotion motion(Vec3::Zero());
  std::vector<Pose> expected;
  for (std::uint32_t serial = 1; serial < CommandedMotion::kMoves; ++serial) {
    const double start_s = 0.1 * serial;
    motion.begin(make_move(motion, serial, start_s, command_key(Vec3(0.01 * (serial % 3), 0, 0), 0.1 * serial), 0.3, 0.05, 0.25));
    expected.push_back(motion.pose_at(start_s + 0.05));
  }
  for (std::size_t n = 0; n < expected.size(); ++n) {
    EXPECT_EQ(motion.pose_at(0.1 * static_cast<double>(n + 1) + 0.05).matrix(), expected[n].matrix()) << n;
  }
  EXPECT_EQ(motion.pose_at(0.05).matrix(), Pose::Identity().matrix()) << "at rest before the first";
}

TEST(CommandedMotion, ForgetsTheOldestMoves) {
  CommandedMotion motion(Vec3::Zero());
  for (std::uint32_t serial = 1; serial <= 3 * CommandedMotion::kMoves; ++serial) {
    const Keyframe from = command_key(Vec3(serial, 0, 0), 0.0, serial);
    ASSERT_TRUE(motion.begin(move_between(serial, from, command_key(Vec3(serial + 1, 0, 0), 0.0, serial + 1.0))));
  }
  const double oldest = 2.0 * CommandedMotion::kMoves + 1.0;
  EXPECT_EQ(motion.pose_at(0.5).translation().x(), oldest) << "where the oldest that is kept starts";
  EXPECT_EQ(motion.pose_at(oldest + 0.5).translation().x(), oldest + 0.5);
  EXPECT_EQ(motion.pose_at(1e3).translation().x(), 3.0 * CommandedMotion::kMoves + 1.0);
}

TEST(CommandedMotion, LeavesOutWhatIsNotNewer) {
  CommandedMotion motion(Vec3::Zero());
  ASSERT_TRUE(motion.begin(move_between(5, command_key(Vec3::Zero(), 0.0, 1.0), command_key(Vec3(1, 0, 0), 0.0, 2.0))));
  EXPECT_FALSE(motion.begin(move_between(5, command_key(Vec3::Zero(), 0.0, 1.0), command_key(Vec3(9, 0, 0), 0.0, 2.0)))) << "again";
  EXPECT_FALSE(motion.begin(move_between(4, command_key(Vec3::Zero(), 0.0, 3.0), command_key(Vec3(9, 0, 0), 0.0, 4.0)))) << "overtaken";
  EXPECT_FALSE(motion.begin({})) << "at rest";
  EXPECT_EQ(motion.pose_at(2.0).translation().x(), 1.0);
}

// Two moves requested between the same two samples start at the same time; the first of them has no effect.
TEST(CommandedMotion, OfTwoMovesAtOneTimeTheNewerCounts) {
  CommandedMotion motion(Vec3::Zero());
  motion.begin(make_move(motion, 1, 0.0, command_key(Vec3(1, 0, 0), 0.0), 10.0, 0.0, 1.0));
  motion.begin(make_move(motion, 2, 5.0, command_key(Vec3(-9, 0, 0), 0.0), 10.0, 0.0, 1.0));
  motion.begin(make_move(motion, 3, 5.0, command_key(Vec3(0.5, 2, 0), 0.0), 10.0, 0.0, 1.0));
  EXPECT_EQ(motion.pose_at(5.0).translation(), Vec3(0.5, 0, 0)) << "on the path of the first move";
  EXPECT_LT((motion.pose_at(10.0).translation() - Vec3(0.5, 1, 0)).norm(), 1e-15);
}

// The least time allows for the translation plus the rotation of the farthest point.
TEST(CommandedMove, TakesTheTimeRequestedOrTheLeastAllowed) {
  const CommandedMotion motion(kCommandPivot);
  constexpr double kFarthestM = 0.05;
  constexpr double kMaxMPerS = 0.25;
  const Keyframe to = command_key(kCommandPivot + Vec3(0.0, 0.03, 0.04), 1.2);
  const double least_s = (0.05 + 1.2 * kFarthestM) / kMaxMPerS;
  const auto duration_s = [&](double requested_s) {
    const CommandedMove move = make_move(motion, 1, 3.0, to, requested_s, kFarthestM, kMaxMPerS);
    EXPECT_EQ(move.from.time_s, 3.0);
    return move.to.time_s - 3.0;
  };
  EXPECT_NEAR(duration_s(0.0), least_s, 1e-12);
  EXPECT_NEAR(duration_s(0.5 * least_s), least_s, 1e-12);
  EXPECT_NEAR(duration_s(2.0 * least_s), 2.0 * least_s, 1e-12);
}

// No point of the body is faster than allowed, whichever moves take over and whenever.
TEST(CommandedMove, NoPointIsFasterThanAllowed) {
  constexpr double kFarthestM = 0.05;
  constexpr double kMaxMPerS = 0.25;
  CommandedMotion motion(kCommandPivot);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  const Vec3 far_point = kCommandPivot + kFarthestM * Vec3(1, 1, 0.3).normalized();
  double fastest = 0.0;
  for (std::uint32_t step = 1; step <= 20'000; ++step) {
    const double time_s = 1e-3 * step;
    if (step % 37 == 0) {
      const Keyframe to = command_key(0.3 * Vec3(number(random), number(random), number(random)), 3.0 * number(random));
      motion.begin(make_move(motion, step, time_s, to, 0.01, kFarthestM, kMaxMPerS));
    }
    fastest = std::max(fastest, 1e3 * (motion.pose_at(time_s + 1e-3) * far_point - motion.pose_at(time_s) * far_point).norm());
  }
  EXPECT_LE(fastest, kMaxMPerS * (1.0 + 1e-9));
  EXPECT_GT(fastest, 0.5 * kMaxMPerS) << "the test moves it";
}

TEST(CommandedMotion, TakesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  CommandedMotion motion(Vec3::Zero());
  double sum = 0.0;
  const AllocationGuard guard;
  for (std::uint32_t serial = 1; serial < 100; ++serial) {
    motion.begin(make_move(motion, serial, serial, command_key(Vec3(serial, 0, 0), 0.1), 0.5, 0.05, 0.25));
    sum += motion.pose_at(serial + 0.2).translation().x();
  }
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(sum, 0.0);
}

}  // namespace
}  // namespace hapton
