#include "tools/live/corner_touch.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace hapton {
namespace {

using Event = CornerTouch::Event;

constexpr std::int64_t kSampleNs = 4'000'000;
constexpr std::uint64_t kTouchSeed = 9;

// A hand and its device, sample after sample.
class TouchingHand {
 public:
  // Returns the first event other than none within `seconds`. The tip trembles with the standard deviation `tremble_m`.
  Event stay(double seconds, double tremble_m = 0.00005) {
    std::normal_distribution<double> tremble(0.0, tremble_m);
    for (double t_s = 0.0; t_s < seconds; t_s += 1e-9 * kSampleNs) {
      const Event event = add(p_W_ + Vec3(tremble(random_), tremble(random_), tremble(random_)));
      if (event != Event::none) return event;
    }
    return Event::none;
  }
  Event go(const Vec3& p_W, double m_per_s = 0.2) {
    while ((p_W - p_W_).norm() > 1e-9) {
      const double step_m = 1e-9 * kSampleNs * m_per_s;
      const Vec3 remaining = p_W - p_W_;
      p_W_ += remaining.norm() > step_m ? Vec3(step_m * remaining.normalized()) : remaining;
      if (const Event event = add(p_W_); event != Event::none) return event;
    }
    return Event::none;
  }
  void press(std::uint32_t buttons) { buttons_ = buttons; }
  void lose_samples(double seconds) { time_ns_ += static_cast<std::int64_t>(1e9 * seconds); }
  double seconds() const { return 1e-9 * static_cast<double>(time_ns_); }
  Event add(const Vec3& p_W) {
    time_ns_ += kSampleNs;
    ProbeState probe;
    probe.sample_time_ns = time_ns_;
    probe.p_WD = p_W;
    probe.buttons = buttons_;
    return touch.add(probe);
  }

  CornerTouch touch;

 private:
  Vec3 p_W_ = Vec3::Zero();
  std::int64_t time_ns_ = 0;
  std::uint32_t buttons_ = 0;
  std::mt19937_64 random_{kTouchSeed};
};

const Vec3 kCorner(0.1, -0.05, 0.02);

TEST(CornerTouch, ATipThatHoldsStillForASecondTouchesTheMean) {
  TouchingHand hand;
  ASSERT_EQ(hand.go(kCorner), Event::none);
  const double from_s = hand.seconds();
  ASSERT_EQ(hand.stay(3.0), Event::touched);
  EXPECT_NEAR(hand.seconds() - from_s, CornerTouch::kHoldS, 0.05);
  EXPECT_LT((hand.touch.p_W() - kCorner).norm(), 0.00003) << "seed " << kTouchSeed << ": less than the tremble";
  EXPECT_LT(hand.touch.moved_m(), CornerTouch::kHoldStillM);
}

TEST(CornerTouch, AStylusThatHasNotMovedTouchesNothing) {
  TouchingHand hand;
  EXPECT_EQ(hand.stay(5.0), Event::none) << "in its stand";
  hand.go(kCorner);
  ASSERT_EQ(hand.stay(2.0), Event::touched);
  EXPECT_EQ(hand.stay(5.0), Event::none) << "once only";
  hand.go(kCorner + Vec3(0.015, 0.0, 0.0));
  EXPECT_EQ(hand.stay(5.0), Event::none) << "not far enough away";
  hand.go(kCorner + Vec3(0.03, 0.0, 0.0));
  hand.go(kCorner);
  EXPECT_EQ(hand.stay(2.0), Event::touched) << "the same point, come back to";
}

TEST(CornerTouch, AHandThatDriftsTouchesNothing) {
  TouchingHand hand;
  hand.go(kCorner);
  EXPECT_EQ(hand.go(kCorner + Vec3(0.0, 0.01, 0.0), 0.0015), Event::none);
}

TEST(CornerTouch, APressIsMeasuredAfterwardsAndNeedsNoMotionBefore) {
  TouchingHand hand;
  hand.stay(0.1);
  hand.press(2);
  const double from_s = hand.seconds();
  ASSERT_EQ(hand.stay(1.0), Event::touched);
  EXPECT_NEAR(hand.seconds() - from_s, CornerTouch::kPressS, 0.01);
  EXPECT_LT(hand.touch.p_W().norm(), 0.00003);
  EXPECT_EQ(hand.stay(3.0), Event::none) << "held down";
  hand.press(0);
  EXPECT_EQ(hand.stay(3.0), Event::none) << "released";
  hand.press(1);
  EXPECT_EQ(hand.stay(1.0), Event::touched) << "and pressed again";
}

TEST(CornerTouch, AButtonThatIsDownAtFirstIsNoPress) {
  TouchingHand hand;
  hand.press(4);
  EXPECT_EQ(hand.stay(3.0), Event::none);
  hand.press(4 | 1);
  EXPECT_EQ(hand.stay(1.0), Event::touched);
}

TEST(CornerTouch, AMotionAfterThePressIsReportedWithItsLength) {
  TouchingHand hand;
  hand.stay(0.1);
  hand.press(1);
  ASSERT_EQ(hand.go(kCorner, 0.02), Event::moved);
  EXPECT_NEAR(hand.touch.moved_m(), 0.5 * 0.02 * CornerTouch::kPressS, 1e-4);
  hand.press(0);
  EXPECT_EQ(hand.go(kCorner, 0.02), Event::none);
  hand.press(1);
  EXPECT_EQ(hand.stay(1.0), Event::touched) << "the next press counts";
}

TEST(CornerTouch, AGapBeginsAnew) {
  TouchingHand hand;
  hand.go(kCorner);
  EXPECT_EQ(hand.stay(0.8), Event::none);
  hand.lose_samples(2.0);
  EXPECT_EQ(hand.stay(0.8), Event::none);
  EXPECT_EQ(hand.stay(0.4), Event::touched);
}

TEST(CornerTouch, IgnoresOldSamplesAndPositionsThatAreNotFinite) {
  CornerTouch touch;
  ProbeState probe;
  probe.sample_time_ns = 1'000'000'000;
  EXPECT_EQ(touch.add(probe), Event::none);
  probe.p_WD = Vec3(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0);
  probe.sample_time_ns += kSampleNs;
  EXPECT_EQ(touch.add(probe), Event::none);
  probe.p_WD = kCorner;
  probe.buttons = 1;
  probe.sample_time_ns = 5;
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(touch.add(probe), Event::none);
}

}  // namespace
}  // namespace hapton
