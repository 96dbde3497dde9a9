#include "core/force/proxy/swept_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kSweptOffset = 0x1p-30;
constexpr Clearance kSweptClearance{.offset = kSweptOffset, .slop = 0.5 * kSweptOffset, .tolerance = 0x1p-10 * kSweptOffset};

struct SweptStage {
  explicit SweptStage(const TriangleMesh& mesh, const Clearance& keep = kSweptClearance, const Material& material = {})
      : geometry({&mesh}),
        materials{material},
        surfaces(geometry, materials),
        clearance(keep),
        swept(surfaces, keep, keep.offset == kSweptOffset) {}

  void put(const Vec3& p_S) { proxy.settle_at(geometry.to_local(p_S)); }
  void move(const Vec3& p_S) {
    device = geometry.to_local(p_S);
    swept.descend(proxy, device);
  }
  Vec3 position() const { return geometry.to_scene(proxy.position); }
  double distance_by_brute_force() const {
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) {
      least = std::min(least, geometry.separation(t, proxy.position).distance);
    }
    return least;
  }

  TouchGeometry geometry;
  std::vector<Material> materials;
  ProxySurfaces surfaces;
  Clearance clearance;
  SweptMotion swept;
  ProxyState proxy;
  Vec3 device = Vec3::Zero();
};

TEST(SweptMotion, AFreeProxyFollowsTheDevice) {
  SweptStage stage(make_box(Vec3::Constant(0.1)));
  stage.put(Vec3(0.2, 0.0, 0.0));
  stage.move(Vec3(0.0, 0.2, 0.0));
  EXPECT_TRUE(stage.proxy.is_free);
  EXPECT_EQ(stage.proxy.position, stage.device);
}

TEST(SweptMotion, AFaceHoldsTheProxyAboveTheDevice) {
  SweptStage stage(make_box(Vec3::Constant(0.1), 3));
  stage.put(Vec3(0.07, 0.01, 0.02));
  stage.move(Vec3(0.03, 0.01, 0.02));
  EXPECT_FALSE(stage.proxy.is_free);
  EXPECT_LE((stage.position() - Vec3(0.05, 0.01, 0.02)).norm(), 4.0 * kSweptOffset);
  ASSERT_EQ(stage.proxy.active_count, 1);
  EXPECT_NEAR(stage.proxy.multipliers[0] * stage.geometry.unit_m(), 0.02, 1e-9);
  stage.move(Vec3(0.03, 0.03, -0.03));  // slides on the face
  EXPECT_LE((stage.position() - Vec3(0.05, 0.03, -0.03)).norm(), 4.0 * kSweptOffset);
  stage.move(Vec3(0.06, 0.03, -0.03));
  EXPECT_TRUE(stage.proxy.is_free);
}

TEST(SweptMotion, ThreeFacesHoldItInTheCornerOfARoom) {
  SweptStage stage(make_box(Vec3::Constant(0.1), 2));
  stage.put(Vec3(0.013, 0.017, 0.011));
  stage.move(Vec3(0.06, 0.07, 0.08));
  EXPECT_EQ(stage.proxy.active_count, 3);
  EXPECT_LE((stage.position() - Vec3::Constant(0.05)).norm(), 8.0 * kSweptOffset);
  Vec3 sum = stage.device - stage.proxy.position;
  for (int i = 0; i < 3; ++i) sum += stage.proxy.multipliers[i] * stage.proxy.contacts[i].separation.normal;
  EXPECT_LE(sum.norm(), 1e-8);
}

TEST(SweptMotion, FrictionHoldsItUpToTheConesEdge) {
  for (const double friction : {0.3, 0.6}) {
    SweptStage stage(make_box(Vec3::Constant(0.1), 3), kSweptClearance, {.friction_static = friction, .friction_dynamic = friction});
    stage.put(Vec3(0.07, 0.0, 0.0));
    stage.move(Vec3(0.04, 0.0, 0.0));
    stage.move(Vec3(0.04, 0.99 * friction * 0.01, 0.0));
    EXPECT_LE((stage.position() - Vec3(0.05, 0.0, 0.0)).norm(), 1e-9);
    stage.move(Vec3(0.04, friction * 0.01 + 0.005, 0.0));
    EXPECT_NEAR(stage.position().y(), 0.005, 1e-8);
    EXPECT_TRUE(stage.proxy.slides);
  }
}

