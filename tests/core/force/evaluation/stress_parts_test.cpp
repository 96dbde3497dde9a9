#include "core/force/evaluation/stress_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/point_in_mesh.h"

namespace hapton {
namespace {

constexpr std::uint64_t kSeeds[] = {1, 2, 3, 4, 5, 6, 7, 8};

TEST(StressParts, TheBoundaryOfCellsIsClosedAndHasTheirVolume) {
  const std::vector<double> x = {0.0, 1.0, 1.5, 4.0};
  const std::vector<double> y = {-1.0, 0.0, 2.0};
  const std::vector<double> z = {0.0, 0.25, 1.0};
  const auto is_solid = [](int i, int j, int k) { return !(i == 1 && k == 1) && !(i == 0 && j == 0 && k == 1); };
  const TriangleMesh mesh = make_cell_solid(x, y, z, is_solid);
  double volume = 0.0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 2; ++j) {
      for (int k = 0; k < 2; ++k) volume += is_solid(i, j, k) ? (x[i + 1] - x[i]) * (y[j + 1] - y[j]) * (z[k + 1] - z[k]) : 0.0;
    }
  }
  EXPECT_TRUE(count_edges(mesh).closed());
  EXPECT_NEAR(compute_volume(mesh), volume, 1e-12);
}

TEST(StressParts, ASlottedPartIsClosedAndHasNarrowGaps) {
  for (const std::uint64_t seed : kSeeds) {
    for (const double bend : {0.0, 0.06}) {
      const TriangleMesh part = make_slotted_part(seed, bend);
      EXPECT_TRUE(count_edges(part).closed()) << "seed " << seed;
      EXPECT_GT(compute_volume(part), 0.0);
      EXPECT_LT(compute_volume(part), 0.1 * 0.06 * 0.03);
      EXPECT_LT(part.triangles.size(), 12000U);
      double shortest = 1.0;
      for (const Triangle& t : part.triangles) {
        for (int k = 0; k < 3; ++k) shortest = std::min(shortest, (part.vertices[t[k]] - part.vertices[t[(k + 1) % 3]]).norm());
      }
      EXPECT_GT(shortest, 0.0);
      EXPECT_LT(shortest, 0.001);
    }
  }
}

TEST(StressParts, AnOpenFrontHasBoundariesAndFlippedTriangles) {
  for (const std::uint64_t seed : kSeeds) {
    const EdgeCensus edges = count_edges(make_open_front(seed));
    EXPECT_GT(edges.boundary, 100U) << "seed " << seed;
    EXPECT_GT(edges.inconsistent, 0U) << "seed " << seed;
  }
}

// Of the outer surface of an open front.
double height_above_front(const Vec3& p) {
  const double across = 20.0 * p.x();
  const double along = p.y() / 0.03;
  const double bulge = 0.035 * (1.0 - 0.6 * across * across) * (1.0 - 0.5 * along * along * along * along);
  return p.z() - (bulge - 0.002 * std::fabs(along - 0.2 * across));
}

