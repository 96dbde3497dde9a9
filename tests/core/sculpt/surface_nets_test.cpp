#include "core/sculpt/surface_nets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace hapton {
namespace {

using Position = std::array<float, 3>;

// A grid of nodes whose values are a function of their place.
struct SampledNodes {
  template <class Function>
  SampledNodes(const SurfaceNets::Index& size, Function&& value) : counts(size) {
    for (int z = 0; z < counts[2]; ++z) {
      for (int y = 0; y < counts[1]; ++y) {
        for (int x = 0; x < counts[0]; ++x) values.push_back(static_cast<float>(value(Vec3(x, y, z))));
      }
    }
  }
  NodeValues view() const { return {values, counts}; }

  SurfaceNets::Index counts;
  std::vector<float> values;
};

// A ball that extends over several blocks; its centre is not at whole numbers.
const Vec3 kBallCentre(22.3, 20.7, 19.1);
constexpr double kBallRadius = 14.2;
SampledNodes sampled_ball() {
  return {{44, 41, 39}, [](const Vec3& p) { return (p - kBallCentre).norm() - kBallRadius; }};
}

// All blocks joined to one net; vertices whose places are equal to the last bit become one vertex.
struct WholeNet {
  WholeNet(const NodeValues& grid, int stride) {
    SurfaceNets nets;
    const SurfaceNets::Index count = SurfaceNets::count_blocks(grid.counts);
    SurfaceNet net;
    for (int z = 0; z < count[2]; ++z) {
      for (int y = 0; y < count[1]; ++y) {
        for (int x = 0; x < count[0]; ++x) {
          nets.compute(grid, {x, y, z}, stride, net);
          add(net);
        }
      }
    }
  }
  void add(const SurfaceNet& net) {
    for (const auto& quad : net.quads) {
      std::array<std::uint32_t, 4> joined_quad = {};
      for (std::size_t k = 0; k < 4; ++k) {
        const Eigen::Vector3f& p = net.positions[quad[k]];
        const auto [entry, is_new] = vertex_at.emplace(Position{p.x(), p.y(), p.z()}, static_cast<std::uint32_t>(positions.size()));
        if (is_new) positions.push_back(p);
        joined_quad[k] = entry->second;
      }
      quads.push_back(joined_quad);
    }
  }
  // How often each edge is traversed from its first vertex to its second.
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed_edges() const {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& quad : quads) {
      for (std::size_t k = 0; k < 4; ++k) ++edges[{quad[k], quad[(k + 1) % 4]}];
    }
    return edges;
  }
  double volume() const {
    double six_volumes = 0.0;
    for (const auto& q : quads) {
      const auto p = [&](std::size_t k) { return positions[q[k]].cast<double>().eval(); };
      six_volumes += p(0).dot(p(1).cross(p(2))) + p(0).dot(p(2).cross(p(3)));
    }
    return six_volumes / 6.0;
  }

  std::vector<Eigen::Vector3f> positions;
  std::vector<std::array<std::uint32_t, 4>> quads;
  std::map<Position, std::uint32_t> vertex_at;
};

TEST(SurfaceNets, TheNetOfABallLiesOnItsSurface) {
  const SampledNodes ball = sampled_ball();
  for (const int stride : {1, 2, 4}) {
    const WholeNet net(ball.view(), stride);
    ASSERT_FALSE(net.quads.empty());
    // A vertex is the mean of points on the ball's surface in a cell, so it is inside the ball, by about the sagitta of a cell's diagonal.
    const double sagitta = 3.0 * stride * stride / (8.0 * kBallRadius);
    for (const Eigen::Vector3f& p : net.positions) {
      const double above_surface = (p.cast<double>() - kBallCentre).norm() - kBallRadius;
      EXPECT_LT(above_surface, 0.3 * sagitta) << stride;
      EXPECT_GT(above_surface, -1.3 * sagitta) << stride;
    }
    const double volume = 4.0 / 3.0 * M_PI * std::pow(kBallRadius, 3);
    EXPECT_NEAR(net.volume(), volume, 3.9 * sagitta / kBallRadius * volume) << "positive: quads face outward";
  }
}

