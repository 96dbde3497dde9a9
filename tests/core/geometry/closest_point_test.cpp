#include "core/geometry/closest_point.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace hapton {
namespace {

constexpr double kRounding = std::numeric_limits<double>::epsilon();

// The comparison uses a 113-bit mantissa: with needles, rounding destroys all the extra digits of long double.
__extension__ typedef __float128 Quad;

struct QuadVec3 {
  Quad x, y, z;
  explicit QuadVec3(const Vec3& v) : x(v.x()), y(v.y()), z(v.z()) {}
  QuadVec3(Quad x_, Quad y_, Quad z_) : x(x_), y(y_), z(z_) {}
};
QuadVec3 operator-(const QuadVec3& a, const QuadVec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
QuadVec3 operator+(const QuadVec3& a, const QuadVec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
QuadVec3 operator*(Quad s, const QuadVec3& a) { return {s * a.x, s * a.y, s * a.z}; }
Quad dot(const QuadVec3& a, const QuadVec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
QuadVec3 cross(const QuadVec3& a, const QuadVec3& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
Quad squared_distance_to_segment(const QuadVec3& a, const QuadVec3& b, const QuadVec3& p) {
  const QuadVec3 e = b - a;
  const Quad length2 = dot(e, e);
  Quad t = length2 > 0 ? dot(p - a, e) / length2 : Quad(0);
  t = t < 0 ? Quad(0) : t > 1 ? Quad(1) : t;
  const QuadVec3 off = p - (a + t * e);
  return dot(off, off);
}

double reference_distance(const QuadVec3& a, const QuadVec3& b, const QuadVec3& c, const QuadVec3& p) {
  const QuadVec3 n = cross(b - a, c - a);
  const Quad n2 = dot(n, n);
  if (n2 > 0 && dot(cross(n, b - a), p - a) >= 0 && dot(cross(n, c - b), p - b) >= 0 && dot(cross(n, a - c), p - c) >= 0) {
    const Quad height = dot(n, p - a);
    return std::sqrt(static_cast<double>(height * height / n2));
  }
  const Quad best =
      std::min({squared_distance_to_segment(a, b, p), squared_distance_to_segment(b, c, p), squared_distance_to_segment(c, a, p)});
  return std::sqrt(static_cast<double>(best));
}

struct Shape {
  const char* name;
  Vec3 a, b, c;
};

class ClosestPointOnShape : public ::testing::TestWithParam<Shape> {};

TEST_P(ClosestPointOnShape, AgreesWithQuadPrecision) {
  const auto& [name, a, b, c] = GetParam();
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
  const double size = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  for (int i = 0; i < 20000; ++i) {
    const double spread = size * std::pow(10.0, 6.0 * symmetric(random) - 5.5);
    double u = std::abs(symmetric(random));
    double v = std::abs(symmetric(random));
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    const Vec3 p = a + u * (b - a) + v * (c - a) + spread * Vec3(symmetric(random), symmetric(random), symmetric(random));
    const ClosestPoint found = closest_point(a, b, c, p);
    const double expected = reference_distance(QuadVec3(a), QuadVec3(b), QuadVec3(c), QuadVec3(p));
    const double scale = std::max({size, (p - a).norm(), a.cwiseAbs().maxCoeff()});
    ASSERT_NEAR(found.distance, expected, 16.0 * kRounding * scale) << name << " at " << p.transpose();
    ASSERT_NEAR((p - found.point).norm(), expected, 32.0 * kRounding * scale);
    ASSERT_NEAR(found.barycentric.sum(), 1.0, 1e-12);
    ASSERT_GE(found.barycentric.minCoeff(), 0.0);
    if (found.distance > 1e-6 * scale) {
      ASSERT_NEAR(found.direction.norm(), 1.0, 1e-14);
      ASSERT_LT((found.direction - (p - found.point).normalized()).norm(), 1e-8);
    }
    if (found.feature != TriangleFeature::face) {
      const Vec3 from_barycentric = found.barycentric[0] * a + found.barycentric[1] * b + found.barycentric[2] * c;
      ASSERT_LT((from_barycentric - found.point).norm(), 16.0 * kRounding * scale);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, ClosestPointOnShape,
                         ::testing::Values(Shape{"plain", {0, 0, 0}, {1, 0, 0}, {0.3, 0.8, 0.2}},
                                           Shape{"far away", {1e6, 1e6, 0}, {1e6 + 1, 1e6, 0}, {1e6, 1e6 + 1, 0.5}},
                                           Shape{"needle", {0, 0, 0}, {1, 0.4, 0.3}, {1.0 + 1e-9, 0.4 + 1e-9, 0.3 - 1e-9}},
                                           Shape{"cap", {0, 0, 0}, {1, 0.4, 0.3}, {0.5 + 1e-10, 0.2 - 1e-10, 0.15 + 1e-10}},
                                           Shape{"cap at rounding", {0, 0, 0}, {1, 0.4, 0.3}, {0.37 * 1.0, 0.37 * 0.4, 0.37 * 0.3 + 1e-16}},
                                           Shape{"collinear", {0, 0, 0}, {1, 1, 1}, {2, 2, 2}},
                                           Shape{"two equal corners", {0.1, 0.2, 0.3}, {0.1, 0.2, 0.3}, {1, 1, 0}},
                                           Shape{"micrometre", {1e-6, 0, 0}, {0, 1e-6, 0}, {0, 0, 1e-6}},
                                           Shape{"megametre", {1e6, 0, 0}, {0, 1e6, 0}, {0, 0, 1e6}}));

TEST(ClosestPoint, NamesTheFeature) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  EXPECT_EQ(closest_point(a, b, c, Vec3(0.2, 0.2, 1)).feature, TriangleFeature::face);
  EXPECT_EQ(closest_point(a, b, c, Vec3(0.5, -1, 0)).feature, TriangleFeature::edge0);
  EXPECT_EQ(closest_point(a, b, c, Vec3(1, 1, 0)).feature, TriangleFeature::edge1);
  EXPECT_EQ(closest_point(a, b, c, Vec3(-1, 0.5, 0)).feature, TriangleFeature::edge2);
  EXPECT_EQ(closest_point(a, b, c, Vec3(-1, -1, 0)).feature, TriangleFeature::vertex0);
  EXPECT_EQ(closest_point(a, b, c, Vec3(3, 0, 0)).feature, TriangleFeature::vertex1);
  EXPECT_EQ(closest_point(a, b, c, Vec3(0, 3, 0)).feature, TriangleFeature::vertex2);
}

TEST(ClosestPoint, FaceDirectionPointsToTheQuery) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  EXPECT_EQ(closest_point(a, b, c, Vec3(0.2, 0.2, 1e-13)).direction, Vec3(0, 0, 1));
  EXPECT_EQ(closest_point(a, b, c, Vec3(0.2, 0.2, -1e-13)).direction, Vec3(0, 0, -1));
}

TEST(ClosestPoint, BothNeighboursOfAnEdgeAgreeToTheBit) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
  auto draw = [&] { return Vec3(symmetric(random), symmetric(random), symmetric(random)); };
  int compared = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 a = draw(), b = draw(), c = draw(), d = draw(), p = draw();
    const ClosestPoint one = closest_point(a, b, c, p);
    const ClosestPoint two = closest_point(b, a, d, p);
    if (one.feature != TriangleFeature::edge0 || two.feature != TriangleFeature::edge0) continue;
    ++compared;
    ASSERT_EQ(one.distance, two.distance);
    ASSERT_EQ(one.direction, two.direction);
    ASSERT_EQ(one.point, two.point);
  }
  EXPECT_GT(compared, 500);
}

TEST(ClosestPoint, OnePointTriangle) {
  const Vec3 a(0.5, 0.25, 1.0);
  const ClosestPoint found = closest_point(a, a, a, Vec3(0.5, 0.25, 3.0));
  EXPECT_EQ(found.distance, 2.0);
  EXPECT_EQ(found.direction, Vec3(0, 0, 1));
  EXPECT_TRUE(is_vertex(found.feature));
  EXPECT_EQ(closest_point(a, a, a, a).direction, Vec3(0, 0, 0));
}

}  // namespace
}  // namespace hapton
