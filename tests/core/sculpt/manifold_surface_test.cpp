#include "core/sculpt/manifold_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "core/geometry/mesh_measures.h"

namespace hapton {
namespace {

// A grid with `side` nodes along each axis; the nodes of its border are outside the body.
struct MadeGrid {
  explicit MadeGrid(int side) : count(side), values(static_cast<std::size_t>(side * side * side), 1.0F) {}

  float& at(int x, int y, int z) { return values[static_cast<std::size_t>(x + count * (y + count * z))]; }
  NodeValues nodes() const { return {values, {count, count, count}}; }
  // Each inner node is inside the body with probability `share_inside`; the distances are random.
  void fill(std::uint32_t seed, double share_inside) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> distance(0.01F, 1.0F);
    std::bernoulli_distribution is_inside(share_inside);
    for (int z = 1; z + 1 < count; ++z) {
      for (int y = 1; y + 1 < count; ++y) {
        for (int x = 1; x + 1 < count; ++x) at(x, y, z) = (is_inside(random) ? -1.0F : 1.0F) * distance(random);
      }
    }
  }

  int count;
  std::vector<float> values;
};

template <class Surface>
TriangleMesh mesh_of(const Surface& surface) {
  TriangleMesh mesh;
  for (const Eigen::Vector3f& p : surface.positions) mesh.vertices.emplace_back(p.cast<double>());
  for (const auto& quad : surface.quads) {
    mesh.triangles.push_back({quad[0], quad[1], quad[2]});
    mesh.triangles.push_back({quad[0], quad[2], quad[3]});
  }
  return mesh;
}

SurfaceNet net_of(const NodeValues& grid) {
  SurfaceNets nets;
  SurfaceNet net;
  nets.compute(grid, {0, 0, 0}, 1, net);
  return net;
}

// The number of vertices whose triangles are not one fan: from one of these triangles, some cannot be reached over edges at the vertex.
std::size_t count_vertices_with_split_fans(const TriangleMesh& mesh) {
  std::vector<std::map<std::uint32_t, std::uint32_t>> next_around(mesh.vertices.size());
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) next_around[t[k]][t[(k + 1) % 3]] = t[(k + 2) % 3];
  }
  std::size_t split_count = 0;
  for (const auto& fan : next_around) {
    if (fan.empty()) continue;
    std::size_t steps = 1;
    for (std::uint32_t at = fan.begin()->second; at != fan.begin()->first && steps <= fan.size(); ++steps) {
      const auto following = fan.find(at);
      if (following == fan.end()) break;
      at = following->second;
    }
    split_count += steps == fan.size() ? 0 : 1;
  }
  return split_count;
}

// In 40 grids of 16^3 random nodes, practically every kind of cell, and of pair of adjacent cells, occurs many times.
TEST(ManifoldSurface, IsAClosedManifoldForRandomValues) {
  std::size_t non_manifold_edges = 0;
  for (std::uint32_t seed = 1; seed <= 40; ++seed) {
    MadeGrid grid(16);
    grid.fill(seed, 0.1 + 0.02 * seed);
    const TriangleMesh mesh = mesh_of(make_manifold_surface(grid.nodes()));
    const EdgeCensus edges = count_edges(mesh);
    EXPECT_TRUE(edges.closed()) << "seed " << seed << ": " << edges.boundary << " open, " << edges.non_manifold << " non-manifold, "
                                << edges.inconsistent << " inconsistent";
    EXPECT_EQ(count_vertices_with_split_fans(mesh), 0U) << "seed " << seed;
    EXPECT_GT(compute_volume(mesh), 0.0) << "it faces outwards";
    non_manifold_edges += count_edges(mesh_of(net_of(grid.nodes()))).non_manifold;
  }
  EXPECT_GT(non_manifold_edges, 10'000U) << "the surface nets of the same grids have many edges of four quads";
}

// Each of the 4,096 ways in which the nodes of two adjacent cells can be inside, along each axis.
TEST(ManifoldSurface, IsAClosedManifoldForEveryPairOfCells) {
  for (unsigned inside = 1; inside < 4096; ++inside) {
    for (int axis = 0; axis < 3; ++axis) {
      MadeGrid grid(5);
      for (int node = 0; node < 12; ++node) {
        std::array<int, 3> at = {1, 1, 1};
        at[static_cast<std::size_t>(axis)] += node / 4;
        at[static_cast<std::size_t>((axis + 1) % 3)] += node & 1;
        at[static_cast<std::size_t>((axis + 2) % 3)] += node >> 1 & 1;
        if ((inside >> node & 1U) != 0) grid.at(at[0], at[1], at[2]) = -1.0F;
      }
      const TriangleMesh mesh = mesh_of(make_manifold_surface(grid.nodes()));
      ASSERT_TRUE(count_edges(mesh).closed()) << inside << " along axis " << axis;
      ASSERT_EQ(count_vertices_with_split_fans(mesh), 0U) << inside << " along axis " << axis;
    }
  }
}

// Where no cell contains several pieces of surface, both surfaces are the same to the last bit.
TEST(ManifoldSurface, OfASmoothBodyIsThatOfSurfaceNets) {
  MadeGrid grid(16);
  for (int z = 0; z < 16; ++z) {
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < 16; ++x)
        grid.at(x, y, z) = (Eigen::Vector3i(x, y, z).cast<float>() - Eigen::Vector3f(7.3F, 7.6F, 7.1F)).norm() - 5.2F;
    }
  }
  const auto corners_of = [](const auto& surface) {
    std::multiset<std::vector<float>> quads;
    for (const auto& quad : surface.quads) {
      std::vector<float> corners;
      for (const std::uint32_t v : quad) corners.insert(corners.end(), surface.positions[v].data(), surface.positions[v].data() + 3);
      quads.insert(corners);
    }
    return quads;
  };
  const ManifoldSurface surface = make_manifold_surface(grid.nodes());
  EXPECT_GT(surface.quads.size(), 400U);
  EXPECT_EQ(corners_of(surface), corners_of(net_of(grid.nodes())));
}

// Two columns of one node each stand diagonally on a plate of four nodes. The contours between them separate what is inside, and not what
// is outside, so each column ends in four vertices of its own.
TEST(ManifoldSurface, AcrossADiagonalTheBodyIsNotJoined) {
  MadeGrid grid(6);
  for (int y = 2; y < 4; ++y) {
    for (int x = 2; x < 4; ++x) grid.at(x, y, 2) = -1.0F;
  }
  grid.at(2, 2, 3) = grid.at(3, 3, 3) = -1.0F;
  const ManifoldSurface surface = make_manifold_surface(grid.nodes());
  EXPECT_EQ(std::count_if(surface.positions.begin(), surface.positions.end(), [](const auto& p) { return p.z() > 3.0F; }), 8);
}

TEST(ManifoldSurface, OfNothingIsEmpty) { EXPECT_TRUE(make_manifold_surface(MadeGrid(4).nodes()).quads.empty()); }

}  // namespace
}  // namespace hapton
