#include "core/tool/separating_planes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/core/tool/random_vector.h"

namespace hapton {
namespace {

// A piece of the tool: points within `radius` of its middle, all in tool axes from the grip point.
struct ToolPiece {
  Vec3 middle;
  double radius;
  std::vector<Vec3> points;
};

class SeparatingPlanesTest : public testing::Test {
 protected:
  static constexpr unsigned kSeed = 31;
  static constexpr double kRadius = 0.3;  // of the tool
  std::mt19937_64 random{kSeed};
  std::uniform_real_distribution<double> uniform{0.0, 1.0};
  float found = 0.0F;  // gap

  ToolPiece draw_piece() {
    ToolPiece piece{0.9 * kRadius * uniform(random) * draw_in_cube(random).normalized(), 0.0, {}};
    piece.radius = std::min(kRadius - piece.middle.norm(), std::pow(10.0, -1.0 - 3.0 * uniform(random)));
    for (int k = 0; k < 8; ++k) piece.points.push_back(piece.middle + piece.radius * draw_in_cube(random).normalized());
    return piece;
  }
  static double height(const ToolPiece& piece, const Placement& at, const Vec3& normal) {
    double least = 1e300;
    for (const Vec3& p : piece.points) least = std::min(least, normal.dot(at.at(p)));
    return least;
  }
  static double height_over(const ToolPiece& piece, const RigidMotion& motion, const Vec3& normal) {
    double least = 1e300;
    for (double time = 0.0; time <= 1.0; time += 0.0625) least = std::min(least, height(piece, motion.at(time), normal));
    return least;
  }
};

// Planes put at one placement, judged over motions that begin elsewhere: none separates whose piece comes within the distance, and few of
// the others are lost.
TEST_F(SeparatingPlanesTest, NeverClaimMoreThanThePathsOfThePointsAllow) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  constexpr std::size_t kPieces = 64;
  std::size_t kept = 0;
  std::size_t lost = 0;
  std::size_t near = 0;
  for (int round = 0; round < 60; ++round) {
    SeparatingPlanes planes(kPieces, kRadius);
    const Placement start{draw_in_cube(random), turn_by(3.0 * draw_in_cube(random))};
    const double length = std::pow(10.0, -1.0 - 4.0 * uniform(random));
    std::vector<ToolPiece> pieces;
    std::vector<Vec3> normals;
    std::vector<double> ground;  // height of the scene's piece
    planes.begin(SweptMotion({start}), 0.0);
    for (std::size_t i = 0; i < kPieces; ++i) {
      pieces.push_back(draw_piece());
      normals.push_back(draw_in_cube(random).normalized());
      const double gap = length * std::pow(10.0, 1.0 - 3.0 * uniform(random));
      ground.push_back(height(pieces[i], start, normals[i]) - gap);
      planes.put(i, {normals[i], gap, start.orientation * pieces[i].middle, pieces[i].radius});
    }
    Placement at = start;
    for (int walk = 0; walk < 10; ++walk) {
      const RigidMotion motion{at, length * draw_in_cube(random), length / kRadius * draw_in_cube(random)};
      const double distance = 0.1 * length * uniform(random);
      planes.begin(SweptMotion(motion), distance);
      for (std::size_t i = 0; i < kPieces; ++i) {
        const double gap = height_over(pieces[i], motion, normals[i]) - ground[i];
        if (planes.separates(i, found)) {
          ASSERT_LE(found, height(pieces[i], at, normals[i]) - ground[i]);
          ASSERT_GT(gap, distance) << "round " << round << ", walk " << walk << ", piece " << i;
          ++kept;
        } else {
          // Lost: though far enough, by more than the piece's own turn and the curvature of the paths can tell.
          const double turned = RigidMotion{start, Vec3::Zero(), turn_between(start.orientation, motion.at(1.0).orientation)}.turn.norm();
          const double before = turn_between(start.orientation, at.orientation).norm();
          const double most = std::max(turned, before);
          const double unsure = 2.0 * pieces[i].radius * most + 2.0 * kRadius * most * most + 1e-5 * length;
          lost += most < 0.2 && gap > distance + unsure ? 1U : 0U;
          ++near;
        }
      }
      at = motion.at(0.5 * uniform(random));
    }
  }
  EXPECT_GT(kept, 5000U);
  EXPECT_GT(near, 5000U);
  EXPECT_EQ(lost, 0U);
}

// A small piece that slides by a hundred times its gap, at a right angle to the plane's normal.
TEST_F(SeparatingPlanesTest, ASlidingPieceKeepsItsPlane) {
  SeparatingPlanes planes(1, kRadius);
  const Placement start{Vec3(0.1, 0.2, 0.3), Quat::Identity()};
  planes.begin(SweptMotion({start}), 0.0);
  planes.put(0, {Vec3::UnitZ(), 1e-4, Vec3(0.1, 0.0, 0.0), 1e-3});
  planes.begin(SweptMotion({start, Vec3(1e-2, 1e-2, 0.0), Vec3::Zero()}), 0x1p-20);
  EXPECT_TRUE(planes.separates(0, found));
  planes.begin(SweptMotion({start, Vec3(1e-2, 1e-2, -0.98e-4), Vec3::Zero()}), 0x1p-20);
  EXPECT_TRUE(planes.separates(0, found));
  planes.begin(SweptMotion({start, Vec3(1e-2, 1e-2, -1e-4), Vec3::Zero()}), 0x1p-20);
  EXPECT_FALSE(planes.separates(0, found));
  // The arm goes down as the tool turns about y.
  planes.begin(SweptMotion({start, Vec3::Zero(), Vec3(0.0, 0.9e-3, 0.0)}), 0x1p-20);
  EXPECT_TRUE(planes.separates(0, found));
  planes.begin(SweptMotion({start, Vec3::Zero(), Vec3(0.0, 1.1e-3, 0.0)}), 0x1p-20);
  EXPECT_FALSE(planes.separates(0, found));
  planes.begin(SweptMotion({start, Vec3::Zero(), Vec3(0.0, -0.04, 0.0)}), 0x1p-20);
  EXPECT_TRUE(planes.separates(0, found));
}

TEST_F(SeparatingPlanesTest, APlaneThatIsTakenAwayOrTooOldSeparatesNothing) {
  SeparatingPlanes planes(2, kRadius);
  const SeparatingPlanes::Plane plane{Vec3::UnitZ(), 0.1, Vec3::Zero(), 1e-3};
  Placement at;
  planes.begin(SweptMotion({at}), 0.0);
  EXPECT_FALSE(planes.separates(0, found)) << "there is none yet";
  planes.put(0, plane);
  planes.put(1, plane);
  EXPECT_TRUE(planes.separates(0, found));
  planes.put(1, {});
  EXPECT_FALSE(planes.separates(1, found));
  for (std::uint64_t n = 1; n < SeparatingPlanes::kMostStarts; ++n) {
    at.position.x() += 1e-6;
    planes.begin(SweptMotion({at}), 0.0);
    ASSERT_TRUE(planes.separates(0, found)) << n;
  }
  at.position.x() += 1e-6;
  planes.begin(SweptMotion({at}), 0.0);
  EXPECT_FALSE(planes.separates(0, found));
}

// Where the bounds of second order end.
TEST_F(SeparatingPlanesTest, ALargeTurnLosesThePlane) {
  SeparatingPlanes planes(1, kRadius);
  planes.begin(SweptMotion({Placement()}), 0.0);
  planes.put(0, {Vec3::UnitZ(), 10.0, Vec3::Zero(), 1e-3});
  planes.begin(SweptMotion({Placement(), Vec3::Zero(), Vec3(0.2, 0.0, 0.0)}), 0.0);
  EXPECT_TRUE(planes.separates(0, found));
  planes.begin(SweptMotion({Placement(), Vec3::Zero(), Vec3(0.4, 0.0, 0.0)}), 0.0);
  EXPECT_FALSE(planes.separates(0, found));
}

}  // namespace
}  // namespace hapton