TEST(SweptMotion, BreaksAwayAtTheStaticConeAndSticksAgainWhereThePullHasFallen) {
  SweptStage stage(make_box(Vec3::Constant(0.1), 3), kSweptClearance, {.friction_static = 0.6, .friction_dynamic = 0.3});
  stage.put(Vec3(0.07, 0.0, 0.0));
  stage.move(Vec3(0.04, 0.0, 0.0));
  stage.move(Vec3(0.04, 0.0059, 0.0));
  EXPECT_LE((stage.position() - Vec3(0.05, 0.0, 0.0)).norm(), 1e-9);
  stage.move(Vec3(0.04, 0.008, 0.0));
  EXPECT_NEAR(stage.position().y(), 0.005, 1e-8) << "0.003 behind";
  stage.move(Vec3(0.04, 0.0098, 0.0));
  EXPECT_NEAR(stage.position().y(), 0.0068, 1e-8) << "it slides on";
  stage.move(Vec3(0.04, 0.007, 0.0));
  EXPECT_FALSE(stage.proxy.slides);
  stage.move(Vec3(0.04, 0.0127, 0.0));
  EXPECT_NEAR(stage.position().y(), 0.0068, 1e-8) << "held up to 0.006";
}

// The box around the larger part of this path holds a third of the 20,000 triangles of the face.
TEST(SweptMotion, ALongSlantedPathTestsFewOfTheTrianglesInItsBox) {
  SweptStage stage(make_box(Vec3(1.0, 1.0, 0.1), 100));
  stage.put(Vec3(-0.45, -0.45, 0.15));
  const Vec3 device = stage.geometry.to_local(Vec3(0.45, 0.45, 0.0));
  bool has_settled = false;
  for (int i = 0; i < 200 && !has_settled; ++i) {
    const std::uint64_t before = stage.swept.counters().tests;
    has_settled = stage.swept.descend(stage.proxy, device);
    ASSERT_LE(stage.swept.counters().tests - before, 1'000U) << "call " << i;
    ASSERT_GE(stage.position().z(), 0.05) << "call " << i;
  }
  EXPECT_TRUE(has_settled);
  EXPECT_LE(stage.position().z() - 0.05, 4.0 * kSweptOffset);
  EXPECT_LE((stage.position() - Vec3(0.45, 0.45, 0.05)).norm(), 0x1p-24);  // error of a normal at the contact offset, times the path
}

// Five fine sheets, each close under the one before. A piece of a path holds thousands of triangles, and those that are tested first may
// belong to any of the sheets.
TEST(SweptMotion, TheFirstOfManySheetsHoldsIt) {
  TriangleMesh sheets;
  for (int n = 0; n < 5; ++n) sheets = joined(sheets, scaled_and_moved(make_plane_grid(1.0, 60), 1.0, Vec3(0.0, 0.0, -0.002 * n)));
  SweptStage stage(sheets);
  const std::uint64_t seed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-0.45, 0.45);
  for (int i = 0; i < 60; ++i) {
    stage.put(Vec3(unit(random), unit(random), 0.02));
    const Vec3 to(unit(random), unit(random), -0.05);
    for (int n = 0; n < 20; ++n) {
      stage.move(to);
      ASSERT_GE(stage.position().z(), 0.0) << "path " << i;
      for (int a = 0; a < stage.proxy.contact_count; ++a) {
        for (int b = 0; b < a; ++b) ASSERT_NE(stage.proxy.contacts[a].triangle, stage.proxy.contacts[b].triangle) << "path " << i;
      }
    }
    ASSERT_LE((stage.position() - Vec3(to.x(), to.y(), 0.0)).norm(), 1e-6) << "path " << i;
  }
}

