#include "core/geometry/repair_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <tuple>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

// As in STL: each triangle has three vertices of its own.
TriangleMesh unwelded(const TriangleMesh& mesh) {
  TriangleMesh loose;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto first = static_cast<std::uint32_t>(loose.vertices.size());
    for (int k = 0; k < 3; ++k) loose.vertices.push_back(mesh.corner(t, k));
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  return loose;
}

TEST(RepairMesh, LeavesACleanMeshAsItIs) {
  const TriangleMesh mesh = make_torus(1.0, 0.3, 20, 12);
  RepairReport report;
  std::vector<std::uint32_t> source;
  const TriangleMesh repaired = repair_mesh(mesh, report, &source);
  EXPECT_EQ(repaired.triangles, mesh.triangles);
  EXPECT_EQ(repaired.vertices.size(), mesh.vertices.size());
  EXPECT_EQ(report.welded_vertices + report.dropped_empty + report.dropped_duplicates + report.turned + report.boundary_edges +
                report.nonmanifold_edges + report.unorientable_pieces + report.double_faces,
            0U);
  EXPECT_EQ(report.pieces, 1U);
  for (std::uint32_t i = 0; i < source.size(); ++i) EXPECT_EQ(source[i], i);
}

TEST(RepairMesh, WeldsVerticesOfEqualBits) {
  const TriangleMesh mesh = make_icosphere(1.0, 2);
  RepairReport report;
  std::vector<std::uint32_t> vertex_source;
  const TriangleMesh loose = unwelded(mesh);
  const TriangleMesh repaired = repair_mesh(loose, report, nullptr, &vertex_source);
  EXPECT_EQ(repaired.vertices.size(), mesh.vertices.size());
  EXPECT_EQ(report.welded_vertices, loose.vertices.size() - mesh.vertices.size());
  EXPECT_TRUE(count_edges(repaired).closed());
  for (std::size_t i = 0; i < repaired.vertices.size(); ++i) EXPECT_EQ(repaired.vertices[i], loose.vertices[vertex_source[i]]);
}

