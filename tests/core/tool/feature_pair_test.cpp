#include "core/tool/feature_pair.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/geometry/triangle_distance.h"
#include "tests/core/tool/feature_pair_fixture.h"

namespace hapton {
namespace {

double brute_force_distance(const FeaturePair& pair, const Placement& at) {
  const Vec3 a = at.at(pair.tool[0]);
  const Vec3 b = at.at(pair.tool[1]);
  const Vec3 c = at.at(pair.tool[2]);
  switch (pair.kind) {
    case FeaturePair::Kind::vertex_face:
      return std::sqrt(triangle_distance_squared(a, pair.scene[0], pair.scene[1], pair.scene[2]));
    case FeaturePair::Kind::face_vertex:
      return std::sqrt(triangle_distance_squared(pair.scene[0], a, b, c));
    case FeaturePair::Kind::edge_edge:
      break;
  }
  // The distances of dense samples of one edge from the other edge.
  double least = 1e300;
  for (int i = 0; i <= 2000; ++i) {
    const Vec3 p = a + i / 2000.0 * (b - a);
    const Vec3 e = pair.scene[1] - pair.scene[0];
    const double t = std::clamp((p - pair.scene[0]).dot(e) / e.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (p - pair.scene[0] - t * e).norm());
  }
  return least;
}

TEST_F(FeaturePairTest, TheGapIsTheDistance) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  for (int n = 0; n < 600; ++n) {
    const FeaturePair pair = draw_pair(kKinds[n % 3]);
    const Placement at = draw_placement();
    const FeatureGap gap = measure_gap(pair, at);
    const double expected = brute_force_distance(pair, at);
    ASSERT_LE(gap.distance, expected + 1e-12) << n;
    ASSERT_GE(gap.distance, expected - (pair.kind == Kind::edge_edge ? 1e-6 : 1e-12)) << n;
    ASSERT_LE((at.position + gap.on_tool - gap.on_scene - gap.distance * gap.normal).norm(), 1e-12) << n;
  }
}

TEST_F(FeaturePairTest, GapsAlongAMotionAreThoseAfterItToSecondOrder) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  int interior_pairs = 0;
  for (int n = 0; n < 3000; ++n) {
    const FeaturePair pair = draw_pair(kKinds[n % 3]);
    const Placement from = draw_placement();
    const FeatureGap gap = measure_gap(pair, from);
    const Placement to = RigidMotion{from, draw(1e-5), draw(1e-5)}.at(1.0);
    const FeatureGap gap_after = measure_gap(pair, to);
    if (gap.feature != TriangleFeature::face || gap_after.feature != TriangleFeature::face || gap.distance < 0.01) continue;
    ++interior_pairs;
    ASSERT_NEAR(gap_along(pair, gap, from, to), gap_after.distance, 1e-7) << "case " << n;
  }
  EXPECT_GT(interior_pairs, 100);
}

// Compared with second-order differences, whose error is of fourth order in the motion.
TEST_F(FeaturePairTest, TheCurvatureIsTheSecondDerivativeAlongAnyMotion) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  constexpr double kSize = 0x1p-12;
  int interior_pairs = 0;
  for (int n = 0; n < 6000; ++n) {
    const FeaturePair pair = draw_pair(kKinds[n % 3]);
    const Placement from = draw_placement();
    const FeatureGap gap = measure_gap(pair, from);
    const Vec3 d = (from.orientation * (pair.tool[1] - pair.tool[0])).normalized();
    const Vec3 e = (pair.scene[1] - pair.scene[0]).normalized();
    if (gap.distance < 0.01 || d.cross(e).norm() < 0.25) continue;
    interior_pairs += gap.feature == TriangleFeature::face ? 1 : 0;
    const RigidMotion motion{from, draw(kSize), draw(kSize)};
    const double second_difference =
        gap_along(pair, gap, from, motion.at(1.0)) + gap_along(pair, gap, from, motion.at(-1.0)) - 2.0 * gap.distance;
    Eigen::Matrix<double, 6, 1> motion_coordinates;
    motion_coordinates << motion.shift, motion.turn;
    const Mat6 curvature = gap_curvature(pair, gap, from);
    ASSERT_NEAR(second_difference, motion_coordinates.dot(curvature * motion_coordinates), 1e-3 * kSize * kSize) << "case " << n;
    ASSERT_TRUE(curvature.isApprox(curvature.transpose())) << "case " << n;
  }
  EXPECT_GT(interior_pairs, 500);
}

}  // namespace
}  // namespace hapton
