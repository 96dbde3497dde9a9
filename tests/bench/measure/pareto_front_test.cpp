#include "bench/measure/pareto_front.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace hapton {
namespace {

using Indices = std::vector<std::size_t>;

TEST(ParetoFront, OfNothingIsEmpty) { EXPECT_TRUE(find_pareto_front({}).empty()); }

TEST(ParetoFront, KeepsWhatNoOtherBeats) { EXPECT_EQ(find_pareto_front({{3, 1}, {1, 3}, {2, 2}, {3, 3}, {2, 5}}), (Indices{1, 2, 0})); }

TEST(ParetoFront, EqualTimesKeepTheSmallerError) { EXPECT_EQ(find_pareto_front({{1, 2}, {1, 1}, {2, 1}}), (Indices{1})); }

TEST(ParetoFront, OfEqualPointsTheFirstStays) { EXPECT_EQ(find_pareto_front({{1, 1}, {1, 1}}), (Indices{0})); }

TEST(ParetoFront, LeavesOutValuesThatAreNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(find_pareto_front({{nan, 0}, {0, nan}, {0, infinity}, {5, 5}}), (Indices{3}));
}

TEST(ParetoFront, IsWhatTheDefinitionSays) {
  std::mt19937_64 random(7);
  std::uniform_int_distribution<int> draw(0, 20);
  std::vector<ParetoPoint> points(200);
  for (ParetoPoint& p : points) p = {static_cast<double>(draw(random)), static_cast<double>(draw(random))};
  const Indices front = find_pareto_front(points);
  const auto beats = [&](std::size_t a, std::size_t b) {
    const ParetoPoint& p = points[a];
    const ParetoPoint& q = points[b];
    return p.time <= q.time && p.error <= q.error && (p.time < q.time || p.error < q.error);
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    bool is_beaten = false;
    bool is_on_front = false;
    for (std::size_t j = 0; j < points.size(); ++j) is_beaten = is_beaten || beats(j, i);
    for (const std::size_t f : front) is_on_front = is_on_front || (points[f].time == points[i].time && points[f].error == points[i].error);
    EXPECT_EQ(is_on_front, !is_beaten) << i;
  }
}

}  // namespace
}  // namespace hapton
