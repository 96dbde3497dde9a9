#include "core/geometry/seam_joiner.h"

#include <gtest/gtest.h>

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
  JoinedParts untouched;
  SeamJoiner joiner(mesh, find_boundary_vertices(mesh), kTolerance, untouched);
  EXPECT_TRUE(joiner.run(kPlentyOfWork));
  EXPECT_EQ(joiner.boundary_edges(), 14U);
  EXPECT_EQ(joiner.seam().welded(), 2U);  // the ends
  EXPECT_EQ(joiner.seam().splits(), 3U);  // one above, two below
  EXPECT_EQ(joiner.seam().zipped(), 4U);
  EXPECT_EQ(joiner.seam().boundary_edges().size(), 9U);
  EXPECT_NEAR(joiner.widest_gap(), 0.5 * kTolerance, 1e-12);
  EXPECT_EQ(untouched.size(), 0U);
  EXPECT_EQ(joiner.joined().chords.size(), 3U);
}

TEST(SeamJoiner, LeavesTheUntouchedAlone) {
  TriangleMesh mesh = two_rows(1, 1, 0.5 * kTolerance);
  JoinedParts untouched{.vertices = {1}, .chords = {}};
  SeamJoiner joiner(mesh, find_boundary_vertices(mesh), kTolerance, untouched);
  EXPECT_TRUE(joiner.run(kPlentyOfWork));
  EXPECT_EQ(joiner.seam().welded(), 1U);  // 3 and 6, not 1 and 4
  EXPECT_EQ(joiner.seam().standing_for(4), 4U);
  EXPECT_TRUE(joiner.seam().standing_for(6) == 3U || joiner.seam().standing_for(3) == 6U);
}

TEST(SeamJoiner, PutsAnEdgeThatWouldBeZippedTooFarOnTheList) {
  // A long edge from a tip, and from the same tip a row of vertices that diverges slowly: 5 tolerances off at the end.
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
  JoinedParts untouched;
  TriangleMesh first = mesh;
  SeamJoiner(first, find_boundary_vertices(mesh), kTolerance, untouched).run(kPlentyOfWork);
  ASSERT_EQ(untouched.chords, (std::unordered_set<std::uint32_t>{0}));
  TriangleMesh second = mesh;
  SeamJoiner again(second, find_boundary_vertices(mesh), kTolerance, untouched);
  EXPECT_TRUE(again.run(kPlentyOfWork));
  EXPECT_EQ(again.seam().splits(), 0U);
  EXPECT_EQ(again.seam().welded(), 0U);
}

TEST(SeamJoiner, StopsWhereItTakesMoreWorkThanItMay) {
  TriangleMesh mesh = two_rows(20, 30, 0.5 * kTolerance);
  JoinedParts untouched;
  EXPECT_FALSE(SeamJoiner(mesh, find_boundary_vertices(mesh), kTolerance, untouched).run(10));
  TriangleMesh again = two_rows(20, 30, 0.5 * kTolerance);
  SeamJoiner joiner(again, find_boundary_vertices(again), kTolerance, untouched);
  EXPECT_TRUE(joiner.run(kPlentyOfWork));
  EXPECT_LT(joiner.work(), 100 * joiner.boundary_edges());
}

// A trial split that was undone does not count as joined.
TEST(SeamJoiner, ReportsOnlyWhatStays) {
  TriangleMesh mesh = two_rows(20, 30, 0.5 * kTolerance);
  JoinedParts untouched;
  SeamJoiner joiner(mesh, find_boundary_vertices(mesh), kTolerance, untouched);
  EXPECT_TRUE(joiner.run(kPlentyOfWork));
  EXPECT_GT(joiner.joined().size(), 0U);
  TriangleMesh joined = mesh;
  JoinedParts none;
  SeamJoiner second(joined, find_boundary_vertices(joined), kTolerance, none);
  EXPECT_TRUE(second.run(kPlentyOfWork));
  EXPECT_EQ(second.joined().size(), 0U);
}

}  // namespace
}  // namespace hapton
