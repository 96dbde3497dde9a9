#include "core/geometry/convex_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

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

// The bodies of this file are 1 to 3 units large. A concavity of this size is above rounding, and far below every notch.
constexpr double kNoConcavity = 1e-9;
// The largest number of pieces in most tests: more than a convex body or a block needs.
constexpr std::size_t kManyPieces = 64;

std::vector<Vec3> make_random_directions(std::size_t count) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  std::vector<Vec3> directions;
  while (directions.size() < count) directions.push_back(Vec3(normal(random), normal(random), normal(random)).normalized());
  return directions;
}

// True: a plane normal to one of the directions separates `p` from the piece, so `p` is outside its hull. False: `p` is within the hull, or
// outside but near it; the number of directions (a free choice) decides how near.
bool is_separated(const ConvexPiece& piece, const Vec3& p) {
  static const std::vector<Vec3> directions = make_random_directions(300);
  constexpr double kRoundingBound = 1e-12;  // coordinates are below 2, so the error of a scalar product is below 1e-14
  return std::ranges::any_of(directions, [&](const Vec3& direction) {
    double farthest = direction.dot(piece.front());
    for (const Vec3& point : piece) farthest = std::max(farthest, direction.dot(point));
    return direction.dot(p) > farthest + kRoundingBound;
  });
}

TEST(ConvexPieces, AConvexBodyIsOnePiece) {
  EXPECT_EQ(split_into_convex(made::box({0, 0, 0}, {1, 2, 3}), kNoConcavity, kManyPieces).size(), 1U);
  EXPECT_EQ(split_into_convex(made::sphere(1.0, 12), kNoConcavity, kManyPieces).size(), 1U);
}

TEST(ConvexPieces, ACornerBlockIsCutAlongItsWall) {
  const auto pieces = split_into_convex(corner_block(), kNoConcavity, kManyPieces);
  ASSERT_EQ(pieces.size(), 2U);
  double volume = 0.0;
  for (const ConvexPiece& piece : pieces) {
    Eigen::AlignedBox3d box;  // each piece is a box
    for (const Vec3& point : piece) box.extend(point);
    volume += box.volume();
  }
  EXPECT_NEAR(volume, 3.0, 1e-12);  // a square of side 2 without one of side 1
}

TEST(ConvexPieces, TheyAreTheSolidUpToTheBound) {
  // A sphere of radius 1 whose surface has waves, 0.1 high and 0.1 deep.
  constexpr double kWaves = 0.1;
  const TriangleMesh mesh = made::sphere(1.0, 24, kWaves);
  const PointInMesh solid(mesh);
  constexpr double kAllowedConcavity = 0.1;  // half of the height between a trough and a crest
  constexpr std::size_t kMostPieces = 1000;
  const auto pieces = split_into_convex(mesh, kAllowedConcavity, kMostPieces);
  EXPECT_GT(pieces.size(), 4U);           // the sphere has more troughs than that, on all sides
  EXPECT_LT(pieces.size(), kMostPieces);  // the concavity ended the splitting, not the number of pieces
  // The whole surface is covered: each vertex is a point of a piece, and the middle of each triangle is within a hull.
  for (const Vec3& vertex : mesh.vertices) {
    const auto has_vertex = [&](const ConvexPiece& piece) { return std::ranges::find(piece, vertex) != piece.end(); };
    EXPECT_TRUE(std::ranges::any_of(pieces, has_vertex)) << vertex.transpose();
  }
  const auto is_covered = [&](const Vec3& p) {
    return std::ranges::any_of(pieces, [&](const ConvexPiece& piece) { return !is_separated(piece, p); });
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0;
    EXPECT_TRUE(is_covered(middle)) << middle.transpose();
  }
  // Points in a cube around the solid. The concavity is a height above the plane of a triangle. Beside an edge, the distance from the
  // surface may be larger than that: by a factor of less than 2 where the normals of the two triangles differ by less than 120 degrees.
  constexpr double kFarDistance = 2.0 * kAllowedConcavity;
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> coordinate(-(1.0 + kWaves), 1.0 + kWaves);
  int far_points = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p(coordinate(random), coordinate(random), coordinate(random));
    if (solid.is_inside(p) || solid.compute_distance(p) < kFarDistance) continue;
    ++far_points;
    EXPECT_FALSE(is_covered(p)) << p.transpose();
  }
  EXPECT_GT(far_points, 500);  // a quarter of the points; the corners of the cube that are so far away are a third of it
}

// A cube of side 2 from six separate faces, each of squares x squares squares, turned so that no face is normal to an axis.
TriangleMesh tilted_cube(int squares) {
  constexpr double kHalfSide = 1.0;
  const Mat3 tilt = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  TriangleMesh cube;
  for (int side = 0; side < 6; ++side) {
    const auto first = static_cast<std::uint32_t>(cube.vertices.size());
    const TriangleMesh sheet = made::sheet(kHalfSide, kHalfSide, squares);  // the top of the cube
    const double sign = side < 3 ? 1.0 : -1.0;  // of two coordinates, so that the sheet is turned and its normal still faces outwards
    for (const Vec3& p : sheet.vertices) {
      Vec3 turned;
      for (int k = 0; k < 3; ++k) turned[(k + side) % 3] = k == 0 ? p[0] : sign * p[k];
      cube.vertices.push_back(tilt * turned);
    }
    for (const auto& [a, b, c] : sheet.triangles) cube.triangles.push_back({first + a, first + b, first + c});
  }
  return cube;
}

// How many points and boxes are compared with a plane, per triangle, if the mesh is split into at most kManyPieces pieces.
double comparisons_per_triangle(const TriangleMesh& mesh, double max_concavity, std::size_t expected_pieces) {
  std::size_t compared = 0;
  EXPECT_EQ(split_into_convex(mesh, max_concavity, kManyPieces, &compared).size(), expected_pieces);
  return static_cast<double>(compared) / static_cast<double>(mesh.triangles.size());
}

// To compare all corners with all planes would take 3 comparisons per triangle for each triangle: 27,072 for the finest sphere, 36,864 for
// the finest cube. The limits do not grow with the fineness. Their values are free choices above what the code needs.
TEST(ConvexPieces, TheWorkIsNearLinearInTheTriangles) {
  for (const int bands : {12, 24, 48}) {
    EXPECT_LT(comparisons_per_triangle(made::sphere(1.0, bands, 0.1), 0.02, kManyPieces), 200.0) << bands;  // all levels of cuts together
    EXPECT_LT(comparisons_per_triangle(made::sphere(1.0, bands), 0.01, 1), 300.0) << bands;                 // as many planes as faces
  }
  // Few planes, each of many triangles.
  for (const int squares : {8, 16, 32}) EXPECT_LT(comparisons_per_triangle(tilted_cube(squares), kNoConcavity, 1), 20.0) << squares;
}

// With waves 0.3 high and this concavity, a sphere would need many more pieces.
TEST(ConvexPieces, NoMoreThanAreAllowed) {
  constexpr double kLittleConcavity = 1e-6;
  EXPECT_EQ(split_into_convex(made::sphere(1.0, 24, 0.3), kLittleConcavity, 10).size(), 10U);
  EXPECT_EQ(split_into_convex(made::sphere(1.0, 24, 0.3), kLittleConcavity, 1).size(), 1U);
}

}  // namespace
}  // namespace hapton
