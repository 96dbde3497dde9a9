#include "core/geometry/triangle_plane.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

// The inside test for a point p in the frame of the triangle's corners, without a tolerance except for rounding.
bool contains(const TrianglePlane& plane, const Vec3& p) {
  const Vec3 local = p - plane.origin;
  return plane.contains(local[plane.u_axis], local[plane.v_axis], 0.0, 0.0, 0.0);
}

TEST(TrianglePlane, NormalFollowsTheWindingOfTheCorners) {
  const auto plane = compute_triangle_plane({0, 0, 5}, {2, 0, 5}, {0, 3, 5});
  ASSERT_TRUE(plane);
  EXPECT_EQ(plane->normal, Vec3(0, 0, 1));
  EXPECT_EQ(plane->height_of({7, 8, 9}), 4.0);
  EXPECT_EQ(compute_triangle_plane({0, 0, 5}, {0, 3, 5}, {2, 0, 5})->normal, Vec3(0, 0, -1));
}

TEST(TrianglePlane, DegenerateTrianglesHaveNone) {
  EXPECT_FALSE(compute_triangle_plane({1, 2, 3}, {1, 2, 3}, {1, 2, 3}));
  EXPECT_FALSE(compute_triangle_plane({0, 0, 0}, {1, 1, 1}, {0, 0, 0}));
  EXPECT_FALSE(compute_triangle_plane({0, 0, 0}, {1, 1, 1}, {3, 3, 3}));
  EXPECT_FALSE(compute_triangle_plane({0.1, 0.1, 0.1}, {0.3, 0.3, 0.3}, {0.7, 0.7, 0.7}));
}

TEST(TrianglePlane, NeedlesAndTinyTrianglesKeepTheirPlane) {
  const auto needle = compute_triangle_plane({0, 0, 1}, {1, 0, 1}, {0.5, 1e-9, 1});
  ASSERT_TRUE(needle);
  EXPECT_EQ(needle->normal, Vec3(0, 0, 1));
  for (const double size : {1e-160, 1e-12, 1.0, 1e6, 1e150}) {
    const auto plane = compute_triangle_plane(size * Vec3(0, 0, 0), size * Vec3(1, 0, 1), size * Vec3(0, 1, 0));
    ASSERT_TRUE(plane) << size;
    EXPECT_NEAR(plane->normal.norm(), 1.0, 1e-15);
    EXPECT_TRUE(contains(*plane, size * Vec3(0.25, 0.25, 0.25)));
    EXPECT_FALSE(contains(*plane, size * Vec3(0.6, 0.6, 0.6)));
  }
}

TEST(TrianglePlane, InsideAgreesWithBarycentricCoordinates) {
  constexpr std::uint64_t kSeed = 11;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto draw_vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  int inside = 0;
  int outside = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 a = draw_vector();
    const Vec3 b = draw_vector();
    const Vec3 c = draw_vector();
    const auto plane = compute_triangle_plane(a, b, c);
    ASSERT_TRUE(plane);
    for (int k = 0; k < 20; ++k) {
      const double s = 1.5 * unit(random);
      const double t = 1.5 * unit(random);
      const double least_coordinate = std::min({s, t, 1.0 - s - t});
      if (std::abs(least_coordinate) < 1e-9) {
        continue;  // too near the outline for plain arithmetic to decide
      }
      const bool expected = least_coordinate > 0;
      ASSERT_EQ(contains(*plane, a + s * (b - a) + t * (c - a)), expected) << "triangle " << i << " s " << s << " t " << t;
      (expected ? inside : outside)++;
    }
  }
  EXPECT_GT(inside, 1500);
  EXPECT_GT(outside, 20000);
}

TEST(TrianglePlane, TheOutlineBelongsToTheTriangle) {
  const Vec3 a(0, 0, 0);
  const Vec3 b(4, 0, 0);
  const Vec3 c(4, 2, 0);
  const Vec3 d(0, 2, 0);
  const auto lower = compute_triangle_plane(a, b, c);
  const auto upper = compute_triangle_plane(a, c, d);
  for (const Vec3& p : {a, b, c, Vec3(2, 0, 0), Vec3(4, 1, 0), Vec3(2, 1, 0)}) {
    EXPECT_TRUE(contains(*lower, p)) << p.transpose();
  }
  for (const Vec3& p : {a, c, d, Vec3(2, 2, 0), Vec3(0, 1, 0), Vec3(2, 1, 0)}) {
    EXPECT_TRUE(contains(*upper, p)) << p.transpose();
  }
  for (const Vec3& p : {Vec3(2, -1e-12, 0), Vec3(4 + 1e-12, 1, 0), Vec3(2, 1 + 1e-12, 0)}) {
    EXPECT_FALSE(contains(*lower, p)) << p.transpose();
  }
}

TEST(TrianglePlane, ToleranceWidensTheOutlineByThatMuch) {
  const auto plane = compute_triangle_plane({0, 0, 0}, {4, 0, 0}, {4, 2, 0});
  const Vec3 p(2, -0.1, 0);
  const double u = p[plane->u_axis];
  const double v = p[plane->v_axis];
  EXPECT_FALSE(plane->contains(u, v, 0.09, 0, 0));
  EXPECT_TRUE(plane->contains(u, v, 0.11, 0, 0));
  const Vec3 along(3, 0.11, 0);
  EXPECT_TRUE(plane->contains(u, v, 0, along[plane->u_axis], along[plane->v_axis]));
  const Vec3 beside(3, 0.09, 0);
  EXPECT_FALSE(plane->contains(u, v, 0, beside[plane->u_axis], beside[plane->v_axis]));
}

}  // namespace
}  // namespace hapton
