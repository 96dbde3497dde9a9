#include "core/geometry/boundary_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/geometry/closest_point.h"
#include "core/geometry/cracked_shapes.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

// Gives every triangle its own vertices and moves each of these towards the triangle's middle by a fraction of its distance.
TriangleMesh torn(const TriangleMesh& mesh, double share) {
  TriangleMesh apart;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vec3 middle = (mesh.corner(i, 0) + mesh.corner(i, 1) + mesh.corner(i, 2)) / 3.0;
    const auto first = static_cast<std::uint32_t>(apart.vertices.size());
    for (int k = 0; k < 3; ++k) apart.vertices.push_back(mesh.corner(i, k) + share * (middle - mesh.corner(i, k)));
    apart.triangles.push_back({first, first + 1, first + 2});
  }
  return apart;
}

TEST(BoundaryEdges, AClosedMeshHasNone) {
  const BoundaryEdges count = count_boundary_edges(make_icosphere(0.05, 2), 1e-4);
  EXPECT_EQ(count.open + count.cracks, 0U);
}

TEST(BoundaryEdges, OfASheetAreOpen) {
  const BoundaryEdges count = count_boundary_edges(make_plane_grid(0.1, 8), 1e-4);
  EXPECT_EQ(count.open, 32U);
  EXPECT_EQ(count.cracks, 0U);
}

TEST(BoundaryEdges, OfABodyTornApartAreCracks) {
  const TriangleMesh ball = make_icosphere(0.05, 2);
  const BoundaryEdges count = count_boundary_edges(torn(ball, 1e-6), 1e-4);
  EXPECT_EQ(count.cracks, 3 * ball.triangles.size());
  EXPECT_EQ(count.open, 0U);
}

TEST(BoundaryEdges, WiderThanTheWidthAreOpen) {
  const TriangleMesh ball = make_icosphere(0.05, 2);
  EXPECT_EQ(count_boundary_edges(torn(ball, 0.1), 1e-5).cracks, 0U);
}

// On the other side of the triangle's edge lie the halves of that edge, each in a triangle of its own.
TEST(BoundaryEdges, OfATJunctionAreCracks) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, 0, 0}, {0.5, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 4, 3}, {3, 4, 1}};
  const BoundaryEdges count = count_boundary_edges(mesh, 1e-3);
  EXPECT_EQ(count.cracks, 3U);
  EXPECT_EQ(count.open, 4U);
}

TEST(BoundaryEdges, AreTheSameFarFromTheOriginAndAtAnyScale) {
  TriangleMesh mesh = torn(make_icosphere(0.05, 1), 1e-4);
  for (Vec3& v : mesh.vertices) v = 1e-3 * v + Vec3(10.0, -10.0, 10.0);
  EXPECT_EQ(count_boundary_edges(mesh, 1e-7).open, 0U);
}

TEST(BoundaryEdges, IgnoreTrianglesThatRepeatAVertex) {
  TriangleMesh mesh = make_icosphere(0.05, 1);
  mesh.triangles.push_back({0, 0, 1});
  const BoundaryEdges count = count_boundary_edges(mesh, 1e-4);
  EXPECT_EQ(count.open + count.cracks, 0U);
}

// Compares each boundary edge with every other one.
std::size_t count_cracks_by_brute_force(const TriangleMesh& mesh, double width) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++sides[std::minmax(t[k], t[(k + 1) % 3])];
  }
  std::erase_if(sides, [](const auto& side) { return side.second != 1; });
  std::size_t cracks = 0;
  for (const auto& [edge, one] : sides) {
    const Vec3& a = mesh.vertices[edge.first];
    const Vec3& b = mesh.vertices[edge.second];
    const double radius = std::min(width, 0.05 * (b - a).norm());
    int found = 0;
    for (const double share : {0.25, 0.5, 0.75}) {
      found += std::any_of(sides.begin(), sides.end(), [&, &edge = edge](const auto& other) {
        const Vec3& from = mesh.vertices[other.first.first];
        const Vec3& to = mesh.vertices[other.first.second];
        return other.first != edge && closest_point(from, to, to, a + share * (b - a)).distance <= radius;
      });
    }
    cracks += found == 3 ? 1 : 0;
  }
  return cracks;
}

