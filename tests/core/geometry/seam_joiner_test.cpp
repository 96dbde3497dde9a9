#include "core/geometry/seam_joiner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr double kTolerance = 1e-3;
constexpr std::size_t kPlentyOfWork = 1000000;

// Two rows of squares with a gap between, one of `below` and one of `above` squares; vertices of the lower row come first.
TriangleMesh two_rows(int below, int above, double gap) {
  TriangleMesh mesh;
  const auto add_row = [&](int count, double y) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int i = 0; i <= count; ++i) {
      mesh.vertices.emplace_back(static_cast<double>(i) / count, y, 0.0);
      mesh.vertices.emplace_back(static_cast<double>(i) / count, y + 1.0, 0.0);
    }
    for (std::uint32_t i = first; i < first + 2 * static_cast<std::uint32_t>(count); i += 2) {
      mesh.triangles.push_back({i, i + 2, i + 3});
      mesh.triangles.push_back({i, i + 3, i + 1});
    }
  };
  add_row(below, 0.0);
  add_row(above, 1.0 + gap);
  return mesh;
}

TEST(SeamJoiner, JoinsVerticesFirstAndThenTJunctions) {
  TriangleMesh mesh = two_rows(2, 3, 0.5 * kTolerance);
  SeamParts excluded;
  SeamJoiner joiner(mesh, find_boundary_vertices(mesh), kTolerance, excluded);
  EXPECT_TRUE(joiner.run(kPlentyOfWork));
  EXPECT_EQ(joiner.boundary_edges(), 14U);  // 6 of the lower row, 8 of the upper one
  EXPECT_EQ(joiner.seam().welded(), 2U);    // the ends of the gap
  EXPECT_EQ(joiner.seam().splits(), 3U);    // one edge above, two edges below
  EXPECT_EQ(joiner.seam().zipped(), 4U);
  EXPECT_EQ(joiner.seam().boundary_edges().size(), 9U);  // all but 2 below and 3 above the gap
  EXPECT_NEAR(joiner.widest_gap(), 0.5 * kTolerance, 1e-12);
  EXPECT_EQ(excluded.size(), 0U);
  EXPECT_EQ(joiner.joined().chords.size(), 3U);
}

TEST(SeamJoiner, LeavesExcludedVerticesAlone) {
  TriangleMesh mesh = two_rows(1, 1, 0.5 * kTolerance);
  SeamParts excluded{.vertices = {1}, .chords = {}};
  SeamJoiner joiner(mesh, find_boundary_vertices(mesh), kTolerance, excluded);
  EXPECT_TRUE(joiner.run(kPlentyOfWork));
  EXPECT_EQ(joiner.seam().welded(), 1U);  // 3 and 6, not 1 and 4
  EXPECT_EQ(joiner.seam().representative_of(4), 4U);
  EXPECT_TRUE(joiner.seam().representative_of(6) == 3U || joiner.seam().representative_of(3) == 6U);
}

// The corners of three triangles lie in a row at one place: the outer two are too far apart to be welded to one another, but both are near
// enough to the middle one.
TEST(SeamJoiner, WeldsAtTheVertexThatIsNearAllOthers) {
  const double step = 0.7 * kTolerance;
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0},    {1, 0, 0},     {0.5, 0.9, 0},  // each triangle is about a sixth of a hexagon
                   {0, 0, step}, {0.5, 0.9, 0}, {-0.5, 0.9, 0}, {0, 0, 2.0 * step}, {-0.5, 0.9, 0}, {-1, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};
  SeamParts excluded;
  SeamJoiner joiner(mesh, find_boundary_vertices(mesh), kTolerance, excluded);
  EXPECT_TRUE(joiner.run(kPlentyOfWork));
  EXPECT_EQ(joiner.seam().zipped(), 2U);
  for (const std::uint32_t v : {0U, 3U, 6U}) EXPECT_EQ(joiner.seam().position(joiner.seam().representative_of(v)), Vec3(0, 0, step));
  EXPECT_EQ(excluded.size(), 0U);
}

// A plate torn in two by a gap wider than the plate is thick: its upper and lower sides are within the tolerance of each other, the two
// halves of one side are not.
TEST(SeamJoiner, DoesNotJoinTheSidesOfASheetAcrossItsCracks) {
  const auto sheet = [](double gap) {
    const TriangleMesh low = two_rows(2, 3, gap);
    return joined(low, flipped(scaled_and_moved(low, 1.0, Vec3(0.0, 0.0, 0.3 * kTolerance))));
  };
  for (const double gap : {1.2, 2.0, 3.0}) {
    TriangleMesh mesh = sheet(gap * kTolerance);
    SeamParts excluded;
    SeamJoiner joiner(mesh, find_boundary_vertices(mesh), kTolerance, excluded);
    EXPECT_TRUE(joiner.run(kPlentyOfWork));
    // Inner vertices of the crack; at its ends the rims are joined. The vertices of the upper side begin at 14.
    for (const std::uint32_t crack_vertex : {3U, 8U, 10U}) {
      EXPECT_EQ(joiner.seam().representative_of(crack_vertex), crack_vertex) << gap;
      EXPECT_EQ(joiner.seam().representative_of(14 + crack_vertex), 14 + crack_vertex) << gap;
    }
    EXPECT_EQ(joiner.seam().splits(), 0U) << gap;
  }
  TriangleMesh narrow = sheet(0.1 * kTolerance);
  SeamParts excluded;
  SeamJoiner joiner(narrow, find_boundary_vertices(narrow), kTolerance, excluded);
  EXPECT_TRUE(joiner.run(kPlentyOfWork));
  EXPECT_EQ(joiner.seam().splits(), 6U) << "each side is closed with itself";
}

