#include "core/geometry/mesh_topology.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

namespace hapton {
namespace {

TriangleMesh tetrahedron() {
  return {.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}

// Adds the triangles of another mesh; equal vertices are not joined.
void add(TriangleMesh& mesh, const TriangleMesh& other, const Vec3& shift = Vec3::Zero()) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Vec3& v : other.vertices) mesh.vertices.push_back(v + shift);
  for (const Triangle& t : other.triangles) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

TEST(MeshTopology, OfAClosedMesh) {
  const MeshTopology t = compute_mesh_topology(tetrahedron());
  EXPECT_EQ(t.triangles, 4U);
  EXPECT_EQ(t.vertices, 4U);
  EXPECT_EQ(t.components, 1U);
  EXPECT_TRUE(t.is_closed());
  EXPECT_DOUBLE_EQ(t.signed_volume, 1.0 / 6.0);
  EXPECT_EQ(t.lowest, Vec3(0, 0, 0));
  EXPECT_EQ(t.highest, Vec3(1, 1, 1));
  EXPECT_DOUBLE_EQ(t.shortest_edge, 1.0);
  EXPECT_DOUBLE_EQ(t.longest_edge, std::sqrt(2.0));
}

TEST(MeshTopology, OfNothing) {
  const MeshTopology t = compute_mesh_topology({});
  EXPECT_EQ(t.triangles, 0U);
  EXPECT_EQ(t.components, 0U);
  EXPECT_FALSE(t.is_closed());
}

TEST(MeshTopology, VolumeKeepsItsDigitsFarFromTheOriginAndAtAnyScale) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    TriangleMesh mesh = tetrahedron();
    for (Vec3& v : mesh.vertices) v = scale * (v + Vec3(4096, -4096, 8192));
    const MeshTopology t = compute_mesh_topology(mesh);
    EXPECT_NEAR(t.signed_volume, scale * scale * scale / 6.0, 1e-9 * scale * scale * scale);
    EXPECT_EQ(t.degenerate_triangles, 0U);
    EXPECT_TRUE(t.is_closed());
  }
}

TEST(MeshTopology, CountsTheEdgesOfAHole) {
  TriangleMesh mesh = tetrahedron();
  mesh.triangles.pop_back();
  const MeshTopology t = compute_mesh_topology(mesh);
  EXPECT_EQ(t.boundary_edges, 3U);
  EXPECT_EQ(t.nonmanifold_vertices, 0U);
  EXPECT_FALSE(t.is_closed());
}

TEST(MeshTopology, CountsEdgesAFlippedFaceDisagreesOn) {
  TriangleMesh mesh = tetrahedron();
  std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  const MeshTopology t = compute_mesh_topology(mesh);
  EXPECT_EQ(t.inconsistent_edges, 3U);
  EXPECT_EQ(t.boundary_edges, 0U);
  EXPECT_FALSE(t.is_closed());
}

TEST(MeshTopology, CountsAFinAndItsEdge) {
  TriangleMesh mesh = tetrahedron();
  mesh.vertices.emplace_back(1, 1, 1);
  mesh.triangles.push_back({0, 1, 4});
  const MeshTopology t = compute_mesh_topology(mesh);
  EXPECT_EQ(t.nonmanifold_edges, 1U);
  EXPECT_EQ(t.boundary_edges, 2U);
}

TEST(MeshTopology, CountsPiecesAndVerticesWhereTwoTouch) {
  TriangleMesh apart = tetrahedron();
  add(apart, tetrahedron(), Vec3(5, 0, 0));
  EXPECT_EQ(compute_mesh_topology(apart).components, 2U);
  EXPECT_TRUE(compute_mesh_topology(apart).is_closed());
  TriangleMesh touching = apart;  // at one shared vertex
  for (Triangle& t : touching.triangles) std::replace(t.begin(), t.end(), 4U, 0U);
  const MeshTopology t = compute_mesh_topology(touching);
  EXPECT_EQ(t.vertices, 7U);
  EXPECT_EQ(t.components, 1U);
  EXPECT_EQ(t.nonmanifold_vertices, 1U);
  EXPECT_FALSE(t.is_closed());
}

