#include "core/geometry/mesh_measures.h"

#include <gtest/gtest.h>
#include <utility>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TEST(MeshMeasures, CountsBoundariesAndInconsistency) {
  TriangleMesh box = make_box(Vec3::Ones());
  EXPECT_EQ(count_edges(box).edges, 18u);
  box.triangles.pop_back();
  EXPECT_EQ(count_edges(box).boundary, 3u);
  TriangleMesh turned = make_box(Vec3::Ones());
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  EXPECT_EQ(count_edges(turned).inconsistent, 3u);
  TriangleMesh doubled = make_box(Vec3::Ones());
  doubled.triangles.push_back(doubled.triangles[0]);
  EXPECT_EQ(count_edges(doubled).non_manifold, 3u);
  EXPECT_FALSE(count_edges(TriangleMesh{}).closed());
}

TEST(MeshMeasures, VolumeKeepsItsDigitsFarFromTheOrigin) {
  EXPECT_NEAR(compute_volume(scaled_and_moved(make_box(Vec3::Ones()), 1.0, Vec3(1048576.0, -1048576.0, 1048576.0))), 1.0, 1e-12);
}

TEST(MeshMeasures, BoundsOfABox) {
  const MeshBounds bounds = compute_bounds(scaled_and_moved(make_box(Vec3(1.0, 2.0, 2.0)), 1.0, Vec3(1.0, 0.0, 0.0)));
  EXPECT_EQ(bounds.low, Vec3(0.5, -1.0, -1.0));
  EXPECT_EQ(bounds.high, Vec3(1.5, 1.0, 1.0));
  EXPECT_EQ(bounds.diagonal(), 3.0);
  EXPECT_EQ(bounds.extent(), 2.0);
}

}  // namespace
}  // namespace hapton
