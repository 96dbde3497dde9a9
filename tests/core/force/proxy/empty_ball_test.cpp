#include "core/force/proxy/empty_ball.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr double kRestOffset = 1e-6;
constexpr double kFar = 1e9;

class EmptyBallTest : public testing::Test {
 protected:
  double distance_by_brute_force(const Vec3& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t t = 0; t < geometry_.triangle_count(); ++t) least = std::min(least, geometry_.separation(t, p).distance);
    return least;
  }

  TriangleMesh mesh_ = make_bumpy_sphere(0.05, 0.1, 2000, 3);
  TouchGeometry geometry_{std::vector<const TriangleMesh*>{&mesh_}};
};

TEST_F(EmptyBallTest, NoTriangleIsInAnyBallFound) {
  constexpr unsigned kSeed = 20261122;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int balls_found = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p(unit(random), unit(random), unit(random));
    EmptyBall ball;
    const double radius = ball.find(geometry_, p, 0.01, kRestOffset, kFar);
    const double distance = distance_by_brute_force(p);
    ASSERT_LE(radius, std::max(0.0, distance - kRestOffset)) << p.transpose();
    // Not much smaller than it could be: the search skips triangles that are hardly nearer than the nearest one so far.
    const bool is_limited = radius == 0.0 || distance > 0.5;
    EXPECT_GE(radius, is_limited ? 0.0 : 0.7 * (distance - 2.0 * kRestOffset)) << p.transpose();
    balls_found += radius > 0.0 ? 1 : 0;
  }
  EXPECT_GT(balls_found, 1900);
}

TEST_F(EmptyBallTest, IsNoLargerThanItsLimit) {
  EmptyBall ball;
  const Vec3 outside = geometry_.to_local(Vec3(0.2, 0.0, 0.0));
  EXPECT_LE(ball.find(geometry_, outside, 1.0, kRestOffset, 0.125), 0.125);
  EXPECT_EQ(ball.find(geometry_, outside, 1.0, kRestOffset, -1.0), 0.0);
}

TEST_F(EmptyBallTest, HoldsWhatIsNearerThanItsRadiusUntilItIsLeft) {
  EmptyBall ball;
  EXPECT_FALSE(ball.exists());
  EXPECT_FALSE(ball.contains(Vec3::Zero()));
  const Vec3 centre_S(0.2, 0.0, 0.0);
  const Vec3 before_S = centre_S + Vec3(0.0, 0.0, 0.02);
  ball.enter(geometry_, centre_S, before_S, 0.5);
  const double radius_m = 0.5 * geometry_.unit_m();
  EXPECT_TRUE(ball.contains(centre_S + Vec3(0.0, 0.999 * radius_m, 0.0)));
  EXPECT_FALSE(ball.contains(centre_S + Vec3(0.0, 1.001 * radius_m, 0.0)));
  EXPECT_FALSE(ball.contains(Vec3::Constant(std::numeric_limits<double>::quiet_NaN())));
  const Vec3 later_S = centre_S + Vec3(0.01, 0.0, 0.0);
  EXPECT_EQ(ball.sample_before(), before_S);
  ball.note_sample(centre_S + Vec3(0.001, 0.0, 0.0), true);
  EXPECT_EQ(ball.sample_before(), before_S) << "it is also the sample before the corrected one";
  ball.note_sample(later_S - Vec3(0.001, 0.0, 0.0));
  EXPECT_EQ(ball.sample_before(), Vec3(centre_S + Vec3(0.001, 0.0, 0.0)));
  ball.note_sample(later_S, true);
  EXPECT_EQ(ball.sample_before(), Vec3(centre_S + Vec3(0.001, 0.0, 0.0)));
  EXPECT_EQ(ball.last_sample(), later_S);
  ball.leave(geometry_);
  EXPECT_FALSE(ball.exists());
  EXPECT_FALSE(ball.contains(centre_S));
}

TEST_F(EmptyBallTest, IsSearchedAgainOnlyAfterSomeMotion) {
  EmptyBall ball;
  EXPECT_TRUE(ball.is_due());
  const double radius = ball.find(geometry_, geometry_.to_local(Vec3(0.07, 0.0, 0.0)), 0.01, kRestOffset, kFar);
  ASSERT_GT(radius, 0.0);
  EXPECT_FALSE(ball.is_due());
  ball.note_motion(std::max(0.25 * radius, 0.04));
  EXPECT_TRUE(ball.is_due());
}

// The boxes of slanted triangles contain the device, but the triangles are far from it.
TEST_F(EmptyBallTest, AmongTooManyTrianglesThereIsNoneAndTheSearchIsBounded) {
  TriangleMesh slanted;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    for (int k = 0; k < 3; ++k) slanted.vertices.push_back(0.1 * Vec3::Unit(k) - Vec3::Constant(1e-6 * i));
    slanted.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const TouchGeometry crowd({&slanted});
  EmptyBall ball;
  EXPECT_EQ(ball.work(), 0);
  EXPECT_EQ(ball.find(crowd, crowd.to_local(Vec3::Constant(0.04)), 0.01, kRestOffset, kFar), 0.0);
  EXPECT_EQ(ball.work(), 257);  // 256 tests, and the one that exceeds this limit
  EXPECT_GT(ball.find(geometry_, geometry_.to_local(Vec3(0.07, 0.0, 0.0)), 0.01, kRestOffset, kFar), 0.0);
  EXPECT_GE(ball.work(), 1);
  EXPECT_LT(ball.work(), 64);
}

}  // namespace
}  // namespace hapton
