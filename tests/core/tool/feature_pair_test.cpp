#include "core/tool/feature_pair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/geometry/triangle_distance.h"

namespace hapton {
namespace {

using Kind = FeaturePair::Kind;

class FeaturePairTest : public testing::Test {
 protected:
  static constexpr unsigned kSeed = 1996;
  std::mt19937_64 random{kSeed};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};

  Vec3 draw(double size) { return size * Vec3(uniform(random), uniform(random), uniform(random)); }
  FeaturePair draw_pair(Kind kind) {
    FeaturePair pair;
    pair.kind = kind;
    for (int k = 0; k < 3; ++k) {
      pair.tool[k] = draw(0.3);
      pair.scene[k] = draw(0.3);
    }
    return pair;
  }
  static double brute_distance(const FeaturePair& pair, const Placement& at) {
    const Vec3 a = at.at(pair.tool[0]);
    const Vec3 b = at.at(pair.tool[1]);
    const Vec3 c = at.at(pair.tool[2]);
    switch (pair.kind) {
      case Kind::vertex_face:
        return std::sqrt(triangle_distance_squared(a, pair.scene[0], pair.scene[1], pair.scene[2]));
      case Kind::face_vertex:
        return std::sqrt(triangle_distance_squared(pair.scene[0], a, b, c));
      case Kind::edge_edge:
        break;
    }
    // Dense samples of one edge against the other.
    double least = 1e300;
    for (int i = 0; i <= 2000; ++i) {
      const Vec3 p = a + i / 2000.0 * (b - a);
      const Vec3 e = pair.scene[1] - pair.scene[0];
      const double t = std::clamp((p - pair.scene[0]).dot(e) / e.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (p - pair.scene[0] - t * e).norm());
    }
    return least;
  }
  static bool is_left_to_its_ends(const FeaturePair& pair, const RigidMotion& motion, double floor) {
    const Vec3 d = motion.from.orientation * (pair.tool[1] - pair.tool[0]);
    const Vec3 e = pair.scene[1] - pair.scene[0];
    const double sine = d.normalized().cross(e.normalized()).norm();
    return std::min(d.norm(), e.norm()) * (sine + motion.turn.norm()) <= 0.26 * floor;
  }
  Placement draw_placement() { return {draw(0.2), turn_by(draw(2.0))}; }
};

constexpr std::array kKinds = {Kind::vertex_face, Kind::face_vertex, Kind::edge_edge};

TEST_F(FeaturePairTest, TheGapIsTheDistance) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  for (int n = 0; n < 600; ++n) {
    const FeaturePair pair = draw_pair(kKinds[n % 3]);
    const Placement at = draw_placement();
    const FeatureGap gap = measure_gap(pair, at);
    const double brute = brute_distance(pair, at);
    ASSERT_LE(gap.distance, brute + 1e-12) << n;
    ASSERT_GE(gap.distance, brute - (pair.kind == Kind::edge_edge ? 1e-6 : 1e-12)) << n;
    ASSERT_LE((at.position + gap.on_tool - gap.on_scene - gap.distance * gap.normal).norm(), 1e-12) << n;
  }
}

