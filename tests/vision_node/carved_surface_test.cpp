#include "vision_node/carved_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/mesh_shapes.h"
#include "vision_node/view_culling.h"

namespace hapton {
namespace {

constexpr double kClayRadius = 0.03;
constexpr double kClayVoxel = 0.001;
const Carve kHole{Vec3(0, 0, kClayRadius), Vec3(0.004, 0, kClayRadius), 0.008};

struct CarvedSurfaceTest : testing::Test {
  TriangleMesh mesh = make_icosphere(kClayRadius, 5);
  DetailFrame frame = make_detail_frame(mesh);
  CarvedField field = std::move(*CarvedField::make(mesh, kClayVoxel));
  CarvedSurface surface{field, frame};

  Vec3 point(const FlatVertex& vertex) const { return frame.centre + frame.scale_m * vertex.position.cast<double>(); }
  // Signed distance from the carved ball, by its formula.
  static double signed_distance(const Vec3& p) {
    const Vec3 along = kHole.to_m - kHole.from_m;
    const double t = std::clamp((p - kHole.from_m).dot(along) / along.squaredNorm(), 0.0, 1.0);
    return std::max(p.norm() - kClayRadius, kHole.radius_m - (p - kHole.from_m - t * along).norm());
  }
};

bool is_same_level(const FlatLevel& a, const FlatLevel& b) {
  const auto is_same_vertex = [](const FlatVertex& p, const FlatVertex& q) { return p.position == q.position && p.normal == q.normal; };
  return a.indices == b.indices && std::equal(a.vertices.begin(), a.vertices.end(), b.vertices.begin(), b.vertices.end(), is_same_vertex);
}

TEST_F(CarvedSurfaceTest, EachLevelShowsWhatIsLeft) {
  surface.compute_levels();
  surface.carve(kHole);
  EXPECT_TRUE(surface.has_changed());
  const std::vector<FlatLevel> levels = surface.compute_levels();
  EXPECT_FALSE(surface.has_changed());
  ASSERT_EQ(levels.size(), 3U);
  for (std::size_t level = 0; level < levels.size(); ++level) {
    const double step = kClayVoxel * CarvedSurface::kStrides[level];
    double worst = 0.0;
    for (const FlatVertex& vertex : levels[level].vertices) worst = std::max(worst, std::abs(signed_distance(point(vertex))));
    EXPECT_LT(worst, 0.5 * step) << "level " << level;
    EXPECT_EQ(levels[level].error > 0.0, level > 0);
  }
  EXPECT_GT(levels[0].triangles(), 3 * levels[1].triangles());
  EXPECT_GT(levels[1].triangles(), 3 * levels[2].triangles());
}

// A surface that was computed block by block after each carve is equal to one that is computed after all carves.
TEST_F(CarvedSurfaceTest, CarvesOneByOneGiveTheSameAsAllAtOnce) {
  surface.compute_levels();
  std::vector<Carve> carves = {kHole, {Vec3(0.02, 0.02, 0), Vec3(0.02, 0.02, 0), 0.005}, {Vec3(-0.03, 0, 0), Vec3(-0.02, 0.01, 0), 0.004}};
  for (const Carve& carve : carves) {
    surface.carve(carve);
    surface.compute_levels();
  }
  surface.carve(carves.front());
  EXPECT_FALSE(surface.has_changed()) << "a carve again changes nothing";
  CarvedField all = field;
  for (const Carve& carve : carves) all.carve(carve);
  CarvedSurface at_once(all, frame);
  surface.restore();
  for (const Carve& carve : carves) {
    surface.carve(carve);
    surface.compute_levels();
  }
  const std::vector<FlatLevel> levels = surface.compute_levels();
  EXPECT_TRUE(is_same_level(levels[0], at_once.compute_levels()[0]));
}

TEST_F(CarvedSurfaceTest, RestoredItIsWholeAgain) {
  const std::vector<FlatLevel> before = surface.compute_levels();
  surface.carve(kHole);
  EXPECT_FALSE(is_same_level(before[0], surface.compute_levels()[0]));
  surface.restore();
  EXPECT_TRUE(surface.has_changed());
  const std::vector<FlatLevel> after = surface.compute_levels();
  for (std::size_t level = 0; level < after.size(); ++level) EXPECT_TRUE(is_same_level(before[level], after[level]));
}

TEST_F(CarvedSurfaceTest, WhatIsFarFromTheBodyChangesNothing) {
  surface.compute_levels();
  surface.carve({Vec3(1, 1, 1), Vec3(1, 1, 1), 0.01});
  EXPECT_FALSE(surface.has_changed());
}

TEST_F(CarvedSurfaceTest, NothingIsLeftOfABodyCarvedAway) {
  surface.carve({Vec3::Zero(), Vec3::Zero(), 0.05});
  const std::vector<FlatLevel> levels = surface.compute_levels();
  for (const FlatLevel& level : levels) {
    EXPECT_TRUE(level.indices.empty());
    EXPECT_TRUE(level.clusters.empty());
  }
}

// The flat normal of each triangle, which is stored at its last corner, agrees with the order of its corners.
TEST_F(CarvedSurfaceTest, NormalsFaceOutward) {
  surface.carve(kHole);
  for (const FlatLevel& level : surface.compute_levels()) {
    std::size_t inward = 0;
    for (std::size_t i = 0; i < level.indices.size(); i += 3) {
      const auto corner = [&](std::size_t k) { return level.vertices[level.indices[i + k]]; };
      const Vec3f across = (corner(1).position - corner(0).position).cross(corner(2).position - corner(0).position);
      inward += across.dot(unpack_normal(corner(2).normal)) <= 0.0F ? 1U : 0U;
    }
    EXPECT_LE(inward, level.triangles() / 200) << "but for quads bent over an edge";
  }
}

// By brute force: a cluster is left out only if all its triangles show their backs, or are out of the picture.
TEST_F(CarvedSurfaceTest, NoTriangleThatIsSeenIsLeftOut) {
  surface.carve(kHole);
  std::size_t left_out = 0;
  for (const FlatLevel& level : surface.compute_levels()) {
    EXPECT_EQ(level.clusters.back().first + level.clusters.back().count, level.indices.size());
    for (const Vec3& p_UE : {Vec3(0, 0, 3), Vec3(2, -1, 0.5), Vec3(-0.9, 1.2, -1.1)}) {
      const ViewCulling culling(Mat4::Identity(), p_UE, DrawnSides::fronts);
      const ViewCulling all(Mat4::Identity(), p_UE, DrawnSides::both);
      for (const DetailCluster& cluster : level.clusters) {
        if (culling.may_see(cluster) || !all.may_see(cluster)) continue;
        ++left_out;
        for (std::uint32_t i = cluster.first; i < cluster.first + cluster.count; i += 3) {
          const auto corner = [&](std::uint32_t k) { return level.vertices[level.indices[i + k]].position.cast<double>().eval(); };
          const Vec3 across = (corner(1) - corner(0)).cross(corner(2) - corner(0));
          EXPECT_LE(across.dot(p_UE - corner(0)), 1e-6);
        }
      }
    }
  }
  EXPECT_GT(left_out, 10U);
}

}  // namespace
}  // namespace hapton
