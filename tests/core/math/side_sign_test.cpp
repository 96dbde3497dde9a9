#include "core/math/side_sign.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

TEST(SideSign, IsTheExactSignWhereThereIsOne) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  const auto draw = [&] { return Vec3(place(random), place(random), place(random)); };
  for (int i = 0; i < 1000; ++i) {
    const Vec3 a = draw();
    const Vec3 b = draw();
    const Vec3 c = draw();
    const Vec3 p = draw();
    const Vec3 q = draw();
    EXPECT_EQ(side_sign(a, b, c, p) > 0.0, orient3d_exact(a, b, c, p) > 0.0) << i;
    EXPECT_EQ(pass_sign(p, q, a, b) > 0.0, orient3d_exact(p, q, a, b) > 0.0) << i;
  }
}

// On a lattice nearly every point lies in the plane of some others.
TEST(SideSign, IsNeverZeroAndChangesSignWithTheTriangle) {
  std::mt19937_64 random(12);
  const auto draw = [&] {
    const auto step = [&] { return static_cast<double>(random() % 3) - 1.0; };
    const double x = step();
    const double y = step();
    return Vec3(x, y, step());
  };
  int in_plane = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 a = draw();
    const Vec3 b = draw();
    const Vec3 c = draw();
    const Vec3 p = draw();
    const Vec3 q = draw();
    if ((b - a).cross(c - a).isZero(0.0) || p == q) continue;
    in_plane += orient3d_exact(a, b, c, p) == 0.0 ? 1 : 0;
    const double side = side_sign(a, b, c, p);
    ASSERT_NE(side, 0.0);
    ASSERT_EQ(side > 0.0, side_sign(b, c, a, p) > 0.0);
    ASSERT_EQ(side > 0.0, side_sign(a, c, b, p) < 0.0);
    ASSERT_EQ(pass_sign(p, q, a, b) > 0.0, pass_sign(p, q, b, a) < 0.0);
  }
  EXPECT_GT(in_plane, 1000);
}

}  // namespace
}  // namespace hapton
