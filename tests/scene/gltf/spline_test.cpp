#include "scene/gltf/spline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace hapton::gltf {
namespace {

double value_at_time(const NumberTrack& track, double time) {
  const auto after = std::upper_bound(track.times.begin(), track.times.end(), time);
  if (after == track.times.end()) return track.values.back()[0];
  const auto i = static_cast<std::size_t>(after - track.times.begin());
  const double share = (time - track.times[i - 1]) / (track.times[i] - track.times[i - 1]);
  return track.values[i - 1][0] + share * (track.values[i][0] - track.values[i - 1][0]);
}

// x^3 has the tangents 3 x^2, and a Hermite curve between two of its points is x^3 itself.
TEST(Spline, FollowsACubic) {
  const std::vector<double> times = {0.0, 0.5, 2.0};
  std::vector<std::vector<double>> rows;
  for (const double t : times) rows.insert(rows.end(), {{3 * t * t}, {t * t * t}, {3 * t * t}});
  const NumberTrack track = straighten_spline(times, rows);
  ASSERT_EQ(track.times.size(), track.values.size());
  EXPECT_TRUE(std::is_sorted(track.times.begin(), track.times.end()));
  for (double t = 0.0; t <= 2.0; t += 0.001) ASSERT_NEAR(value_at_time(track, t), t * t * t, 8.0 / 256.0) << t;
  for (const double t : times) EXPECT_NEAR(value_at_time(track, t), t * t * t, 1e-12) << "keyframes stay";
}

TEST(Spline, AStraightOneStaysTwoKeyframes) {
  const NumberTrack track = straighten_spline({1.0, 3.0}, {{0, 2}, {5, 5}, {1, 2}, {1, 2}, {7, 9}, {0, 0}});
  EXPECT_EQ(track.times, (std::vector<double>{1.0, 3.0}));
  EXPECT_EQ(track.values, (std::vector<std::vector<double>>{{5, 5}, {7, 9}}));
}

TEST(Spline, OneKeyframeOrNoChangeIsLeftAlone) {
  EXPECT_EQ(straighten_spline({2.0}, {{9}, {4}, {9}}).values, (std::vector<std::vector<double>>{{4}}));
  EXPECT_EQ(straighten_spline({0.0, 1.0}, {{0}, {4}, {0}, {0}, {4}, {0}}).times.size(), 2U);
}

TEST(Spline, HasAtMostTheLargestNumberOfPieces) {
  const NumberTrack track = straighten_spline({0.0, 1.0}, {{0}, {0}, {1e9}, {-1e9}, {1}, {0}});
  EXPECT_EQ(track.times.size(), 1U + kMaxPieces);
}

}  // namespace
}  // namespace hapton::gltf
