#include "patch/announced_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace hapton {
namespace {

constexpr double kRadius = 0.05;
const Vec3 kAnnouncedPivot(0.1, 0.2, 0.3);

CommandedMove make_announced_move(std::uint32_t serial, double begin_s, double end_s, const Keyframe& from, const Vec3& to,
                                  double turn_rad = 0.0) {
  CommandedMove move{.serial = serial, .from = from, .to = {end_s, to, Quat(Eigen::AngleAxisd(turn_rad, Vec3::UnitX()))}};
  move.from.time_s = begin_s;
  return move;
}

TEST(AnnouncedMotion, AMoveThatIsKnownBeforeItBeginsIsTheMoveItself) {
  AnnouncedMotion motion(kAnnouncedPivot, kRadius);
  CommandedMotion commanded(kAnnouncedPivot);
  for (std::uint32_t serial = 1; serial < 20; ++serial) {
    const double begin_s = 0.5 * serial;
    const CommandedMove move = make_announced_move(serial, begin_s, begin_s + 1.0, commanded.keyframe_at(begin_s),
                                                   kAnnouncedPivot + Vec3(0.01 * serial, 0, 0), serial % 2 == 0 ? 0.5 : 0.0);
    ASSERT_TRUE(commanded.begin(move));
    ASSERT_TRUE(motion.accept_in_contact(move, begin_s - 0.1));
    for (double t = begin_s - 0.1; t < begin_s + 0.4; t += 0.01) {
      ASSERT_EQ(motion.pose_at(t).matrix(), commanded.pose_at(t).matrix()) << serial << " " << t;
    }
  }
  EXPECT_EQ(motion.late(), 0U);
  EXPECT_FALSE(motion.accept_in_contact(make_announced_move(19, 10.0, 11.0, {}, Vec3::Zero()), 10.0)) << "not newer";
}

// However late each move comes, no point of the body jumps, and the body ends where the move ends.
TEST(AnnouncedMotion, AMoveThatComesLateGoesToTheSameEndWithoutAJump) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> late_s(0.0, 1.0);
  AnnouncedMotion motion(kAnnouncedPivot, kRadius);
  CommandedMotion commanded(kAnnouncedPivot);
  std::vector<std::pair<double, CommandedMove>> moves_under_way;
  const Vec3 corner = kAnnouncedPivot + Vec3(0.0, kRadius, 0.0);
  Vec3 last_position = corner;
  constexpr double kStepS = 1e-3;
  for (int n = 1; n < 20'000; ++n) {
    const double t = kStepS * n;
    if (n % 300 == 0 && n < 15'000) {
      const auto serial = static_cast<std::uint32_t>(n);
      const Vec3 to = kAnnouncedPivot + Vec3(0.0, 0.0, 0.01 * static_cast<double>(n % 5));
      const CommandedMove move = make_announced_move(serial, t, t + 0.3, commanded.keyframe_at(t), to, 0.1 * static_cast<double>(n % 7));
      commanded.begin(move);
      moves_under_way.emplace_back(t + late_s(random), move);
    }
    for (auto& [due_s, move] : moves_under_way) {
      if (due_s <= t && due_s > t - kStepS) (void)motion.accept_in_contact(move, t);
    }
    const Vec3 position = motion.pose_at(t) * corner;
    ASSERT_LE((position - last_position).norm(), kMaxSurfaceSpeed * kStepS * (1.0 + 1e-9)) << t;
    last_position = position;
  }
  EXPECT_GT(motion.late(), 20U);
  EXPECT_LT((motion.pose_at(20.0).matrix() - commanded.pose_at(20.0).matrix()).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(AnnouncedMotion, AMoveThatIsTooFastIsSlowed) {
  AnnouncedMotion motion(kAnnouncedPivot, kRadius);
  ASSERT_TRUE(motion.accept_in_contact(
      make_announced_move(1, 1.0, 1.001, {0.0, kAnnouncedPivot, Quat::Identity()}, kAnnouncedPivot + Vec3(1, 0, 0)), 0.5));
  EXPECT_EQ(motion.late(), 1U);
  EXPECT_NEAR(motion.pose_at(2.0).translation().x(), kMaxSurfaceSpeed, 1e-9);
  EXPECT_NEAR(motion.pose_at(100.0).translation().x(), 1.0, 1e-12);
}

// Before anything is felt, a move is accepted unchanged, because a hub that starts later knows only the newest move.
TEST(AnnouncedMotion, BeforeTheFirstKnownMoveItStandsWhereThatBegan) {
  AnnouncedMotion motion(kAnnouncedPivot, kRadius);
  const Keyframe from{5.0, kAnnouncedPivot + Vec3(0.2, 0, 0), Quat::Identity()};
  ASSERT_TRUE(motion.accept(make_announced_move(17, 5.0, 6.0, from, kAnnouncedPivot)));
  EXPECT_EQ(motion.serial(), 17U);
  EXPECT_NEAR(motion.pose_at(4.0).translation().x(), 0.2, 1e-12);
  EXPECT_NEAR(motion.pose_at(5.5).translation().x(), 0.1, 1e-12);
  EXPECT_FALSE(motion.accept(make_announced_move(17, 5.0, 6.0, from, kAnnouncedPivot)));
}

// The earlier move never came. This one is in time, but does not begin where the body is.
TEST(AnnouncedMotion, AMoveInTimeThatBeginsElsewhereMovesWithoutAJump) {
  AnnouncedMotion motion(kAnnouncedPivot, kRadius);
  const Keyframe elsewhere{0.0, kAnnouncedPivot + Vec3(0.02, 0, 0), Quat::Identity()};
  ASSERT_TRUE(motion.accept_in_contact(make_announced_move(2, 1.0, 2.0, elsewhere, kAnnouncedPivot + Vec3(0.04, 0, 0)), 0.9));
  EXPECT_EQ(motion.late(), 1U);
  constexpr double kStepS = 1e-3;
  Vec3 last_position = motion.pose_at(0.9) * kAnnouncedPivot;
  EXPECT_LT((last_position - kAnnouncedPivot).norm(), 1e-15);
  for (double t = 0.9; t < 2.1; t += kStepS) {
    const Vec3 position = motion.pose_at(t) * kAnnouncedPivot;
    ASSERT_LE((position - last_position).norm(), kMaxSurfaceSpeed * kStepS * (1.0 + 1e-9)) << t;
    last_position = position;
  }
  EXPECT_LT((last_position - kAnnouncedPivot - Vec3(0.04, 0, 0)).norm(), 1e-12) << "where the move ends";
}

}  // namespace
}  // namespace hapton