// A sphere that reached a cluster of small triangles from the side once crept on by a thousandth of its way in each step.
TEST(SweptMotion, ReachingManyTrianglesItArrivesInAFewCalls) {
  constexpr double kBallRadius = 0.03;
  TriangleMesh mesh = make_icosphere(1e-5, 2);
  for (Vec3& vertex : mesh.vertices) vertex += Vec3(0.02, 0.0, 0.0);
  mesh = joined(mesh, make_box(Vec3(1.0, 1.0, 0.02), 1));
  for (std::size_t i = mesh.vertices.size() - 8; i < mesh.vertices.size(); ++i) mesh.vertices[i].z() -= 0.01;
  const double unit_m = SweptStage(mesh).geometry.unit_m();
  SweptStage stage(mesh, {.offset = kBallRadius / unit_m + kSweptOffset, .slop = 0.5 * kSweptOffset, .tolerance = 0x1p-10 * kSweptOffset});
  stage.put(Vec3(-0.02, 0.0, 0.0301));
  int calls = 0;
  constexpr int kMaxCalls = 16;
  stage.device = stage.geometry.to_local(Vec3(0.02, 0.0, 0.0));
  while (calls < kMaxCalls && !stage.swept.descend(stage.proxy, stage.device)) ++calls;
  EXPECT_LT(calls, kMaxCalls);
  EXPECT_NEAR(stage.position().x(), 0.02, 1e-3);  // it touches the cluster from the side
  EXPECT_GE(stage.distance_by_brute_force(), stage.clearance.offset - stage.clearance.slop);
}

// A sphere touches the floor and a slanted edge. With both in contact its centre can only move on an ellipse, on which it is pulled to the
// place nearest to the device.
TEST(SweptMotion, ASphereDescendsAlongTheCurveAboutAFloorAndAnEdge) {
  constexpr double kBallRadius = 0.1;
  for (const double rise : {0.7, 0.8, 0.9}) {
    const Vec3 edge(std::sqrt(1.0 - rise * rise), 0, rise);
    const Vec3 crossing(0, 0, kBallRadius);  // of the edge and the plane in which the centre moves
    TriangleMesh mesh = make_plane_grid(2.0, 1);
    for (const Vec3& corner : {Vec3(crossing - 4.0 * kBallRadius * edge), Vec3(crossing + 4.0 * kBallRadius * edge), Vec3(0.9, 0, 0.05)}) {
      mesh.vertices.push_back(corner);
    }
    const auto last = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
    mesh.triangles.push_back({last - 2, last - 1, last});
    const double unit_m = SweptStage(mesh).geometry.unit_m();
    SweptStage stage(mesh,
                     {.offset = kBallRadius / unit_m + kSweptOffset, .slop = 0.5 * kSweptOffset, .tolerance = 0x1p-10 * kSweptOffset});
    const auto centre_at = [&](double angle) {
      return Vec3(-kBallRadius / rise * std::cos(angle), kBallRadius * std::sin(angle), kBallRadius);
    };
    const Vec3 device(-0.08, 0.04, -0.02);
    const auto pull_at = [&](double angle) { return (device - centre_at(angle)).dot(Vec3(std::sin(angle) / rise, std::cos(angle), 0)); };
    double before = 0.1;
    double beyond = 1.5;
    ASSERT_GT(pull_at(before), 0.0);
    ASSERT_LT(pull_at(beyond), 0.0);
    stage.put(centre_at(before) + 1e-6 * Vec3::UnitZ());
    stage.device = stage.geometry.to_local(device);
    bool has_settled = false;
    for (int i = 0; i < 4 && !has_settled; ++i) has_settled = stage.swept.descend(stage.proxy, stage.device);
    EXPECT_TRUE(has_settled) << rise;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (before + beyond);
      (pull_at(middle) > 0.0 ? before : beyond) = middle;
    }
    EXPECT_LT((stage.position() - centre_at(before)).norm(), 1e-6) << rise;
    EXPECT_EQ(stage.proxy.active_count, 2) << rise;
  }
}

class SweptMotionInSoup : public testing::TestWithParam<unsigned> {};