TEST(BoundaryEdges, AreTheOnesThatBruteForceFinds) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    for (const double size : {1.0, 0.1, 0.02}) {
      const TriangleMesh soup = made::soup(seed, 300, 1.0, size);
      for (const double width : {1e-3, 2e-2, 0.2}) {
        EXPECT_EQ(count_boundary_edges(soup, width).cracks, count_cracks_by_brute_force(soup, width))
            << seed << " " << size << " " << width;
      }
    }
    TriangleMesh ball = torn(make_icosphere(0.5, 2), 1e-3);
    for (std::size_t i = 0; i < ball.vertices.size(); i += 7) ball.vertices[i] *= 1.0 + 1e-3 * static_cast<double>(seed);
    for (const double width : {1e-4, 1e-3}) {
      EXPECT_EQ(count_boundary_edges(ball, width).cracks, count_cracks_by_brute_force(ball, width)) << seed << " " << width;
    }
  }
}

// The crack measured is as wide as the body was torn, whatever the width up to which cracks are searched for.
TEST(BoundaryEdges, TheWidestCrackIsMeasured) {
  const TriangleMesh ball = make_icosphere(0.5, 2);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    for (const double width : {1e-6, 1e-5, 1e-4}) {
      const TriangleMesh apart = scaled_and_moved(make_torn(ball, width), scale, Vec3::Zero());
      for (const double search_width : {2e-4, 1e-3, 1e-2}) {
        const BoundaryEdges count = count_boundary_edges(apart, scale * search_width);
        EXPECT_EQ(count.open, 0U);
        EXPECT_LE(count.widest_crack, scale * width) << width << " " << search_width;
        EXPECT_GT(count.widest_crack, 0.3 * scale * width) << width << " " << search_width;
      }
    }
  }
  EXPECT_EQ(count_boundary_edges(make_plane_grid(1.0, 3), 1e-3).widest_crack, 0.0);
}

// With triangles as large as the mesh, the work per edge grows with their number until it is cut off; has_given_up reports this.
TEST(BoundaryEdges, TheSearchIsCutOffForRandomTriangles) {
  const TriangleMesh soup = made::soup(5, 2000, 1.0, 1.0);
  const BoundaryEdges full = count_boundary_edges(soup, 1e-3);
  EXPECT_FALSE(full.has_given_up);
  EXPECT_GT(full.work, 20 * 3 * soup.triangles.size()) << "else the bound below says nothing";
  const BoundaryEdges limited = count_boundary_edges(soup, 1e-3, 20);
  EXPECT_TRUE(limited.has_given_up);
  EXPECT_LT(limited.work, 21 * 3 * soup.triangles.size());
  EXPECT_EQ(limited.open + limited.cracks, full.open + full.cracks) << "edges that were not examined count as open";
  EXPECT_LE(limited.cracks, full.cracks);
  EXPECT_FALSE(count_boundary_edges(torn(make_icosphere(0.5, 5), 1e-5), 1e-3, kMaxBoundaryWork / 2).has_given_up)
      << "the work for a surface is far below the limit";
}

// The work is counted, not timed: boxes and points examined per boundary edge, for triangles as large as the space that they are in, for
// triangles in one place, and for a torn surface.
TEST(BoundaryEdges, TakeAboutAsMuchWorkEachHoweverManyThereAre) {
  struct Case {
    const char* name;
    double space;
    double size;
    double max_growth;  // largest growth of the work per edge from 1,000 to 16,000 triangles; the cube root of 16 is 2.5
    double max_work;    // largest work per edge
  };
  constexpr double kWidth = 1e-3;
  for (const Case& c :
       {Case{"large", 1.0, 1.0, 2.7, 300.0}, Case{"in one spot", 1e-5, 1e-4, 2.7, 1000.0}, Case{"small", 1.0, 0.01, 2.0, 80.0}}) {
    const auto work = [&](int triangles) {
      const TriangleMesh soup = made::soup(5, triangles, c.space, c.size);
      return static_cast<double>(count_boundary_edges(soup, kWidth, 1'000'000).work) / static_cast<double>(3 * triangles);
    };
    const double work_of_few = work(1000);
    const double work_of_many = work(16000);
    EXPECT_LT(work_of_many, c.max_growth * work_of_few) << c.name;
    EXPECT_LT(work_of_many, c.max_work) << c.name;
  }
  const auto work_on_ball = [&](int level) {
    const TriangleMesh ball = torn(make_icosphere(0.5, level), 1e-5);
    return static_cast<double>(count_boundary_edges(ball, kWidth).work) / static_cast<double>(3 * ball.triangles.size());
  };
  EXPECT_LT(work_on_ball(5), 1.5 * work_on_ball(3));
  EXPECT_LT(work_on_ball(5), 150.0);
}

}  // namespace
}  // namespace hapton
