#include "io_node/clutch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace hapton {
namespace {

constexpr std::int64_t kMsNs = 1'000'000;

// A hand whose samples are a millisecond apart.
class Hand {
 public:
  explicit Hand(Clutch& clutch) : clutch_(clutch) {}
  DeviceSample move_to(const Vec3& p, std::uint32_t buttons) {
    time_ns_ += kMsNs;
    return clutch_.move({.time_ns = time_ns_, .p_WD = p, .buttons = buttons});
  }

 private:
  Clutch& clutch_;
  std::int64_t time_ns_ = 5'000'000'000;
};

TEST(Clutch, WithoutAButtonChangesNothing) {
  Clutch clutch;
  Hand hand(clutch);
  const Vec3 p(0.1, 1e-17, -0.3);
  EXPECT_EQ(hand.move_to(p, ~0U).p_WD, p);
  EXPECT_EQ(clutch.force_factor(), 1.0);
  EXPECT_EQ(clutch.offset_m(), Vec3::Zero());
}

TEST(Clutch, ThePointStandsStillWhileItIsHeldAndGoesOnFromThere) {
  Clutch clutch(2);
  Hand hand(clutch);
  Vec3 p_WD = Vec3::Zero();
  for (int n = 0; n < 50; ++n) p_WD = hand.move_to({1e-3 * n, 0, 0}, 1).p_WD;
  EXPECT_EQ(p_WD, Vec3(0.049, 0, 0));
  // The clutch button goes down at the sample at 50 mm; the hand moves back to the left, and releases the button.
  EXPECT_EQ(hand.move_to({0.05, 0, 0}, 3).p_WD, Vec3(0.05, 0, 0));
  for (int n = 0; n < 100; ++n) EXPECT_EQ(hand.move_to({0.05 - 1e-3 * n, 0.02, 0}, 2).p_WD, Vec3(0.05, 0, 0));
  EXPECT_EQ(hand.move_to({-0.05, 0.02, 0}, 0).p_WD, Vec3(0.05, 0, 0)) << "the release itself moves nothing";
  EXPECT_LT((clutch.offset_m() - Vec3(0.1, -0.02, 0)).norm(), 1e-15);
  for (int n = 1; n < 100; ++n) {
    const DeviceSample sample = hand.move_to({-0.05 + 1e-3 * n, 0.02, 0}, 0);
    EXPECT_LT((sample.p_WD - Vec3(0.05 + 1e-3 * n, 0, 0)).norm(), 1e-15) << n;
    EXPECT_EQ(sample.buttons, 0U);
  }
  // Again: the offsets add up.
  hand.move_to({0.05, 0.02, 0}, 2);
  hand.move_to({0.0, 0.0, 0.03}, 2);
  hand.move_to({0.0, 0.0, 0.03}, 0);
  EXPECT_LT((hand.move_to({0.0, 0.0, 0.031}, 0).p_WD - Vec3(0.15, 0, 0.001)).norm(), 1e-15);
}

TEST(Clutch, TheForceFadesWithinTheTimesStated) {
  Clutch clutch(1);
  Hand hand(clutch);
  hand.move_to(Vec3::Zero(), 0);
  EXPECT_EQ(clutch.force_factor(), 1.0);
  hand.move_to(Vec3::Zero(), 1);
  for (int n = 1; n <= 20; ++n) {
    hand.move_to(Vec3::Zero(), 1);
    EXPECT_NEAR(clutch.force_factor(), std::max(0.0, 1.0 - n / 10.0), 1e-12) << n;
  }
  hand.move_to(Vec3::Zero(), 0);
  for (int n = 1; n <= 120; ++n) {
    hand.move_to(Vec3::Zero(), 0);
    EXPECT_NEAR(clutch.force_factor(), std::min(1.0, n / 100.0), 1e-12) << n;
  }
}

TEST(Clutch, AStallBringsTheForceBackNoFaster) {
  Clutch clutch(1);
  clutch.move({.time_ns = kMsNs});
  clutch.move({.time_ns = 2 * kMsNs, .buttons = 1});
  clutch.move({.time_ns = 900 * kMsNs, .buttons = 1});
  EXPECT_EQ(clutch.force_factor(), 0.0);
  clutch.move({.time_ns = 901 * kMsNs});
  clutch.move({.time_ns = 5000 * kMsNs});
  EXPECT_NEAR(clutch.force_factor(), 0.1, 1e-12);
  clutch.move({.time_ns = 10 * kMsNs});
  EXPECT_NEAR(clutch.force_factor(), 0.1, 1e-12) << "a time before the last one";
}

TEST(Clutch, TheOrientationFollowsTheHand) {
  Clutch clutch(1);
  const Quat turned(Eigen::AngleAxisd(0.7, Vec3::UnitY()));
  clutch.move({.time_ns = kMsNs, .buttons = 1});
  EXPECT_EQ(clutch.move({.time_ns = 2 * kMsNs, .q_WT = turned, .buttons = 1}).q_WT.coeffs(), turned.coeffs());
}

// The governor has latched a fault by then; the bad position leaves nothing in the offset.
TEST(Clutch, APositionThatIsNotFiniteStaysAndIsForgotten) {
  Clutch clutch(1);
  Hand hand(clutch);
  const Vec3 bad = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  hand.move_to({0.01, 0, 0}, 1);
  EXPECT_FALSE(hand.move_to(bad, 1).p_WD.allFinite());
  EXPECT_FALSE(hand.move_to(bad, 0).p_WD.allFinite());
  EXPECT_EQ(hand.move_to({0.03, 0, 0}, 0).p_WD, Vec3(0.01, 0, 0));
  EXPECT_LT((hand.move_to({0.04, 0, 0}, 0).p_WD - Vec3(0.02, 0, 0)).norm(), 1e-15);
}

}  // namespace
}  // namespace hapton
