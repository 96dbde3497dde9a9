#include "tools/check/reach_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <tuple>
#include <utility>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TEST(ReachCheck, CutsTrianglesAtTheBox) {
  const TriangleMesh square = make_plane_grid(2.0, 1);  // two triangles, x and y from -1 to 1
  const Vec3 far = Vec3::Constant(10.0);
  EXPECT_EQ(find_unreached(square, -far, far).share, 0.0);
  // A fifth, a corner, all of it, and a strip in the middle.
  EXPECT_NEAR(find_unreached(square, -far, Vec3(0.6, 10, 10)).share, 0.2, 1e-8);
  EXPECT_NEAR(find_unreached(square, Vec3(-0.5, -0.5, -1), Vec3(0.5, 0.5, 1)).share, 0.75, 1e-8);
  EXPECT_EQ(find_unreached(square, Vec3(3, 3, 3), far).share, 1.0);
  const Unreached corner = find_unreached(square, Vec3(-10, -10, -10), Vec3(0.5, 0.25, 10));
  EXPECT_EQ(corner.farthest, Vec3(1, 1, 0));
  EXPECT_NEAR(corner.distance_m, std::hypot(0.5, 0.75), 1e-7);
}

TEST(ReachCheck, WhatTouchesTheBoxIsInside) {
  const TriangleMesh box = make_box(Vec3(0.3, 0.2, 0.1), 2);
  EXPECT_EQ(find_unreached(box, Vec3(-0.15, -0.1, -0.05), Vec3(0.15, 0.1, 0.05)).share, 0.0);
}

// The share is that of points thrown at the surface.
TEST(ReachCheck, IsThatOfRandomPoints) {
  constexpr unsigned kSeed = 77;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  const TriangleMesh torus = make_torus(0.5, 0.2, 20, 10);
  const Vec3 low(-0.3, -0.6, -0.1);
  const Vec3 high(0.55, 0.2, 0.3);
  double all = 0.0;
  double outside = 0.0;
  for (std::size_t t = 0; t < torus.triangles.size(); ++t) {
    const Vec3 ab = torus.corner(t, 1) - torus.corner(t, 0);
    const Vec3 ac = torus.corner(t, 2) - torus.corner(t, 0);
    const double area = 0.5 * ab.cross(ac).norm();
    constexpr int kThrows = 400;
    int missed = 0;
    for (int i = 0; i < kThrows; ++i) {
      double u = any(random);
      double v = any(random);
      if (u + v > 1.0) std::tie(u, v) = std::pair(1.0 - u, 1.0 - v);
      const Vec3 p = torus.corner(t, 0) + u * ab + v * ac;
      missed += ((low - p).maxCoeff() > 0.0 || (p - high).maxCoeff() > 0.0) ? 1 : 0;
    }
    all += area;
    outside += area * missed / kThrows;
  }
  EXPECT_NEAR(find_unreached(torus, low, high).share, outside / all, 0.01);
}

TEST(ReachCheck, AMeshWithoutAreaCountsByItsVertices) {
  TriangleMesh line;
  line.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(4, 0, 0), Vec3(5, 0, 0)};
  line.triangles = {{0, 1, 2}, {1, 2, 3}};
  EXPECT_EQ(find_unreached(line, Vec3(-1, -1, -1), Vec3(2, 1, 1)).share, 0.5);
}

}  // namespace
}  // namespace hapton