// Each edge has a quad on either side, which traverse it in opposite directions: there is no crack, not even at the borders of blocks.
TEST(SurfaceNets, BlocksFitTogetherToTheLastBit) {
  const SampledNodes ball = sampled_ball();
  for (const int stride : {1, 2, 4}) {
    const auto edges = WholeNet(ball.view(), stride).directed_edges();
    for (const auto& [edge, times] : edges) {
      EXPECT_EQ(times, 1);
      EXPECT_EQ(edges.count({edge.second, edge.first}), 1U);
    }
  }
}

TEST(SurfaceNets, ACoarserLevelHasAQuarterOfTheQuads) {
  const SampledNodes ball = sampled_ball();
  const double fine = static_cast<double>(WholeNet(ball.view(), 1).quads.size());
  EXPECT_NEAR(static_cast<double>(WholeNet(ball.view(), 2).quads.size()) / fine, 1.0 / 4.0, 0.02);
  EXPECT_NEAR(static_cast<double>(WholeNet(ball.view(), 4).quads.size()) / fine, 1.0 / 16.0, 0.01);
}

// By brute force: there is one quad for each edge of the grid that the surface crosses.
TEST(SurfaceNets, OneQuadForEachEdgeThatIsCrossed) {
  constexpr unsigned kSeed = 77;
  std::mt19937 random(kSeed);
  RecordProperty("seed", kSeed);
  const SurfaceNets::Index counts = {35, 18, 33};
  const SampledNodes noise(counts, [&](const Vec3& p) {
    const bool is_border = p.minCoeff() == 0.0 || p.x() == counts[0] - 1 || p.y() == counts[1] - 1 || p.z() == counts[2] - 1;
    return is_border ? 1.0 : std::uniform_real_distribution(-1.0, 1.0)(random);
  });
  std::size_t crossed_edges = 0;
  const auto at = [&](int x, int y, int z) { return noise.values[static_cast<std::size_t>(x + counts[0] * (y + counts[1] * z))]; };
  for (int z = 1; z < counts[2]; ++z) {
    for (int y = 1; y < counts[1]; ++y) {
      for (int x = 1; x < counts[0]; ++x) {
        for (const float neighbour : {at(x - 1, y, z), at(x, y - 1, z), at(x, y, z - 1)}) {
          crossed_edges += (neighbour < 0.0F) != (at(x, y, z) < 0.0F) ? 1U : 0U;
        }
      }
    }
  }
  const WholeNet net(noise.view(), 1);
  EXPECT_EQ(net.quads.size(), crossed_edges);
  for (const auto& quad : net.quads) {
    EXPECT_EQ(std::set<std::uint32_t>(quad.begin(), quad.end()).size(), 4U);
  }
}

// By brute force: each cell of a block, and each cell just before the block, has one vertex if the surface passes through it, else none.
TEST(SurfaceNets, OneVertexForEachCellThatTheSurfacePassesThrough) {
  const SampledNodes ball = sampled_ball();
  const SurfaceNets::Index count = SurfaceNets::count_blocks(ball.counts);
  const auto is_inside = [&](int x, int y, int z) {
    if (std::min({x, y, z}) < 0 || x >= ball.counts[0] || y >= ball.counts[1] || z >= ball.counts[2]) return false;
    return ball.values[static_cast<std::size_t>(x + ball.counts[0] * (y + ball.counts[1] * z))] < 0.0F;
  };
  SurfaceNets nets;
  SurfaceNet net;
  for (const int stride : {1, 2, 4}) {
    for (int block = 0; block < count[0] * count[1] * count[2]; ++block) {
      const SurfaceNets::Index block_index = {block % count[0], block / count[0] % count[1], block / count[0] / count[1]};
      std::set<SurfaceNets::Index> expected;
      const auto first = [&](std::size_t k) { return block_index[k] * SurfaceNets::kBlock - stride; };
      const auto end = [&](std::size_t k) { return (block_index[k] + 1) * SurfaceNets::kBlock; };
      for (int z = first(2); z < end(2); z += stride) {
        for (int y = first(1); y < end(1); y += stride) {
          for (int x = first(0); x < end(0); x += stride) {
            int inside_corners = 0;
            for (int n = 0; n < 8; ++n)
              inside_corners += is_inside(x + (n & 1) * stride, y + (n >> 1 & 1) * stride, z + (n >> 2) * stride) ? 1 : 0;
            if (inside_corners != 0 && inside_corners != 8) expected.insert({x, y, z});
          }
        }
      }
      nets.compute(ball.view(), block_index, stride, net);
      std::set<SurfaceNets::Index> found;
      for (const Eigen::Vector3f& p : net.positions) {
        const Eigen::Vector3i cell = (p / static_cast<float>(stride)).array().floor().cast<int>() * stride;
        found.insert({cell.x(), cell.y(), cell.z()});
      }
      EXPECT_EQ(found, expected) << block << " at " << stride;
      EXPECT_EQ(net.positions.size(), expected.size()) << block << " at " << stride;
    }
  }
}

