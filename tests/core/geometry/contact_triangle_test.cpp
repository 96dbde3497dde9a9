#include "core/geometry/contact_triangle.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

void expect_same_separation(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Separation expected = separation_from_triangle(p, a, b, c);
  const Separation found = ContactTriangle(a, b, c).separation(p);
  EXPECT_NEAR(found.distance, expected.distance, 1e-15);
  EXPECT_LE((found.nearest - expected.nearest).norm(), 1e-14);
  if (expected.distance > 1e-6) {
    EXPECT_LE((found.normal - expected.normal).norm(), 1e-9);
  }
  EXPECT_NEAR(found.normal.norm(), 1.0, 1e-14);
}

TEST(ContactTriangle, AgreesWithTheFunctionForOnePoint) {
  constexpr unsigned kSeed = 515;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> coordinate(-0.5, 0.5);
  const auto point = [&] { return Vec3(coordinate(random), coordinate(random), coordinate(random)); };
  for (int i = 0; i < 20000; ++i) {
    const Vec3 a = point();
    const Vec3 b = point();
    const double thinness = i % 4 == 0 ? 1e-6 : 1.0;
    const Vec3 c = a + 0.3 * (b - a) + thinness * point();
    expect_same_separation(point(), a, b, c);
    expect_same_separation(a + 1e-9 * point(), a, b, c);
  }
}

TEST(ContactTriangle, WithoutAreaItIsItsEdges) {
  const Vec3 a(0, 0, 0);
  const Vec3 b(0.5, 0, 0);
  expect_same_separation({0.25, 0.125, 0}, a, b, {0.75, 0, 0});
  expect_same_separation({0.3, 0.4, 0}, a, a, a);
  EXPECT_EQ(ContactTriangle(a, a, a).separation({0.3, 0.4, 0}).distance, 0.5);
  EXPECT_TRUE(ContactTriangle(a, a, a).separation(a).normal.allFinite());
}

}  // namespace
}  // namespace hapton