// The safe time is safe: dense samples of the motion keep the floor. And it is of use: most motions that keep it are found to.
TEST_F(FeaturePairTest, NoMotionComesBelowItsFloorBeforeTheSafeTime) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  int keeps = 0;
  int found = 0;
  int shortened = 0;
  for (int n = 0; n < 6000; ++n) {
    const FeaturePair pair = draw_pair(kKinds[n % 3]);
    const RigidMotion motion{draw_placement(), draw(0.2), draw(n % 2 == 0 ? 0.5 : 0.02)};
    const FeatureGap gap = measure_gap(pair, motion.from);
    const double floor = gap.distance * (0.05 + 0.9 * std::abs(uniform(random)));
    if (pair.kind == Kind::edge_edge && is_left_to_its_ends(pair, motion, floor)) continue;
    const double time = find_safe_time(pair, gap, motion, floor, 1.0);
    ASSERT_GE(time, 0.0);
    ASSERT_LE(time, 1.0);
    double least = gap.distance;
    for (int i = 0; i <= 50; ++i) {
      const double distance = measure_gap(pair, motion.at(time * i / 50.0)).distance;
      ASSERT_GE(distance, floor * (1.0 - 1e-6)) << "case " << n << " kind " << static_cast<int>(pair.kind) << " at " << i / 50.0;
    }
    for (int i = 0; i <= 200; ++i) least = std::min(least, measure_gap(pair, motion.at(i / 200.0)).distance);
    if (least > 1.01 * floor) {
      ++keeps;
      found += time >= 1.0 ? 1 : 0;
    } else {
      shortened += time < 1.0 ? 1 : 0;
    }
  }
  EXPECT_GT(shortened, 500);
  EXPECT_GT(found, keeps * 98 / 100) << "of " << keeps;
}

TEST_F(FeaturePairTest, GapsAlongAMotionAreThoseAfterItToSecondOrder) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  int inside = 0;
  for (int n = 0; n < 3000; ++n) {
    const FeaturePair pair = draw_pair(kKinds[n % 3]);
    const Placement from = draw_placement();
    const FeatureGap gap = measure_gap(pair, from);
    const Placement to = RigidMotion{from, draw(1e-5), draw(1e-5)}.at(1.0);
    const FeatureGap after = measure_gap(pair, to);
    if (gap.feature != TriangleFeature::face || after.feature != TriangleFeature::face || gap.distance < 0.01) continue;
    ++inside;
    ASSERT_NEAR(gap_along(pair, gap, from, to), after.distance, 1e-7) << "case " << n;
  }
  EXPECT_GT(inside, 100);
}

// Against differences of second order; what they leave out is of fourth order of the motion.
TEST_F(FeaturePairTest, TheCurvatureIsTheSecondDerivativeAlongAnyMotion) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  constexpr double kSize = 0x1p-12;
  int inside = 0;
  for (int n = 0; n < 6000; ++n) {
    const FeaturePair pair = draw_pair(kKinds[n % 3]);
    const Placement from = draw_placement();
    const FeatureGap gap = measure_gap(pair, from);
    const Vec3 d = (from.orientation * (pair.tool[1] - pair.tool[0])).normalized();
    const Vec3 e = (pair.scene[1] - pair.scene[0]).normalized();
    if (gap.distance < 0.01 || d.cross(e).norm() < 0.25) continue;
    inside += gap.feature == TriangleFeature::face ? 1 : 0;
    const RigidMotion motion{from, draw(kSize), draw(kSize)};
    const double second = gap_along(pair, gap, from, motion.at(1.0)) + gap_along(pair, gap, from, motion.at(-1.0)) - 2.0 * gap.distance;
    Eigen::Matrix<double, 6, 1> moved;
    moved << motion.shift, motion.turn;
    const Mat6 curvature = gap_curvature(pair, gap, from);
    ASSERT_NEAR(second, moved.dot(curvature * moved), 1e-3 * kSize * kSize) << "case " << n;
    ASSERT_TRUE(curvature.isApprox(curvature.transpose())) << "case " << n;
  }
  EXPECT_GT(inside, 500);
}

TEST_F(FeaturePairTest, ParallelEdgesAreLeftToTheirEnds) {
  FeaturePair pair;
  pair.kind = Kind::edge_edge;
  pair.tool = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3::Zero()};
  pair.scene = {Vec3(0.5, 0, -1e-6), Vec3(1.5, 0, -1e-6), Vec3::Zero()};
  const RigidMotion motion{{}, {0.0, 1e-3, 0.0}, Vec3::Zero()};
  EXPECT_EQ(find_safe_time(pair, measure_gap(pair, motion.from), motion, 7.5e-7, 1.0), 1.0);
}

}  // namespace
}  // namespace hapton
