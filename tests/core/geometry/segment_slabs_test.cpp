#include "core/geometry/segment_slabs.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

TEST(SegmentSlabs, MeetsABoxThatHoldsOneOfItsPoints) {
  std::mt19937_64 random(20261121);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto draw = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  std::size_t meeting = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 a = draw();
    const Vec3 b = draw();
    const Vec3 middle = draw();
    const Vec3 half = 0.5 * draw().cwiseAbs();
    bool holds_a_sample = false;
    for (int k = 0; k <= 1000; ++k) holds_a_sample |= ((a + k / 1000.0 * (b - a) - middle).cwiseAbs().array() <= half.array()).all();
    const bool meets = SegmentSlabs(a, b).meets(middle - half, middle + half);
    meeting += meets ? 1 : 0;
    EXPECT_TRUE(meets || !holds_a_sample) << i;
    // Each point of the segment is at most a thousandth of the segment's length from a sample.
    const Vec3 smaller_half = half - 2e-3 * Vec3::Ones();
    if (holds_a_sample || !(smaller_half.array() > 0.0).all()) continue;
    EXPECT_FALSE(SegmentSlabs(a, b).meets(middle - smaller_half, middle + smaller_half)) << i;
  }
  EXPECT_GT(meeting, 20U);
}

TEST(SegmentSlabs, AlongAnAxisAndOfNoLength) {
  const Vec3 low(0.0, 0.0, 0.0);
  const Vec3 high(1.0, 1.0, 1.0);
  EXPECT_TRUE(SegmentSlabs({0.5, 0.5, -1.0}, {0.5, 0.5, 2.0}).meets(low, high));
  EXPECT_FALSE(SegmentSlabs({1.5, 0.5, -1.0}, {1.5, 0.5, 2.0}).meets(low, high));
  EXPECT_FALSE(SegmentSlabs({0.5, 0.5, -2.0}, {0.5, 0.5, -1.0}).meets(low, high));
  EXPECT_TRUE(SegmentSlabs({0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}).meets(low, high));
  EXPECT_FALSE(SegmentSlabs({0.5, 0.5, 1.5}, {0.5, 0.5, 1.5}).meets(low, high));
}

}  // namespace
}  // namespace hapton
