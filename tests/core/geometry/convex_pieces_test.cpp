#include "core/geometry/convex_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>

#include "core/geometry/point_in_mesh.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

// An L-shaped block of height 1: the square [0, 2]^2 without the part where x and y are above 1.
TriangleMesh corner_block() {
  TriangleMesh mesh;
  for (const double z : {0.0, 1.0}) {
    for (const auto& [x, y] : {std::pair{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}) mesh.vertices.emplace_back(x, y, z);
  }
  for (const auto& [a, b, c] : {std::tuple{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    mesh.triangles.push_back({std::uint32_t(a), std::uint32_t(c), std::uint32_t(b)});
    mesh.triangles.push_back({std::uint32_t(a + 6), std::uint32_t(b + 6), std::uint32_t(c + 6)});
  }
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t j = (i + 1) % 6;
    mesh.triangles.push_back({i, j, j + 6});
    mesh.triangles.push_back({i, j + 6, i + 6});
  }
  return mesh;
}

// Whether `p` is within the hull of the piece: in none of 300 random directions does `p` lie farther than all points of the piece.
bool is_within(const ConvexPiece& piece, const Vec3& p) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 300; ++i) {
    const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
    double farthest = -1e9;
    for (const Vec3& point : piece) farthest = std::max(farthest, direction.dot(point));
    if (direction.dot(p) > farthest + 1e-12) return false;
  }
  return true;
}

TEST(ConvexPieces, AConvexBodyIsOnePiece) {
  EXPECT_EQ(split_into_convex(made::box({0, 0, 0}, {1, 2, 3}), 1e-9, 64).size(), 1U);
  EXPECT_EQ(split_into_convex(made::sphere(1.0, 12), 1e-9, 64).size(), 1U);
}

TEST(ConvexPieces, ACornerBlockIsCutAlongItsWall) {
  const auto pieces = split_into_convex(corner_block(), 1e-9, 64);
  ASSERT_EQ(pieces.size(), 2U);
  double volume = 0.0;
  for (const ConvexPiece& piece : pieces) {
    Eigen::AlignedBox3d box;  // each piece is a box
    for (const Vec3& point : piece) box.extend(point);
    volume += box.volume();
  }
  EXPECT_NEAR(volume, 3.0, 1e-12);
}

TEST(ConvexPieces, TheyAreTheSolidUpToTheBound) {
  // A ball with dents of a tenth of its radius.
  const TriangleMesh mesh = made::sphere(1.0, 24, 0.1);
  const PointInMesh solid(mesh);
  const double max_concavity = 0.1;
  const auto pieces = split_into_convex(mesh, max_concavity, 1000);
  EXPECT_GT(pieces.size(), 4U);
  EXPECT_LT(pieces.size(), 1000U);
  const auto is_covered = [&](const Vec3& p) {
    return std::ranges::any_of(pieces, [&](const ConvexPiece& piece) { return is_within(piece, p); });
  };
  for (const Vec3& vertex : mesh.vertices) EXPECT_TRUE(is_covered(vertex)) << vertex.transpose();
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> coordinate(-1.1, 1.1);
  int outside = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p(coordinate(random), coordinate(random), coordinate(random));
    if (solid.is_inside(p) || solid.compute_distance(p) < 2.0 * max_concavity) continue;
    ++outside;
    EXPECT_FALSE(is_covered(p)) << p.transpose();
  }
  EXPECT_GT(outside, 500);
}

// A cube of six separate faces, each of squares x squares squares, turned so that no face is perpendicular to an axis.
TriangleMesh tilted_cube(int squares) {
  const Mat3 tilt = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  TriangleMesh cube;
  for (int side = 0; side < 6; ++side) {
    const auto first = static_cast<std::uint32_t>(cube.vertices.size());
    const TriangleMesh sheet = made::sheet(1.0, 1.0, squares);
    const double sign = side < 3 ? 1.0 : -1.0;
    for (const Vec3& p : sheet.vertices) {
      Vec3 turned;
      for (int k = 0; k < 3; ++k) turned[(k + side) % 3] = k == 0 ? p[0] : sign * p[k];
      cube.vertices.push_back(tilt * turned);
    }
    for (const auto& [a, b, c] : sheet.triangles) cube.triangles.push_back({first + a, first + b, first + c});
  }
  return cube;
}

// How many points and boxes are compared with a plane, per triangle. All corners with all planes would be 3 times the triangles.
double comparisons_per_triangle(const TriangleMesh& mesh, double max_concavity, std::size_t pieces) {
  std::size_t compared = 0;
  EXPECT_EQ(split_into_convex(mesh, max_concavity, 64, &compared).size(), pieces);
  return static_cast<double>(compared) / static_cast<double>(mesh.triangles.size());
}

TEST(ConvexPieces, TheWorkIsNearLinearInTheTriangles) {
  for (const int bands : {12, 24, 48}) {
    EXPECT_LT(comparisons_per_triangle(made::sphere(1.0, bands, 0.1), 0.02, 64), 200.0) << bands;
    EXPECT_LT(comparisons_per_triangle(made::sphere(1.0, bands), 0.01, 1), 300.0) << bands;
  }
  for (const int squares : {8, 16, 32}) EXPECT_LT(comparisons_per_triangle(tilted_cube(squares), 1e-9, 1), 20.0) << squares;
}

TEST(ConvexPieces, NoMoreThanAreAllowed) {
  EXPECT_EQ(split_into_convex(made::sphere(1.0, 24, 0.3), 1e-6, 10).size(), 10U);
  EXPECT_EQ(split_into_convex(made::sphere(1.0, 24, 0.3), 1e-6, 1).size(), 1U);
}

}  // namespace
}  // namespace hapton