TEST(MeshTopology, CountsBadlyShapedTrianglesByTheirShapeAlone) {
  for (const double scale : {1e-9, 1.0, 1e9}) {
    TriangleMesh mesh;
    mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0.5, 0.0099, 0}, {0.5, 0.0101, 0}, {0.25, 0, 0}, {0.5, 1e-13, 0}};
    for (Vec3& v : mesh.vertices) v *= scale;
    mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {0, 1, 1}, {0, 1, 5}};
    const MeshTopology t = compute_mesh_topology(mesh);
    EXPECT_EQ(t.needle_triangles, 2U) << "0.99 % high and 1e-13 high";
    EXPECT_EQ(t.degenerate_triangles, 2U) << "flat, and with a vertex twice";
  }
}

TEST(MeshTopology, CountsDuplicatesWhateverTheirOrder) {
  TriangleMesh mesh = tetrahedron();
  mesh.triangles.push_back({1, 0, 2});
  mesh.triangles.push_back({2, 1, 0});
  EXPECT_EQ(compute_mesh_topology(mesh).duplicate_triangles, 2U);
}

// Compared with sets and maps, on random triangles between few vertices, so that every irregularity occurs.
TEST(MeshTopology, AgreesWithItsBruteForceTwin) {
  const unsigned seed = 20260807;
  RecordProperty("seed", static_cast<int>(seed));
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  for (int round = 0; round < 200; ++round) {
    const auto draw = [&](std::uint32_t below) { return static_cast<std::uint32_t>(random() % below); };
    TriangleMesh mesh;
    const std::uint32_t n = 4 + draw(20);
    for (std::uint32_t i = 0; i < n; ++i) mesh.vertices.emplace_back(coordinate(random), coordinate(random), coordinate(random));
    const std::uint32_t count = 1 + draw(40);
    for (std::uint32_t i = 0; i < count; ++i) {
      mesh.triangles.push_back({draw(n), draw(n), draw(n)});
    }
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<bool>> edges;
    std::multiset<std::multiset<std::uint32_t>> all;
    std::vector<std::set<std::uint32_t>> pieces;
    for (const Triangle& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k];
        const std::uint32_t b = t[(k + 1) % 3];
        if (a != b) edges[std::minmax(a, b)].push_back(a < b);
      }
      all.insert({t[0], t[1], t[2]});
      std::set<std::uint32_t> piece(t.begin(), t.end());
      for (auto other = pieces.begin(); other != pieces.end();) {
        const bool meets = std::any_of(other->begin(), other->end(), [&](auto v) { return std::count(t.begin(), t.end(), v) > 0; });
        if (meets) piece.insert(other->begin(), other->end());
        other = meets ? pieces.erase(other) : other + 1;
      }
      pieces.push_back(piece);
    }
    std::size_t boundary = 0;
    std::size_t nonmanifold = 0;
    std::size_t inconsistent = 0;
    for (const auto& [edge, sides] : edges) {
      boundary += sides.size() == 1 ? 1 : 0;
      nonmanifold += sides.size() > 2 ? 1 : 0;
      inconsistent += sides.size() == 2 && sides[0] == sides[1] ? 1 : 0;
    }
    const std::set<std::multiset<std::uint32_t>> unique(all.begin(), all.end());
    const MeshTopology t = compute_mesh_topology(mesh);
    EXPECT_EQ(t.boundary_edges, boundary);
    EXPECT_EQ(t.nonmanifold_edges, nonmanifold);
    EXPECT_EQ(t.inconsistent_edges, inconsistent);
    EXPECT_EQ(t.duplicate_triangles, all.size() - unique.size());
    EXPECT_EQ(t.components, pieces.size());
  }
}

}  // namespace
}  // namespace hapton