TEST(RepairMesh, ZeroAndMinusZeroAreOnePosition) {
  const TriangleMesh mesh = {{Vec3(0.0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(-0.0, 0, 0), Vec3(0, -1, 0)}, {{0, 1, 2}, {3, 4, 1}}};
  RepairReport report;
  EXPECT_EQ(repair_mesh(mesh, report).vertices.size(), 4U);
}

TEST(RepairMesh, DropsEmptyAndDuplicateTrianglesAndKeepsTwoSidedSheets) {
  TriangleMesh mesh = make_box(Vec3(1, 1, 1));
  const std::size_t clean_triangles = mesh.triangles.size();
  const Triangle t = mesh.triangles[3];
  mesh.triangles.insert(mesh.triangles.begin() + 1, Triangle{t[0], t[0], t[1]});
  mesh.triangles.push_back({t[1], t[2], t[0]});  // the same triangle, starting at another vertex
  mesh.triangles.push_back({t[0], t[2], t[1]});  // the same triangle, with the opposite winding
  RepairReport report;
  std::vector<std::uint32_t> source;
  const TriangleMesh repaired = repair_mesh(mesh, report, &source);
  EXPECT_EQ(report.dropped_empty, 1U);
  EXPECT_EQ(report.dropped_duplicates, 1U);
  EXPECT_EQ(report.double_faces, 1U);
  EXPECT_EQ(report.nonmanifold_edges, 3U);
  ASSERT_EQ(repaired.triangles.size(), clean_triangles + 1);
  EXPECT_EQ(source[0], 0U);
  EXPECT_EQ(source[1], 2U);
}

TEST(RepairMesh, FlipsTheMinority) {
  TriangleMesh mesh = make_torus(1.0, 0.3, 20, 12);
  const double volume = compute_volume(mesh);
  std::mt19937 random(5);
  std::size_t turned = 0;
  for (Triangle& t : mesh.triangles) {
    if (random() % 3 != 0) continue;
    std::swap(t[0], t[1]);
    ++turned;
  }
  RepairReport report;
  const TriangleMesh repaired = repair_mesh(mesh, report);
  EXPECT_EQ(report.turned, turned);
  EXPECT_TRUE(count_edges(repaired).closed());
  EXPECT_NEAR(compute_volume(repaired), volume, 1e-12);
}

TEST(RepairMesh, LeavesAMoebiusStripAlone) {
  TriangleMesh mesh;
  constexpr std::uint32_t kSegments = 12;
  for (std::uint32_t i = 0; i < kSegments; ++i) {
    const double a = 2.0 * 3.14159265358979 * i / kSegments;
    for (const double s : {-0.3, 0.3}) {
      const double r = 1.0 + s * std::cos(a / 2);
      mesh.vertices.emplace_back(r * std::cos(a), r * std::sin(a), s * std::sin(a / 2));
    }
  }
  for (std::uint32_t i = 0; i < kSegments; ++i) {
    const std::uint32_t a = 2 * i;
    const std::uint32_t b = 2 * i + 1;
    const bool is_last = i + 1 == kSegments;
    const std::uint32_t c = is_last ? 1 : 2 * i + 2;
    const std::uint32_t d = is_last ? 0 : 2 * i + 3;
    mesh.triangles.push_back({a, c, b});
    mesh.triangles.push_back({b, c, d});
  }
  RepairReport report;
  const TriangleMesh repaired = repair_mesh(mesh, report);
  EXPECT_EQ(report.unorientable_pieces, 1U);
  EXPECT_EQ(report.turned, 0U);
  EXPECT_EQ(repaired.triangles, mesh.triangles);
}

TEST(RepairMesh, CountsWhatItCannotRepair) {
  TriangleMesh mesh = make_plane_grid(1.0, 2);
  mesh.vertices.emplace_back(2, 0, 0);
  mesh.vertices.emplace_back(3, 0, 0);
  mesh.vertices.emplace_back(4, 0, 0);
  mesh.vertices.emplace_back(3, 1e-3, 0);
  const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.triangles.push_back({n - 4, n - 3, n - 2});
  mesh.triangles.push_back({n - 4, n - 2, n - 1});
  RepairReport report;
  repair_mesh(mesh, report);
  EXPECT_EQ(report.empty_area, 1U);
  EXPECT_EQ(report.needles, 1U);
  EXPECT_EQ(report.boundary_edges, 8U + 4U);  // of the grid, and of the two triangles beside it
  EXPECT_EQ(report.pieces, 2U);
  EXPECT_NE(report.describe().find("1 needles"), std::string::npos);
}

// The height of a needle is less than a hundredth of its longest edge, whichever of its edges that is, and however short the others are.
TEST(RepairMesh, ANeedleIsFlatOverItsLongestEdge) {
  const auto report_of = [](double tip_x, double height, int first) {
    const std::array<Vec3, 3> corner = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(tip_x, height, 0)};
    TriangleMesh mesh{{corner.begin(), corner.end()}, {{0, 1, 2}}};
    std::rotate(mesh.vertices.begin(), mesh.vertices.begin() + first, mesh.vertices.end());
    RepairReport report;
    repair_mesh(mesh, report);
    return report;
  };
  for (int first = 0; first < 3; ++first) {
    for (const double tip_x : {0.0001, 0.5, 0.99}) {
      for (const auto& [height, needles, empty] : {std::tuple(0.0101, 0U, 0U), {0.0099, 1U, 0U}, {2e-14, 1U, 0U}, {5e-15, 0U, 1U}}) {
        const RepairReport report = report_of(tip_x, height, first);
        EXPECT_EQ(report.needles, needles) << tip_x << " " << height << " " << first;
        EXPECT_EQ(report.empty_area, empty) << tip_x << " " << height << " " << first;
      }
    }
  }
}

}  // namespace
}  // namespace hapton