TEST(SurfaceNets, NothingWhereThereIsNoSurface) {
  const SampledNodes empty({20, 20, 20}, [](const Vec3&) { return 0.0; });
  EXPECT_TRUE(WholeNet(empty.view(), 1).quads.empty()) << "zero is outside";
}

// In a random grid, nodes of value 0 give the same quads and as many vertices as nodes outside.
TEST(SurfaceNets, ZeroIsOutside) {
  constexpr unsigned kSeed = 78;
  std::mt19937 random(kSeed);
  RecordProperty("seed", kSeed);
  SampledNodes zeros({14, 13, 15}, [&](const Vec3& p) {
    const bool is_border = p.minCoeff() == 0.0 || p.x() == 13 || p.y() == 12 || p.z() == 14;
    return is_border ? 1.0 : static_cast<double>(random() % 3) - 1.0;
  });
  SurfaceNets nets;
  SurfaceNet net_of_zeros, net_of_halves;
  nets.compute(zeros.view(), {0, 0, 0}, 1, net_of_zeros);
  std::replace(zeros.values.begin(), zeros.values.end(), 0.0F, 0.5F);
  nets.compute(zeros.view(), {0, 0, 0}, 1, net_of_halves);
  EXPECT_GT(net_of_halves.quads.size(), 500U);
  EXPECT_EQ(net_of_zeros.quads, net_of_halves.quads);
  EXPECT_EQ(net_of_zeros.positions.size(), net_of_halves.positions.size());
}

// A box whose faces lie between the border of the grid and the nodes beside it.
TEST(SurfaceNets, NodesAtTheBorderCountWithTheirValues) {
  for (const int nodes : {8, 17}) {
    const double middle = 0.5 * (nodes - 1);
    const SampledNodes box({nodes, nodes, nodes},
                           [&](const Vec3& p) { return (p - Vec3::Constant(middle)).cwiseAbs().maxCoeff() - (middle - 0.25); });
    const WholeNet net(box.view(), 1);
    Eigen::Vector3f low = net.positions.at(0), high = low;
    for (const Eigen::Vector3f& p : net.positions) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    EXPECT_EQ(low, Eigen::Vector3f::Constant(0.25F)) << nodes;
    EXPECT_EQ(high, Eigen::Vector3f::Constant(static_cast<float>(nodes) - 1.25F)) << nodes;
  }
}

// Nodes beyond the grid count as outside by 1 at every stride, whatever the border's values: as in a grid that goes on with 1 on all sides.
TEST(SurfaceNets, BeyondTheGridEverythingIsOutsideByOne) {
  const SurfaceNets::Index counts = {14, 15, 16};
  std::mt19937 random(8);
  std::uniform_real_distribution<double> distance(0.1, 2.0);
  std::bernoulli_distribution is_inside(0.5);
  const SampledNodes grid(counts, [&](const Vec3& p) {
    for (int axis = 0; axis < 3; ++axis) {
      if (p[axis] == 0.0 || p[axis] == counts[static_cast<std::size_t>(axis)] - 1) return 3.0;
    }
    return (is_inside(random) ? -1.0 : 1.0) * distance(random);
  });
  constexpr int kNodesBefore = SurfaceNets::kBlock;
  const SampledNodes wide({48, 48, 48}, [&](const Vec3& p) {
    const Eigen::Vector3i node = p.cast<int>() - Eigen::Vector3i::Constant(kNodesBefore);
    for (int axis = 0; axis < 3; ++axis) {
      if (node[axis] < 0 || node[axis] >= counts[static_cast<std::size_t>(axis)]) return 1.0;
    }
    return static_cast<double>(grid.values[static_cast<std::size_t>(node[0] + counts[0] * (node[1] + counts[1] * node[2]))]);
  });
  for (const int stride : {1, 2, 4}) {
    SurfaceNets nets;
    SurfaceNet net, expected;
    nets.compute(grid.view(), {0, 0, 0}, stride, net);
    nets.compute(wide.view(), {1, 1, 1}, stride, expected);
    EXPECT_GT(net.quads.size(), 50U) << stride;
    EXPECT_EQ(net.quads, expected.quads) << stride;
    ASSERT_EQ(net.positions.size(), expected.positions.size()) << stride;
    for (std::size_t v = 0; v < net.positions.size(); ++v) {
      const Eigen::Vector3f expected_position = expected.positions[v] - Eigen::Vector3f::Constant(kNodesBefore);
      ASSERT_LT((net.positions[v] - expected_position).norm(), 1e-5F) << stride;
    }
  }
}

