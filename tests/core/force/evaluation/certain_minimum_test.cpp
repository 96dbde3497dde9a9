#include "core/force/evaluation/certain_minimum.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr double kEdgeSphereRadius = 1e-6;
constexpr double kCertainOffset = 1e-7;

// Two strips that meet along the y axis; each rises by `slope` away from it.
TriangleMesh make_concave_edge(double slope) {
  TriangleMesh mesh;
  mesh.vertices = {{0, -1, 0}, {0, 1, 0}, {-1, 0, slope}, {1, 0, slope}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}};
  return mesh;
}

// Three faces at right angles, seen from inside, that meet at the origin.
TriangleMesh make_corner() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}};
  return mesh;
}

bool is_certain_minimum(const TriangleMesh& mesh, const Vec3& proxy, const Vec3& device, double radius) {
  TriangleBoxes boxes(mesh.vertices, mesh.triangles);
  return is_certain_minimum(mesh, boxes, proxy, device, radius);
}

const Vec3 kAboveEdge(0.0, 0.2, kCertainOffset);
const Vec3 kInCorner = Vec3::Constant(kCertainOffset);

TEST(CertainMinimum, AConcaveEdgeHoldsAProxyPulledStraightIntoIt) {
  EXPECT_TRUE(is_certain_minimum(make_concave_edge(0.3), kAboveEdge, {0.0, 0.2, -0.5}, kEdgeSphereRadius));
  EXPECT_TRUE(is_certain_minimum(make_concave_edge(0.3), kAboveEdge, {0.1, 0.2, -0.5}, kEdgeSphereRadius));
}

TEST(CertainMinimum, AConcaveEdgeDoesNotHoldAProxyPulledAlongIt) {
  EXPECT_FALSE(is_certain_minimum(make_concave_edge(0.3), kAboveEdge, {0.0, 0.3, -0.5}, kEdgeSphereRadius));
}

TEST(CertainMinimum, AConcaveEdgeDoesNotHoldAProxyPulledUpOneSide) {
  EXPECT_FALSE(is_certain_minimum(make_concave_edge(0.3), kAboveEdge, {0.3, 0.2, -0.5}, kEdgeSphereRadius));
}

TEST(CertainMinimum, ABalancedConvexEdgeIsNoMinimum) {
  EXPECT_FALSE(is_certain_minimum(make_concave_edge(-0.3), kAboveEdge, {0.0, 0.2, -0.5}, kEdgeSphereRadius));
  EXPECT_FALSE(is_certain_minimum(make_concave_edge(-1e-9), kAboveEdge, {0.0, 0.2, -0.5}, kEdgeSphereRadius));
}

TEST(CertainMinimum, ACornerOfThreeWallsHolds) {
  EXPECT_TRUE(is_certain_minimum(make_corner(), kInCorner, {-0.1, -0.2, -0.3}, kEdgeSphereRadius));
  EXPECT_FALSE(is_certain_minimum(make_corner(), kInCorner, {0.1, -0.2, -0.3}, kEdgeSphereRadius));
}

TEST(CertainMinimum, AnOpenBoundaryWithinTheRadiusProvesNothing) {
  TriangleMesh mesh = make_corner();
  mesh.triangles.pop_back();
  EXPECT_FALSE(is_certain_minimum(mesh, kInCorner, {-0.1, -0.2, -0.3}, kEdgeSphereRadius));
}

TEST(CertainMinimum, ThreeFacesAtOneEdgeProveNothing) {
  TriangleMesh mesh = make_concave_edge(0.3);
  mesh.vertices.push_back({0, 0, -1});
  mesh.triangles.push_back({0, 1, 4});
  EXPECT_FALSE(is_certain_minimum(mesh, kAboveEdge, {0.0, 0.2, -0.5}, kEdgeSphereRadius));
}

TEST(CertainMinimum, TheMiddleOfAFaceHoldsOnlyWhatIsStraightBelow) {
  const TriangleMesh mesh = make_corner();
  EXPECT_TRUE(is_certain_minimum(mesh, {0.3, 0.3, kCertainOffset}, {0.3, 0.3, -0.2}, kEdgeSphereRadius));
  EXPECT_FALSE(is_certain_minimum(mesh, {0.3, 0.3, kCertainOffset}, {0.31, 0.3, -0.2}, kEdgeSphereRadius));
}

TEST(CertainMinimum, FarFromEverythingNothingHolds) {
  EXPECT_FALSE(is_certain_minimum(make_concave_edge(0.3), {0.0, 0.2, 0.5}, {0.0, 0.2, -0.5}, kEdgeSphereRadius));
}

TEST(CertainMinimum, ASaddleIsNotProvedByItsConcaveEdges) {
  // Four faces at the origin: concave edges along x, convex edges along y.
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0.3}, {0, 1, -0.3}, {-1, 0, 0.3}, {0, -1, -0.3}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}};
  EXPECT_FALSE(is_certain_minimum(mesh, {0.0, 0.0, kCertainOffset}, {0.0, 0.0, -0.5}, kEdgeSphereRadius));
}

}  // namespace
}  // namespace hapton
