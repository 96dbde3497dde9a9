#include "vision_node/flat_level.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TEST(FlatLevel, ANormalSurvivesItsPacking) {
  for (const Vec3f& n : {Vec3f(1, 0, 0), Vec3f(0, -1, 0), Vec3f(0, 0, -1), Vec3f(0.6F, -0.8F, 0), Vec3f(-0.36F, 0.48F, 0.8F)}) {
    EXPECT_LT((unpack_normal(pack_normal(n)) - n).norm(), 0.003F);
  }
}

// Expects the same triangles, each with the same corners in the same cyclic order, and the normal of each triangle at its last corner.
void expect_flat(const TriangleMesh& mesh) {
  const DetailLevel level = make_full_level(mesh, make_detail_frame(mesh));
  const FlatLevel flat = make_flat(level);
  ASSERT_EQ(flat.indices.size(), level.indices.size());
  for (std::size_t i = 0; i < flat.indices.size(); i += 3) {
    std::array<Vec3f, 3> corner;
    for (int k = 0; k < 3; ++k) corner[k] = flat.vertices[flat.indices[i + k]].position;
    const Vec3f normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
    EXPECT_GT(normal.dot(unpack_normal(flat.vertices[flat.indices[i + 2]].normal)), 0.99F);
    int turned = -1;
    for (int t = 0; t < 3; ++t) {
      bool same = true;
      for (int k = 0; k < 3; ++k) same = same && corner[(k + t) % 3] == level.positions[level.indices[i + k]];
      if (same) turned = t;
    }
    EXPECT_GE(turned, 0) << "triangle " << i / 3;
  }
  EXPECT_LE(flat.vertices.size(), level.positions.size() + level.triangles());
}

TEST(FlatLevel, EveryTriangleHasALastCornerOfItsPlane) {
  expect_flat(make_icosphere(0.05, 3));
  expect_flat(make_box(Vec3::Constant(0.1), 3));
  expect_flat(make_gutter(0.1, 0.03, 0.6, 8));
}

TEST(FlatLevel, ATriangleWithoutAreaIsKept) {
  DetailLevel level;
  level.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  level.indices = {0, 1, 2};
  level.clusters = {{.first = 0, .count = 3}};
  EXPECT_EQ(make_flat(level).triangles(), 1U);
}

}  // namespace
}  // namespace hapton