// A block uses the nodes from one stride before its first cell to the end of its last cell.
TEST(SurfaceNets, ABlockChangesWithTheNodesFromAStrideBeforeItToItsEnd) {
  EXPECT_EQ(SurfaceNets::count_blocks({16, 17, 48}), (SurfaceNets::Index{1, 2, 3}));
  constexpr int kNodes = 64;
  const auto find_changed_range = [&](int node) {
    const SurfaceNets::Blocks changed =
        SurfaceNets::find_changed({kNodes, kNodes, kNodes}, {node, node, node}, {node + 1, node + 1, node + 1});
    for (std::size_t axis = 1; axis < 3; ++axis) {
      EXPECT_EQ(changed.first[axis], changed.first[0]);
      EXPECT_EQ(changed.end[axis], changed.end[0]);
    }
    return std::pair(changed.first[0], changed.end[0]);
  };
  for (int node = 0; node < kNodes; ++node) {
    int first = kNodes, end = 0;
    for (int block = 0; block < kNodes / SurfaceNets::kBlock; ++block) {
      if (node < SurfaceNets::kBlock * block - SurfaceNets::kLargestStride || node > SurfaceNets::kBlock * (block + 1)) continue;
      first = std::min(first, block);
      end = std::max(end, block + 1);
    }
    EXPECT_EQ(find_changed_range(node), std::pair(first, end)) << node;
  }
}

// A change of one node changes, at every stride, only blocks that are listed; at most eight are.
TEST(SurfaceNets, ANodeChangesOnlyListedBlocks) {
  const SampledNodes ball = sampled_ball();
  const SurfaceNets::Index count = SurfaceNets::count_blocks(ball.counts);
  SurfaceNets nets;
  SurfaceNet before, after;
  for (const SurfaceNets::Index& node : {SurfaceNets::Index{8, 20, 20}, {16, 32, 15}, {28, 12, 16}, {31, 31, 31}, {0, 40, 38}}) {
    SampledNodes changed = ball;
    float& value = changed.values[static_cast<std::size_t>(node[0] + ball.counts[0] * (node[1] + ball.counts[1] * node[2]))];
    value = value < 0.0F ? 1.0F : -1.0F;
    const SurfaceNets::Blocks listed = SurfaceNets::find_changed(ball.counts, node, {node[0] + 1, node[1] + 1, node[2] + 1});
    for (int z = 0; z < count[2]; ++z) {
      for (int y = 0; y < count[1]; ++y) {
        for (int x = 0; x < count[0]; ++x) {
          const std::array<int, 3> block = {x, y, z};
          bool is_listed = true;
          for (std::size_t k = 0; k < 3; ++k) is_listed = is_listed && block[k] >= listed.first[k] && block[k] < listed.end[k];
          if (is_listed) continue;
          for (const int stride : {1, 2, 4}) {
            nets.compute(ball.view(), block, stride, before);
            nets.compute(changed.view(), block, stride, after);
            EXPECT_EQ(before.positions, after.positions) << x << y << z << " at " << stride;
            EXPECT_EQ(before.quads, after.quads);
          }
        }
      }
    }
    EXPECT_LE((listed.end[0] - listed.first[0]) * (listed.end[1] - listed.first[1]) * (listed.end[2] - listed.first[2]), 8);
  }
  const SurfaceNets::Blocks none = SurfaceNets::find_changed(ball.counts, {5, 5, 5}, {5, 6, 6});
  EXPECT_GE(none.first[0], none.end[0]);
}

}  // namespace
}  // namespace hapton
