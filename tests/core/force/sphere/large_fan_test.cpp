#include "core/force/sphere/large_fan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "core/math/straight_motion.h"

namespace hapton {
namespace {

constexpr std::uint64_t kSeedOfFans = 2416;
constexpr Clearance kClearanceOfFans{0.01, 0x1p-40, 0x1p-46};
constexpr std::uint32_t kFanSegments = 200;

// Two cones on one rim; the upper tip is at the given height, above or below the rim.
TriangleMesh double_cone(double height) {
  TriangleMesh mesh;
  mesh.vertices = {{0.0, 0.0, height}, {0.0, 0.0, -0.4}};
  for (std::uint32_t i = 0; i < kFanSegments; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kFanSegments;
    mesh.vertices.emplace_back(0.4 * std::cos(angle), 0.4 * std::sin(angle), 0.0);
  }
  for (std::uint32_t i = 0; i < kFanSegments; ++i) {
    const std::uint32_t a = 2 + i;
    const std::uint32_t b = 2 + (i + 1) % kFanSegments;
    mesh.triangles.insert(mesh.triangles.end(), {{0, a, b}, {1, b, a}});
  }
  return mesh;
}

// A sphere on one face of the upper cone, half way down.
class OnFan : public testing::TestWithParam<double> {
 protected:
  OnFan() : geometry(std::make_unique<TouchGeometry>(std::vector<const TriangleMesh*>{&mesh})), fan(*geometry) {
    RecordProperty("seed", std::to_string(kSeedOfFans));
    near = std::make_unique<GatheredTriangles>(*geometry, materials, kClearanceOfFans, 1e-4);
  }
  double least_distance(const Vec3& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t t = 0; t < geometry->triangle_count(); ++t) least = std::min(least, geometry->separation(t, p).distance);
    return least;
  }
  bool is_of_upper_cone(std::uint32_t triangle) const {
    const Vec3 tip = geometry->to_local(Vec3(0.0, 0.0, GetParam()));
    const ObjectGeometry::Corners corners = geometry->corners(triangle);
    return std::min({(corners.a - tip).norm(), (corners.b - tip).norm(), (corners.c - tip).norm()}) < 1e-9;
  }
  void place_on(std::uint32_t triangle) {
    const ObjectGeometry::Corners corners = geometry->corners(triangle);
    const ContactTriangle shape(corners.a, corners.b, corners.c);
    const Vec3 normal = shape.normal().z() > 0.0 ? shape.normal() : Vec3(-shape.normal());
    centre = (corners.a + corners.b + corners.c) / 3.0 + kClearanceOfFans.offset * normal;
    const OffsetContact face = OffsetContact::on_face(triangle, shape, normal);
    contacts.hold_by({&face, 1});
    descends = false;
  }
  LargeFan::Crossing cross(const Vec3& from, const Vec3& to, double& time) {
    work = 0;
    return fan.cross({contacts, *near, centre, descends, work, 500}, from, to, time);
  }

  TriangleMesh mesh = double_cone(GetParam());
  std::unique_ptr<TouchGeometry> geometry;
  std::vector<Material> materials{Material{}};
  std::unique_ptr<GatheredTriangles> near;
  LargeFan fan;
  ContactSet contacts{kClearanceOfFans};
  Vec3 centre = Vec3::Zero();
  bool descends = false;
  int work = 0;
};

// The sphere stays in contact. Where it has settled, no free position beside it is nearer to the device.
TEST_P(OnFan, CrossesFromFaceToFaceAsBruteForceAllows) {
  std::mt19937_64 random(kSeedOfFans);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int crossed = 0;
  int arrived = 0;
  for (std::uint32_t triangle = 0; triangle < 2 * kFanSegments; triangle += 5) {
    if (!is_of_upper_cone(triangle)) continue;
    place_on(triangle);
    if (least_distance(centre) < kClearanceOfFans.offset - kClearanceOfFans.slop) continue;  // a hollow fan: too near to the faces beside
    const Vec3 from = centre - 0.02 * contacts[0].normal;
    const double x = unit(random);
    const double y = unit(random);
    const Vec3 to = from + 0.03 * Vec3(x, y, unit(random));
    double time = 0.0;
    const std::uint32_t before = contacts[0].triangle;
    const LargeFan::Crossing crossing = cross(from, to, time);
    if (crossing == LargeFan::Crossing::none) continue;
    EXPECT_EQ(crossing, GetParam() > 0.0 ? LargeFan::Crossing::convex : LargeFan::Crossing::hollow);
    crossed += contacts[0].triangle != before ? 1 : 0;
    EXPECT_NEAR(least_distance(centre), kClearanceOfFans.offset, kClearanceOfFans.slop) << triangle;
    if (time < 1.0 || descends) continue;
    ++arrived;
    for (int k = 0; k < 200; ++k) {
      const double u = unit(random);
      const double v = unit(random);
      const Vec3 beside = centre + 1e-3 * Vec3(u, v, unit(random));
      if (least_distance(beside) < kClearanceOfFans.offset) continue;
      EXPECT_GT((beside - to).norm(), (centre - to).norm() - 1e-12) << triangle;
    }
  }
  EXPECT_GT(crossed, 3);
  EXPECT_GT(arrived, 3);
}

TEST_P(OnFan, OtherContactsAreLeftUnchanged) {
  place_on(0);
  const OffsetContact edge = OffsetContact::on_edge(0, contacts[0].shape, 0);
  contacts.hold_by({&edge, 1});
  const Vec3 before = centre;
  double time = 0.25;
  EXPECT_EQ(cross(centre - Vec3(0.0, 0.0, 0.02), centre - Vec3(0.01, 0.0, 0.02), time), LargeFan::Crossing::none);
  EXPECT_EQ(time, 0.25);
  EXPECT_EQ(centre, before);
}

INSTANTIATE_TEST_SUITE_P(Heights, OnFan, testing::Values(0.3, -0.2));

}  // namespace
}  // namespace hapton
