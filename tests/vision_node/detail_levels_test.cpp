#include "vision_node/detail_levels.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

DetailLevel full_level_of(const TriangleMesh& mesh) { return make_full_level(mesh, make_detail_frame(mesh)); }

std::multiset<std::array<float, 9>> triangles_of(const DetailLevel& level) {
  std::multiset<std::array<float, 9>> triangles;
  for (std::size_t i = 0; i < level.indices.size(); i += 3) {
    std::array<Vec3f, 3> corners;
    for (int k = 0; k < 3; ++k) corners[k] = level.positions[level.indices[i + k]];
    const auto first_corner = std::min_element(corners.begin(), corners.end(), [](const Vec3f& a, const Vec3f& b) {
      return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
    });
    std::rotate(corners.begin(), first_corner, corners.end());
    std::array<float, 9> coordinates;
    for (int k = 0; k < 9; ++k) coordinates[k] = corners[k / 3][k % 3];
    triangles.insert(coordinates);
  }
  return triangles;
}

TEST(DetailLevels, TheFullLevelIsTheMeshWhateverItsSize) {
  for (const double scale : {1e-4, 1.0, 1e4}) {
    const TriangleMesh mesh = scaled_and_moved(make_icosphere(1.0, 3), scale, Vec3(7.0, -3.0, 2.0) * scale);
    const DetailFrame frame = make_detail_frame(mesh);
    const DetailLevel full = make_full_level(mesh, frame);
    ASSERT_EQ(full.triangles(), mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      const Vec3 back = (frame.matrix() * full.positions[i].cast<double>().homogeneous()).head<3>();
      EXPECT_LT((back - mesh.vertices[i]).norm(), 1e-6 * scale);
    }
  }
}

TEST(DetailLevels, AMeshOfOnePointHasAFrameAsWell) {
  TriangleMesh point;
  point.vertices = {Vec3(1, 2, 3), Vec3(1, 2, 3), Vec3(1, 2, 3)};
  point.triangles = {{0, 1, 2}};
  const DetailLevel full = full_level_of(point);
  for (const Vec3f& p : full.positions) EXPECT_TRUE(p.allFinite());
}

TEST(DetailLevels, ACoarserLevelHasFewerTrianglesNearTheMesh) {
  const DetailLevel full = full_level_of(make_bumpy_sphere(0.05, 0.25, 20'000, 1));
  const auto coarser = make_coarser_level(full, 5'000);
  ASSERT_TRUE(coarser);
  EXPECT_LE(coarser->triangles(), 5'000U);
  EXPECT_GT(coarser->triangles(), 3'000U);
  const double error = measure_level_error(*coarser, full, full.positions.size());
  EXPECT_GT(error, 0.0);
  EXPECT_LT(error, 0.02) << "of a body of size 2";
  const auto coarsest = make_coarser_level(*coarser, 500);
  ASSERT_TRUE(coarsest);
  EXPECT_GT(measure_level_error(*coarsest, full, full.positions.size()), error);
}

TEST(DetailLevels, TheErrorIsHowFarTheFarthestVertexIs) {
  // A pyramid of height 0.5 on a square of side 2, and the square alone.
  DetailLevel pyramid;
  pyramid.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 0.5F}};
  pyramid.indices = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
  DetailLevel square = pyramid;
  square.indices = {0, 1, 2, 0, 2, 3};
  EXPECT_NEAR(measure_level_error(square, pyramid, 100), 0.5, 1e-6);
  EXPECT_EQ(measure_level_error(pyramid, pyramid, 100), 0.0);
}

TEST(DetailLevels, ThinningOutLeavesTrianglesOfTheMeshAllOverIt) {
  const DetailLevel full = full_level_of(make_bumpy_sphere(0.05, 0.25, 20'000, 1));
  for (const std::size_t limit : {std::size_t{1}, std::size_t{3'000}, full.triangles() - 1, full.triangles(), full.triangles() + 1}) {
    const DetailLevel thin = thin_out(full, limit);
    EXPECT_LE(thin.triangles(), limit);
    EXPECT_GE(2 * thin.triangles() + 1, std::min(limit, full.triangles()));
    ASSERT_EQ(thin.clusters.size(), 1U);
    EXPECT_EQ(thin.clusters.front().count, thin.indices.size());
    for (const std::uint32_t corner : thin.indices) ASSERT_LT(corner, thin.positions.size());
  }
  const DetailLevel thin = thin_out(full, 3'000);
  // The first triangle is the mesh's first, with the same corners in the same order.
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(thin.positions[thin.indices[k]], full.positions[full.indices[k]]);
  EXPECT_LT(measure_level_error(thin, full, 4000), 0.1) << "all over it";
}

TEST(DetailLevels, ARoughLevelIsMadeAsWell) {
  const DetailLevel full = full_level_of(make_bumpy_sphere(0.05, 0.25, 20'000, 1));
  const auto rough = make_rough_level(full, 4'000);
  ASSERT_TRUE(rough);
  EXPECT_LT(rough->triangles(), 10'000U);
  EXPECT_LT(measure_level_error(*rough, full, 4000), 0.2);
}

TEST(DetailLevels, ALevelThatWouldSaveTooLittleIsNotMade) {
  const DetailLevel full = full_level_of(make_icosphere(0.05, 4));
  EXPECT_FALSE(make_coarser_level(full, full.triangles() * 9 / 10));
  EXPECT_TRUE(make_coarser_level(full, full.triangles() / 2));
}

TEST(DetailLevels, ClustersHoldEveryTriangleOnce) {
  DetailLevel level = full_level_of(make_bumpy_sphere(0.05, 0.25, 5'000, 1));
  const auto before = triangles_of(level);
  divide_into_clusters(level);
  EXPECT_EQ(triangles_of(level), before);
  ASSERT_GT(level.clusters.size(), 100U);
  std::uint32_t next = 0;
  for (const DetailCluster& cluster : level.clusters) {
    EXPECT_EQ(cluster.first, next);
    next += cluster.count;
    for (std::uint32_t i = cluster.first; i < next; ++i) {
      EXPECT_LE((level.positions[level.indices[i]] - cluster.centre).norm(), cluster.radius * 1.001F);
    }
  }
  EXPECT_EQ(next, level.indices.size());
}

}  // namespace
}  // namespace hapton
