#include "core/force/evaluation/certain_rest.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr double kReach = 1e-6;
constexpr double kContactOffset = 1e-7;

// Two strips that meet along the y axis; each rises by `slope` away from it.
TriangleMesh make_fold(double slope) {
  TriangleMesh mesh;
  mesh.vertices = {{0, -1, 0}, {0, 1, 0}, {-1, 0, slope}, {1, 0, slope}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}};
  return mesh;
}

// The inside corner of a room, at the origin.
TriangleMesh make_corner() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}};
  return mesh;
}

const Vec3 kAboveFold(0.0, 0.2, kContactOffset);
const Vec3 kInCorner = Vec3::Constant(kContactOffset);

TEST(CertainRest, AFoldHoldsWhatIsDrawnStraightIntoIt) {
  EXPECT_TRUE(is_certain_rest(make_fold(0.3), kAboveFold, {0.0, 0.2, -0.5}, kReach));
  EXPECT_TRUE(is_certain_rest(make_fold(0.3), kAboveFold, {0.1, 0.2, -0.5}, kReach));
}

TEST(CertainRest, AFoldDoesNotHoldWhatIsDrawnAlongIt) {
  EXPECT_FALSE(is_certain_rest(make_fold(0.3), kAboveFold, {0.0, 0.3, -0.5}, kReach));
}

TEST(CertainRest, AFoldDoesNotHoldWhatIsDrawnUpOneSide) {
  EXPECT_FALSE(is_certain_rest(make_fold(0.3), kAboveFold, {0.3, 0.2, -0.5}, kReach));
}

TEST(CertainRest, ARidgeIsNoRestHoweverBalanced) {
  EXPECT_FALSE(is_certain_rest(make_fold(-0.3), kAboveFold, {0.0, 0.2, -0.5}, kReach));
  EXPECT_FALSE(is_certain_rest(make_fold(-1e-9), kAboveFold, {0.0, 0.2, -0.5}, kReach));
}

TEST(CertainRest, ACornerOfThreeWallsHolds) {
  EXPECT_TRUE(is_certain_rest(make_corner(), kInCorner, {-0.1, -0.2, -0.3}, kReach));
  EXPECT_FALSE(is_certain_rest(make_corner(), kInCorner, {0.1, -0.2, -0.3}, kReach));
}

TEST(CertainRest, AnOpenBorderWithinReachProvesNothing) {
  TriangleMesh mesh = make_corner();
  mesh.triangles.pop_back();
  EXPECT_FALSE(is_certain_rest(mesh, kInCorner, {-0.1, -0.2, -0.3}, kReach));
}

TEST(CertainRest, ThreeFacesAtOneEdgeProveNothing) {
  TriangleMesh mesh = make_fold(0.3);
  mesh.vertices.push_back({0, 0, -1});
  mesh.triangles.push_back({0, 1, 4});
  EXPECT_FALSE(is_certain_rest(mesh, kAboveFold, {0.0, 0.2, -0.5}, kReach));
}

TEST(CertainRest, TheMiddleOfAFaceHoldsOnlyWhatIsStraightBelow) {
  const TriangleMesh mesh = make_corner();
  EXPECT_TRUE(is_certain_rest(mesh, {0.3, 0.3, kContactOffset}, {0.3, 0.3, -0.2}, kReach));
  EXPECT_FALSE(is_certain_rest(mesh, {0.3, 0.3, kContactOffset}, {0.31, 0.3, -0.2}, kReach));
}

TEST(CertainRest, FarFromEverythingNothingHolds) {
  EXPECT_FALSE(is_certain_rest(make_fold(0.3), {0.0, 0.2, 0.5}, {0.0, 0.2, -0.5}, kReach));
}

TEST(CertainRest, ASaddleIsNotProvedByItsFolds) {
  // Four faces round the origin: folds along x, ridges along y.
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0.3}, {0, 1, -0.3}, {-1, 0, 0.3}, {0, -1, -0.3}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}};
  EXPECT_FALSE(is_certain_rest(mesh, {0.0, 0.0, kContactOffset}, {0.0, 0.0, -0.5}, kReach));
}

}  // namespace
}  // namespace hapton