// Random triangles that cross and touch each other: only the sweep keeps the proxy away from them.
TEST_P(SweptMotionInSoup, IsNeverNearerToATriangleThanItsSlackAllows) {
  RecordProperty("seed", std::to_string(GetParam()));
  std::mt19937_64 random(GetParam());
  std::uniform_real_distribution<double> unit(-0.05, 0.05);
  const auto vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  TriangleMesh soup;
  for (std::uint32_t t = 0; t < 240; ++t) {
    const Vec3 at = vector();
    for (int k = 0; k < 3; ++k) soup.vertices.push_back(at + 0.5 * vector());
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  for (const double radius : {0.0, 0.01}) {
    Clearance keep = kSweptClearance;
    keep.offset += radius;
    SweptStage stage(soup, keep);
    stage.put(Vec3(0.3, 0.0, 0.0));
    int contacts = 0;
    for (int i = 0; i < 400; ++i) {
      const Vec3 to = vector();
      const double before = (stage.geometry.to_local(to) - stage.proxy.position).norm();
      const std::uint64_t sweeps = stage.swept.counters().sweeps;
      stage.move(to);
      ASSERT_GE(stage.distance_by_brute_force(), keep.offset - keep.slop) << "step " << i;
      ASSERT_LE((stage.device - stage.proxy.position).norm(), before * (1.0 + 1e-12) + 64.0 * kSweptOffset) << "step " << i;
      ASSERT_LE(stage.swept.counters().sweeps - sweeps, SweptMotion::kMaxMotions);
      contacts += stage.proxy.is_free ? 0 : 1;
    }
    EXPECT_GT(contacts, 100);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, SweptMotionInSoup, testing::Values(1U, 2U, 3U, 4U));

// A sphere that has shrunk to the width of a slit does not shrink further, although each step may use up the slop: a device that moves
// towards a wall by less than the slop in each step does not take the sphere along.
TEST(SweptMotion, AShrunkSphereKeepsItsSizeWhenTheDeviceCreepsIntoAWall) {
  constexpr double kSlop = 1e-4;
  const Clearance keep{.offset = 0.2, .slop = kSlop, .tolerance = 1e-3 * kSlop};
  SweptStage stage(joined(made::box({-1.0, -1.0, -1.0}, {-0.1, 1.0, 1.0}), made::box({0.1, -1.0, -1.0}, {1.0, 1.0, 1.0})), keep);
  stage.put(Vec3::Zero());
  stage.move(Vec3(0.0, 0.01, 0.0));
  ASSERT_TRUE(stage.swept.is_shrunk());
  const double start_distance = stage.distance_by_brute_force();
  for (int i = 1; i <= 100; ++i) {
    stage.move(Vec3(0.4 * i * kSlop * stage.geometry.unit_m(), 0.01, 0.0));
    ASSERT_GE(stage.distance_by_brute_force(), start_distance - kSlop) << i;
    ASSERT_TRUE(stage.swept.is_shrunk()) << i;
  }
  EXPECT_GT(stage.device.x() - stage.proxy.position.x(), 30.0 * kSlop) << "the wall holds it";
}

// The device is 2e-7 from the axis of the edge: the pull along the surface stays that small all the way, for a quarter of a turn.
TEST(SweptMotion, AShrunkSphereRollsAroundAnEdgeThatTheDeviceIsNear) {
  constexpr double kSlop = 1e-4;
  const Clearance keep{.offset = 0.2, .slop = kSlop, .tolerance = 1e-3 * kSlop};
  SweptStage stage(joined(made::box({-1.0, -1.0, -1.0}, {-0.1, 1.0, 0.0}), made::box({0.1, -1.0, -1.0}, {1.0, 1.0, 0.0})), keep);
  stage.put(Vec3(0.0, 0.0, -0.05));
  stage.move(Vec3(0.0, 0.01, -0.05));
  ASSERT_TRUE(stage.swept.is_shrunk());
  stage.device = stage.geometry.to_local(Vec3(0.1, 0.01, 2e-7));
  const std::uint64_t motions = stage.swept.counters().motions;
  bool has_settled = false;
  for (int i = 0; i < 4 && !has_settled; ++i) has_settled = stage.swept.descend(stage.proxy, stage.device);
  EXPECT_TRUE(has_settled);
  EXPECT_LE(stage.swept.counters().motions - motions, 64U);
  EXPECT_LE((stage.position() - Vec3(0.1, 0.01, 0.1)).norm(), 1e-2);
}

}  // namespace
}  // namespace hapton