// The upper ends of the ribs are up to 1 mm above or below the outer surface, the centres of the lamps 2 mm above to 6 mm below.
TEST(StressParts, RibsAndLampsOfAnOpenFrontGoThroughItsOuterSurface) {
  const std::size_t lamp_size = make_icosphere(0.006, 2).vertices.size();
  std::array<double, 2> least{1.0, 1.0};
  std::array<double, 2> most{-1.0, -1.0};
  double least_lean = 1.0;
  double most_lean = -1.0;
  double lowest_lamp = 1.0;
  double highest_lamp = -1.0;
  for (const std::uint64_t seed : kSeeds) {
    const TriangleMesh front = make_open_front(seed);
    const auto lamps = front.vertices.end() - static_cast<std::ptrdiff_t>(2 * lamp_size);
    for (auto rib = lamps - 3 * 4; rib != lamps; rib += 4) {
      for (int end = 0; end < 2; ++end) {
        EXPECT_NEAR(rib[end].y(), end == 0 ? -0.024 : 0.024, 1e-15);
        least[end] = std::min(least[end], height_above_front(rib[end]));
        most[end] = std::max(most[end], height_above_front(rib[end]));
        EXPECT_LT((rib[3 - end] - rib[end] + Vec3(0, 0, 0.02)).norm(), 1e-15);
      }
      EXPECT_LE(std::fabs(rib[0].x()), 0.04);
      least_lean = std::min(least_lean, rib[1].x() - rib[0].x());
      most_lean = std::max(most_lean, rib[1].x() - rib[0].x());
    }
    for (int i = 0; i < 2; ++i) {
      const auto first = lamps + static_cast<std::ptrdiff_t>(i * lamp_size);
      const Vec3 centre =
          std::accumulate(first, first + static_cast<std::ptrdiff_t>(lamp_size), Vec3::Zero().eval()) / static_cast<double>(lamp_size);
      EXPECT_NEAR(std::fabs(centre.x()), 0.035, 1e-12);
      lowest_lamp = std::min(lowest_lamp, height_above_front(centre));
      highest_lamp = std::max(highest_lamp, height_above_front(centre));
    }
  }
  constexpr double kRounding = 1e-12;
  for (int end = 0; end < 2; ++end) {
    EXPECT_GE(least[end], -0.001 - kRounding);
    EXPECT_LT(least[end], -0.0005);
    EXPECT_GT(most[end], 0.0005);
    EXPECT_LE(most[end], 0.001 + kRounding);
  }
  EXPECT_GE(least_lean, -0.01 - kRounding);
  EXPECT_LT(least_lean, -0.005);
  EXPECT_GT(most_lean, 0.005);
  EXPECT_LE(most_lean, 0.01 + kRounding);
  EXPECT_GE(lowest_lamp, -0.006 - kRounding);
  EXPECT_LT(lowest_lamp, -0.003);
  EXPECT_GT(highest_lamp, 0.0);
  EXPECT_LE(highest_lamp, 0.002 + kRounding);
}

TEST(StressParts, TouchingPartsAreClosedAndTouchExactly) {
  const TriangleMesh mesh = make_touching_parts();
  EXPECT_TRUE(count_edges(mesh).closed());
  const PointInMesh solid(mesh);
  const double side = 0x1p-5;
  EXPECT_TRUE(solid.is_inside({0.25 * side, 0.25 * side, 0.1 * side}));     // a brick
  EXPECT_TRUE(solid.is_inside({-side, 0.1 * side, 0.3 * side}));            // the cylinder, just above the bricks
  EXPECT_FALSE(solid.is_inside({side, 0.0, 0.75 * side}));                  // the hollow
  EXPECT_TRUE(solid.is_inside({(1.375 - 0.01) * side, 0.0, 0.75 * side}));  // the pane
  EXPECT_EQ(std::count_if(mesh.vertices.begin(), mesh.vertices.end(), [&](const Vec3& v) { return v.x() == 1.375 * side; }), 16 + 4);
}

TEST(StressParts, OverlappingPartsAreClosedAndTheirVolumesSumToMoreThanTheirUnion) {
  for (const std::uint64_t seed : kSeeds) {
    const TriangleMesh mesh = make_overlapping_parts(seed);
    EXPECT_TRUE(count_edges(mesh).closed()) << "seed " << seed;
    const MeshBounds bounds = compute_bounds(mesh);
    EXPECT_GT(bounds.extent(), 0.04);
    EXPECT_LT(bounds.extent(), 0.2);
    const PointInMesh solid(mesh);
    int inside = 0;
    constexpr int kCells = 12;
    for (int i = 0; i < kCells * kCells * kCells; ++i) {
      const Vec3 share = Vec3(i % kCells + 0.5, i / kCells % kCells + 0.5, i / (kCells * kCells) + 0.5) / kCells;
      inside += solid.is_inside(bounds.low + share.cwiseProduct(bounds.high - bounds.low)) ? 1 : 0;
    }
    const double box = (bounds.high - bounds.low).prod();
    EXPECT_LT(box * inside / (kCells * kCells * kCells), compute_volume(mesh)) << "seed " << seed;
  }
}

}  // namespace
}  // namespace hapton
