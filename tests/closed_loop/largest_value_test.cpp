#include "closed_loop/largest_value.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

// Searches for the largest value that is not above `edge`, and counts the values that it tries.
double find_edge(double edge, const ValueRange& range, double relative_width, int* trials = nullptr) {
  return find_largest_value(range, relative_width, [&](double value) {
    if (trials != nullptr) ++*trials;
    return value <= edge;
  });
}

TEST(LargestValue, FindsTheEdgeFromBelowToTheRelativeWidth) {
  for (const double relative_width : {0.1, 1e-3, 1e-9}) {
    for (const double edge : {0.02, 9.99, 10.0, 10.01, 13.0, 777.0, 1e6}) {
      const double found = find_edge(edge, {.first = 10.0, .least = 0.01}, relative_width);
      EXPECT_LE(found, edge);
      EXPECT_GE(found, (1.0 - relative_width) * edge) << edge;
    }
  }
}

TEST(LargestValue, EndsAtTheRangesLimits) {
  // 505 is above the limit of 500, but below 10 * 1.3^15, the first value above the limit that the search would try.
  for (const double edge : {1e9, 505.0}) EXPECT_EQ(find_edge(edge, {.first = 10.0, .least = 0.01, .most = 500.0}, 1e-3), 500.0) << edge;
  EXPECT_EQ(find_edge(1.0, {.first = 10.0, .least = 10.0}, 1e-3), 0.0);
  int trials = 0;
  EXPECT_EQ(find_edge(0.0, {.first = 10.0, .least = 0.01}, 1e-3, &trials), 0.0);
  EXPECT_LT(trials, 15);
}

TEST(LargestValue, BisectsBetweenKnownEnds) {
  const double low = bisect(2.0, 5.0, 1e-6, [](double value) { return value < 3.25; });
  EXPECT_LT(low, 3.25);
  EXPECT_GT(low, 3.25 * (1.0 - 1e-6));
}

}  // namespace
}  // namespace hapton
