#include "vision_node/recent_curve.h"

#include <limits>

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr std::int64_t kSpan = RecentCurve::kSpanNs;

TEST(RecentCurve, KeepsTheLargestOfEachSpan) {
  RecentCurve curve;
  for (const double value : {1.0, 5.0, 2.0}) curve.add(10 * kSpan, value);
  curve.add(11 * kSpan, 3.0);
  const auto points = curve.points(12 * kSpan);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].value, 5.0);
  EXPECT_NEAR(points[0].age_s, 0.04, 1e-12);
  EXPECT_EQ(points[1].value, 3.0);
  EXPECT_NEAR(points[1].age_s, 0.02, 1e-12);
}

TEST(RecentCurve, ForgetsWhatIsOlderThanFiveSeconds) {
  RecentCurve curve;
  for (std::int64_t n = 0; n < 1000; ++n) curve.add(n * kSpan, static_cast<double>(n));
  const auto points = curve.points(999 * kSpan);
  ASSERT_EQ(points.size(), RecentCurve::kSpans);
  EXPECT_EQ(points.front().value, 750.0);
  EXPECT_EQ(points.back().value, 999.0);
  EXPECT_EQ(points.back().age_s, 0.0);
  EXPECT_LT(points.front().age_s, RecentCurve::kSeconds);
  EXPECT_TRUE(curve.points(999 * kSpan + 5'000'000'000).empty());
}

TEST(RecentCurve, APauseLeavesAGapAndNoOldValues) {
  RecentCurve curve;
  curve.add(0, 1.0);
  curve.add(200 * kSpan, 2.0);
  EXPECT_EQ(curve.points(200 * kSpan).size(), 2u);
  EXPECT_EQ(curve.points(260 * kSpan).size(), 1u);
}

TEST(RecentCurve, LeavesOutWhatCannotBeDrawn) {
  RecentCurve curve;
  curve.add(kSpan, std::numeric_limits<double>::quiet_NaN());
  curve.add(kSpan, std::numeric_limits<double>::infinity());
  curve.add(-kSpan, 1.0);
  EXPECT_TRUE(curve.points(2 * kSpan).empty());
  EXPECT_TRUE(RecentCurve().points(0).empty());
  // These two times share a place in the ring: the older one does not replace the newer one.
  curve.add(300 * kSpan, 7.0);
  curve.add(50 * kSpan, 9.0);
  ASSERT_EQ(curve.points(300 * kSpan).size(), 1u);
  EXPECT_EQ(curve.points(300 * kSpan)[0].value, 7.0);
}

}  // namespace
}  // namespace hapton