TEST(SeamJoiner, ExcludesAnEdgeThatWouldBeZippedTooFar) {
  // A long edge from a tip, and from the same tip a row of vertices that diverges slowly: the last is 5 tolerances away.
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0.5, -1, 0}, {0.5, 1, 0}};
  mesh.triangles = {{1, 0, 2}};
  std::uint32_t last = 0;
  for (int i = 1; i <= 50; ++i) {
    mesh.vertices.emplace_back(0.02 * i, 0.1 * kTolerance * i, 0.0);
    const auto next = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
    mesh.triangles.push_back({last, next, 3});
    last = next;
  }
  SeamParts excluded;
  TriangleMesh first = mesh;
  SeamJoiner(first, find_boundary_vertices(mesh), kTolerance, excluded).run(kPlentyOfWork);
  ASSERT_EQ(excluded.chords, (std::unordered_set<std::uint32_t>{0}));
  TriangleMesh second = mesh;
  SeamJoiner second_joiner(second, find_boundary_vertices(mesh), kTolerance, excluded);
  EXPECT_TRUE(second_joiner.run(kPlentyOfWork));
  EXPECT_EQ(second_joiner.seam().splits(), 0U);
  EXPECT_EQ(second_joiner.seam().welded(), 0U);
}

// A crack from a tip, among hundreds of long edges that pass between its vertices: so many that the tree no longer tests these vertices.
// The edges at the tip are compared with one another nevertheless.
TEST(SeamJoiner, ClosesACrackFromItsTipWhereHundredsOfEdgesPass) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const std::array<Vec3, 5> crack = {Vec3(0, 0, 0), {1, 0, 0}, {0.5, -1, 0}, {0.5, 0.5 * kTolerance, 0}, {0.25, 1, 0}};
    TriangleMesh mesh;
    while (mesh.triangles.size() < 800) {
      const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
      const Vec3 through = Vec3(0.4, 0, 0) + 0.2 * Vec3(normal(random), normal(random), normal(random));
      const auto is_beside = [&](const Vec3& corner) { return (corner - through).cross(direction).norm() > 0.1; };
      if (!std::all_of(crack.begin(), crack.end(), is_beside)) continue;
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      const Vec3 aside = 0.02 * direction.unitOrthogonal();
      mesh.vertices.insert(mesh.vertices.end(), {through - 6.0 * direction, through + 6.0 * direction, through + 6.0 * direction + aside});
      mesh.triangles.push_back({first, first + 1, first + 2});
    }
    const auto tip = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), crack.begin(), crack.end());
    mesh.triangles.push_back({tip + 1, tip, tip + 2});
    mesh.triangles.push_back({tip, tip + 3, tip + 4});
    SeamParts excluded;
    SeamJoiner joiner(mesh, find_boundary_vertices(mesh), kTolerance, excluded);
    EXPECT_TRUE(joiner.run(kPlentyOfWork)) << seed;
    EXPECT_EQ(joiner.seam().splits(), 1U) << seed;
    EXPECT_EQ(joiner.seam().zipped(), 1U) << seed;
    EXPECT_EQ(joiner.joined().vertices.count(tip + 3), 1U) << seed;
  }
}

TEST(SeamJoiner, StopsAtItsWorkLimit) {
  TriangleMesh mesh = two_rows(20, 30, 0.5 * kTolerance);
  SeamParts excluded;
  EXPECT_FALSE(SeamJoiner(mesh, find_boundary_vertices(mesh), kTolerance, excluded).run(10));
  TriangleMesh again = two_rows(20, 30, 0.5 * kTolerance);
  SeamJoiner joiner(again, find_boundary_vertices(again), kTolerance, excluded);
  EXPECT_TRUE(joiner.run(kPlentyOfWork));
  EXPECT_LT(joiner.work(), 100 * joiner.boundary_edges());
}

// A trial split that was undone does not count as joined.
TEST(SeamJoiner, ReportsOnlyJoinsThatStay) {
  TriangleMesh mesh = two_rows(20, 30, 0.5 * kTolerance);
  SeamParts excluded;
  SeamJoiner joiner(mesh, find_boundary_vertices(mesh), kTolerance, excluded);
  EXPECT_TRUE(joiner.run(kPlentyOfWork));
  EXPECT_GT(joiner.joined().size(), 0U);
  TriangleMesh joined = mesh;
  SeamParts none;
  SeamJoiner second(joined, find_boundary_vertices(joined), kTolerance, none);
  EXPECT_TRUE(second.run(kPlentyOfWork));
  EXPECT_EQ(second.joined().size(), 0U);
}

}  // namespace
}  // namespace hapton
