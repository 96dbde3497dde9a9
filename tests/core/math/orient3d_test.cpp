#include "core/math/orient3d.h"

#include <gtest/gtest.h>

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <random>

namespace hapton {
namespace {

using Exact = boost::multiprecision::cpp_rational;

Exact exact_determinant(const std::array<Vec3, 4>& p) {
  std::array<std::array<Exact, 3>, 3> m;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) m[i][k] = Exact(p[i + 1][k]) - Exact(p[0][k]);
  }
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

int sign_of(const Exact& x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }
int sign_of(double x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }

void expect_exact(const std::array<Vec3, 4>& p) {
  const Exact exact = exact_determinant(p);
  const double value = orient3d(p[0], p[1], p[2], p[3]);
  ASSERT_EQ(sign_of(value), sign_of(exact));
  ASSERT_EQ(sign_of(orient3d_sign(p[0], p[1], p[2], p[3])), sign_of(exact));
  const double precise = orient3d_exact(p[0], p[1], p[2], p[3]);
  ASSERT_EQ(sign_of(precise), sign_of(exact));
  if (exact != 0) {
    ASSERT_LT(abs(Exact(value) / exact - 1), Exact(0x1p-20));
    ASSERT_LT(abs(Exact(precise) / exact - 1), Exact(0x1p-50));
  }
}

class RandomPoints {
 public:
  explicit RandomPoints(std::uint64_t seed) : random_(seed) {}
  double real(double scale) { return std::uniform_real_distribution<double>(-scale, scale)(random_); }
  Vec3 point(double scale) { return {real(scale), real(scale), real(scale)}; }
  // Whole numbers: sums and small multiples of them are exact.
  Vec3 integers(int bits) {
    std::uniform_int_distribution<std::int64_t> integer(-(std::int64_t{1} << bits), std::int64_t{1} << bits);
    return {static_cast<double>(integer(random_)), static_cast<double>(integer(random_)), static_cast<double>(integer(random_))};
  }
  int pick(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random_); }

 private:
  std::mt19937_64 random_;
};

TEST(Orient3d, SignIsTheSide) {
  EXPECT_GT(orient3d(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)), 0.0);
  EXPECT_LT(orient3d(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, -1)), 0.0);
  EXPECT_DOUBLE_EQ(orient3d(Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 3, 0), Vec3(9, 9, 4)), 24.0);
}

TEST(Orient3d, IsExactForRandomPoints) {
  RandomPoints points(1);
  for (int i = 0; i < 2000; ++i) {
    const double scale = std::ldexp(1.0, points.pick(120) - 60);
    expect_exact({points.point(scale), points.point(scale), points.point(scale), points.point(scale)});
  }
}

TEST(Orient3d, IsZeroExactlyForCoplanarPoints) {
  RandomPoints points(2);
  for (int i = 0; i < 1000; ++i) {
    const double scale = std::ldexp(1.0, points.pick(60) - 50);
    const Vec3 a = points.integers(45) * scale;
    const Vec3 u = points.integers(45) * scale;
    const Vec3 v = points.integers(45) * scale;
    const double s = points.pick(7) - 3;
    const double t = points.pick(7) - 3;
    const std::array<Vec3, 4> p = {a, a + u, a + v, a + s * u + t * v};
    ASSERT_EQ(exact_determinant(p), 0);
    EXPECT_EQ(orient3d(p[0], p[1], p[2], p[3]), 0.0);
    EXPECT_EQ(orient3d_sign(p[0], p[1], p[2], p[3]), 0.0);
  }
}

// A point one unit in the last place off a plane: there, the sign from plain double arithmetic is noise.
TEST(Orient3d, SeesOneUnitInTheLastPlace) {
  RandomPoints points(3);
  int wrong_in_doubles = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 a = points.point(1.0);
    const Vec3 u = points.point(1e-3);
    const Vec3 v = points.point(1e-3);
    Vec3 d = a + points.real(1.0) * u + points.real(1.0) * v;
    const int k = points.pick(3);
    d[k] = std::nextafter(d[k], points.real(1.0) > 0.0 ? 2.0 : -2.0);
    const std::array<Vec3, 4> p = {a, a + u, a + v, d};
    expect_exact(p);
    const double simple = (p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]);
    wrong_in_doubles += sign_of(simple) != sign_of(exact_determinant(p)) ? 1 : 0;
  }
  EXPECT_GT(wrong_in_doubles, 0) << "the cases are too easy to show anything";
}

TEST(Orient3d, IsExactWhereMagnitudesDiffer) {
  RandomPoints points(4);
  for (int i = 0; i < 2000; ++i) {
    std::array<Vec3, 4> p;
    for (Vec3& q : p) {
      for (int k = 0; k < 3; ++k) q[k] = points.real(std::ldexp(1.0, points.pick(80) - 60));
    }
    if (points.pick(2) == 0) p[3] = p[points.pick(3)] + points.point(1e-17);
    expect_exact(p);
  }
}

TEST(Orient3d, IsAntisymmetric) {
  RandomPoints points(5);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 a = points.point(1.0);
    const Vec3 b = a + points.point(1e-8);
    const Vec3 c = a + points.point(1e-8);
    const Vec3 d = a + points.point(1e-8);
    EXPECT_EQ(sign_of(orient3d_sign(a, b, c, d)), -sign_of(orient3d_sign(b, a, c, d)));
    EXPECT_EQ(sign_of(orient3d_sign(a, b, c, d)), sign_of(orient3d_sign(c, a, b, d)));
    EXPECT_EQ(sign_of(orient3d_sign(a, b, c, d)), -sign_of(orient3d_sign(d, b, c, a)));
  }
}

}  // namespace
}  // namespace hapton
