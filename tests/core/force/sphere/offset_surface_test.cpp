#include "core/force/sphere/offset_surface.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "core/geometry/point_triangle.h"

namespace hapton {
namespace {

class OffsetSurface : public testing::Test {
 protected:
  OffsetSurface() { RecordProperty("seed", std::to_string(kSeed)); }
  double unit() { return unit_(random_); }
  Vec3 vector() {
    const double x = unit();
    const double y = unit();
    return {x, y, unit()};
  }
  // Every tenth triangle is a needle.
  ContactTriangle triangle(int i) {
    const Vec3 a = vector();
    const Vec3 b = vector();
    return {a, b, i % 10 == 9 ? Vec3(a + 0.6 * (b - a) + 1e-7 * vector()) : vector()};
  }

 private:
  static constexpr std::uint64_t kSeed = 41;
  std::mt19937_64 random_{kSeed};
  std::uniform_real_distribution<double> unit_{-1.0, 1.0};
};

TEST_F(OffsetSurface, NearestIsThePartThatBruteForceFinds) {
  constexpr int kGrid = 40;
  int parts[3] = {0, 0, 0};
  for (int i = 0; i < 600; ++i) {
    const ContactTriangle shape = triangle(i);
    const Vec3 c = 2.0 * vector();
    const OffsetContact contact = OffsetContact::nearest(17, shape, c);
    EXPECT_EQ(contact.triangle, 17U);
    ++parts[static_cast<int>(contact.part)];
    double sampled = std::numeric_limits<double>::infinity();
    for (int u = 0; u <= kGrid; ++u) {
      for (int v = 0; u + v <= kGrid; ++v) {
        const Vec3 p = shape.corner(0) + shape.edge(0) * u / kGrid - shape.edge(2) * v / kGrid;
        sampled = std::min(sampled, (c - p).norm());
      }
    }
    const OffsetContact::Proximity proximity = contact.proximity(c);
    const double spacing = std::max({shape.length(0), shape.length(1), shape.length(2)}) / kGrid;
    ASSERT_LE(proximity.distance, sampled + 1e-14);
    ASSERT_GE(proximity.distance, sampled - spacing);
    const Separation at = separation_from_triangle(c, shape.corner(0), shape.corner(1), shape.corner(2));
    ASSERT_EQ(contact.part, at.feature);
    ASSERT_NEAR(proximity.distance, at.distance, 1e-14);
    ASSERT_LT((proximity.normal - at.normal).norm(), 1e-13);
  }
  for (const int count : parts) EXPECT_GT(count, 20);
}

TEST_F(OffsetSurface, OfATriangleWithoutAreaItIsAnEdgeOrAVertex) {
  const Vec3 a(0.1, 0.2, 0.3);
  const Vec3 b(0.9, 0.1, -0.2);
  for (const ContactTriangle& shape : {ContactTriangle(a, b, a), ContactTriangle(a, b, b), ContactTriangle(a, b, 0.5 * (a + b))}) {
    const Vec3 beside = 0.25 * a + 0.75 * b + 0.3 * (b - a).unitOrthogonal();
    const OffsetContact edge = OffsetContact::nearest(0, shape, beside);
    EXPECT_EQ(edge.part, Feature::edge);
    EXPECT_NEAR(edge.proximity(beside).distance, 0.3, 1e-15);
    const Vec3 beyond = b + 0.3 * (b - a);
    const OffsetContact vertex = OffsetContact::nearest(0, shape, beyond);
    EXPECT_EQ(vertex.part, Feature::vertex);
    EXPECT_EQ(vertex.origin(), b);
  }
  const ContactTriangle point(a, a, a);
  EXPECT_EQ(OffsetContact::nearest(0, point, b).part, Feature::vertex);
  EXPECT_EQ(OffsetContact::on_edge(0, ContactTriangle(a, b, b), 1).part, Feature::vertex);
}

TEST_F(OffsetSurface, AFaceNormalPointsToTheCentre) {
  for (int i = 0; i < 100; ++i) {
    const ContactTriangle shape = triangle(0);
    const Vec3 on_face = (shape.corner(0) + shape.corner(1) + shape.corner(2)) / 3.0;
    for (const double side : {1.0, -1.0}) {
      const Vec3 c = on_face + side * 0.2 * shape.normal();
      const OffsetContact contact = OffsetContact::nearest(3, shape, c);
      ASSERT_EQ(contact.part, Feature::face);
      EXPECT_EQ(contact.back, side < 0.0);
      EXPECT_EQ(contact.normal, Vec3(side * shape.normal()));
      EXPECT_NEAR(contact.proximity(c).distance, 0.2, 1e-14);
      EXPECT_FALSE(contact.is_curved());
      EXPECT_EQ(OffsetContact::on_face(3, shape, side * (shape.normal() + shape.edge(0))).normal, contact.normal);
      // The distance is that from the plane: also beyond the border of the triangle, and below it.
      EXPECT_NEAR(contact.proximity(c + 5.0 * shape.edge(1)).distance, 0.2, 1e-13);
      EXPECT_LT(contact.proximity(on_face - side * 0.1 * shape.normal()).distance, 0.0);
    }
  }
}

TEST_F(OffsetSurface, DistanceIsMeasuredFromTheLineOfAnEdgeAndFromAVertex) {
  for (int i = 0; i < 200; ++i) {
    const ContactTriangle shape = triangle(i);
    const int k = i % 3;
    const OffsetContact edge = OffsetContact::on_edge(0, shape, k);
    const Vec3 out = edge.axis.unitOrthogonal();
    const OffsetContact::Proximity at = edge.proximity(edge.origin() + unit() * edge.axis + 0.3 * out);
    EXPECT_NEAR(at.distance, 0.3, 1e-15);
    EXPECT_LT((at.normal - out).norm(), 1e-14);
    EXPECT_LE(std::fabs(at.normal.dot(edge.axis)), 0x1p-52);
    const OffsetContact vertex = OffsetContact::on_vertex(0, shape, k);
    const Vec3 off = vector();
    EXPECT_NEAR(vertex.proximity(shape.corner(k) + off).distance, off.norm(), 1e-15);
    EXPECT_LT((vertex.proximity(shape.corner(k) + off).normal - off.normalized()).norm(), 1e-14 / off.norm());
    EXPECT_TRUE(edge.is_curved() && vertex.is_curved());
  }
  const OffsetContact vertex = OffsetContact::on_vertex(0, triangle(0), 0);
  EXPECT_EQ(vertex.proximity(vertex.origin()).distance, 0.0);
  EXPECT_EQ(vertex.proximity(vertex.origin()).normal.norm(), 1.0);
}

// At s along a tangent, the distance from the part has grown by curvature s^2 / 2.
TEST_F(OffsetSurface, CurvatureIsThatOfFiniteDifferences) {
  for (int i = 0; i < 300; ++i) {
    const ContactTriangle shape = triangle(0);
    const double offset = 0.05 + 0.3 * std::fabs(unit());
    const OffsetContact contact = i % 3 == 0   ? OffsetContact::on_face(0, shape, shape.normal())
                                  : i % 3 == 1 ? OffsetContact::on_edge(0, shape, 1)
                                               : OffsetContact::on_vertex(0, shape, 2);
    const Vec3 normal = contact.proximity(contact.origin() + vector()).normal;
    const Vec3 v = vector();
    const Vec3 tangent = (v - normal.dot(v) * normal).normalized();
    const Vec3 c = contact.origin() + offset * normal;
    const double s = 1e-3 * offset;
    const double rise = 0.5 * (contact.proximity(c + s * tangent).distance + contact.proximity(c - s * tangent).distance) - offset;
    EXPECT_NEAR(contact.curvature(tangent, offset) * offset, 2.0 * rise / (s * s) * offset, 1e-5);
  }
}

TEST_F(OffsetSurface, ItsGuideKeepsAPathAtTheOffset) {
  for (int i = 0; i < 300; ++i) {
    const ContactTriangle shape = triangle(0);
    const double offset = 0.05 + 0.3 * std::fabs(unit());
    const OffsetContact contact = i % 3 == 0   ? OffsetContact::on_face(0, shape, shape.normal())
                                  : i % 3 == 1 ? OffsetContact::on_edge(0, shape, 1)
                                               : OffsetContact::on_vertex(0, shape, 2);
    const auto onto = [&](const Vec3& p) { return Vec3(p + (offset - contact.proximity(p).distance) * contact.proximity(p).normal); };
    const Vec3 from = onto(contact.origin() + vector());
    const Vec3 to = onto(from + 0.2 * offset * vector());
    CentrePath path = CentrePath::curved(from, to, to - from, to - from);
    path.add_guide(contact.guide(offset));
    for (int k = 0; k <= 20; ++k) EXPECT_NEAR(contact.proximity(path.at(k / 20.0)).distance, offset, 0x1p-50);
  }
}

TEST_F(OffsetSurface, PartsAreEqualByTheirPositions) {
  const Vec3 a = vector();
  const Vec3 b = vector();
  const Vec3 c = vector();
  const Vec3 d = vector();
  const ContactTriangle shape(a, b, c);
  const ContactTriangle beside(b, a, d);           // shares edge 0 of shape
  const ContactTriangle at_corner(d, a, 2.0 * d);  // shares corner 0 of shape
  const ContactTriangle copy(c, b, a);
  const OffsetContact face = OffsetContact::on_face(0, shape, shape.normal());
  const OffsetContact edge = OffsetContact::on_edge(0, shape, 0);
  const OffsetContact vertex = OffsetContact::on_vertex(0, shape, 0);
  EXPECT_TRUE(face.is_shared_with(copy) && edge.is_shared_with(copy) && vertex.is_shared_with(copy));
  EXPECT_TRUE(!face.is_shared_with(beside) && edge.is_shared_with(beside) && vertex.is_shared_with(beside));
  EXPECT_TRUE(!face.is_shared_with(at_corner) && !edge.is_shared_with(at_corner) && vertex.is_shared_with(at_corner));
  EXPECT_FALSE(OffsetContact::on_edge(0, shape, 1).is_shared_with(beside));
  EXPECT_FALSE(OffsetContact::on_vertex(0, shape, 2).is_shared_with(at_corner));
  EXPECT_TRUE(edge.is_same_part(OffsetContact::on_edge(1, beside, 0)));
  EXPECT_FALSE(edge.is_same_part(OffsetContact::on_edge(1, beside, 1)));
  EXPECT_FALSE(edge.is_same_part(OffsetContact::on_edge(1, copy, 0)));
  EXPECT_TRUE(edge.is_same_part(OffsetContact::on_edge(1, copy, 1)));
  EXPECT_TRUE(vertex.is_same_part(OffsetContact::on_vertex(1, at_corner, 1)));
  EXPECT_FALSE(vertex.is_same_part(OffsetContact::on_vertex(1, at_corner, 0)));
  EXPECT_FALSE(vertex.is_same_part(edge));
  EXPECT_FALSE(face.is_same_part(OffsetContact::on_face(1, copy, copy.normal())));
}

}  // namespace
}  // namespace hapton
