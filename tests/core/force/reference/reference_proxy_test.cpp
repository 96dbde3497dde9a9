#include "core/force/reference/reference_proxy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/force/proxy/surface_follower.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

// Adds two triangles in the plane z = 0.
void add_floor(ReferenceProxy& proxy) {
  proxy.add_face({PreparedTriangle(Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(1, 1, 0)), 0, 0});
  proxy.add_face({PreparedTriangle(Vec3(-1, -1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 0)), 1, 0});
}

TEST(ReferenceProxy, WithoutFacesTheProxyIsAtTheDevice) {
  ReferenceProxy proxy(0.0, {Material{}}, 4);
  proxy.place_free(Vec3(0.1, 0.2, 0.3));
  proxy.follow(Vec3(0.1, 0.2, 0.3), Vec3(0.3, 0.2, -0.1), {});
  EXPECT_EQ(proxy.state().position, Vec3(0.3, 0.2, -0.1));
  EXPECT_TRUE(proxy.state().free);
  EXPECT_EQ(proxy.counters().substeps, 0u);
}

TEST(ReferenceProxy, HeldByAPlaneItIsTheProjectionWithoutItsRadius) {
  ReferenceProxy proxy(0.0, {Material{}}, 4);
  add_floor(proxy);
  proxy.place_free(Vec3(0.1, 0.2, 0.3));
  const Vec3 device(0.3, 0.2, -0.1);
  proxy.follow(Vec3(0.1, 0.2, 0.3), device, {});
  EXPECT_FALSE(proxy.state().free);
  EXPECT_NEAR(proxy.state().position.z(), ReferenceProxy::kPointRadius, 0x1p-37);
  EXPECT_LT((proxy.surface_position(device) - Vec3(0.3, 0.2, 0.0)).norm(), 1e-15);
}

TEST(ReferenceProxy, ASphereKeepsItsRadius) {
  ReferenceProxy proxy(0.05, {Material{}}, 4);
  add_floor(proxy);
  proxy.place_free(Vec3(0.1, 0.2, 0.3));
  const Vec3 device(0.3, 0.2, -0.1);
  proxy.follow(Vec3(0.1, 0.2, 0.3), device, {});
  EXPECT_LT((proxy.surface_position(device) - Vec3(0.3, 0.2, 0.05)).norm(), 1e-11);
}

TEST(ReferenceProxy, ARestoredStateGivesTheSameToTheBit) {
  ReferenceProxy proxy(0.0, {Material{.friction_static = 0.4, .friction_dynamic = 0.3}}, 4);
  add_floor(proxy);
  proxy.place_free(Vec3(0.1, 0.2, 0.3));
  proxy.follow(Vec3(0.1, 0.2, 0.3), Vec3(0.2, 0.2, -0.1), {});
  ReferenceProxy::State start = proxy.make_state();
  proxy.save(start);
  proxy.follow(Vec3(0.2, 0.2, -0.1), Vec3(0.5, 0.1, -0.1), {});
  const Vec3 first = proxy.state().position;
  EXPECT_TRUE(proxy.state().sliding);
  proxy.restore(start);
  EXPECT_NE(proxy.state().position, first);
  proxy.follow(Vec3(0.2, 0.2, -0.1), Vec3(0.5, 0.1, -0.1), {});
  EXPECT_EQ(proxy.state().position, first);
}

TEST(ReferenceProxy, FrictionCanBeLeftOut) {
  ReferenceProxy proxy(0.0, {Material{.friction_static = 0.4, .friction_dynamic = 0.4}}, 4);
  add_floor(proxy);
  const Vec3 device(0.5, 0.1, -0.1);
  proxy.place_held(Vec3(0.2, 0.2, 1e-9), false);
  proxy.follow(device, device, {});
  EXPECT_NEAR((proxy.surface_position(device) - Vec3(0.5, 0.1, 0.0)).norm(), 0.04, 1e-9);
  proxy.follow(device, device, {.friction = false});
  EXPECT_NEAR((proxy.surface_position(device) - Vec3(0.5, 0.1, 0.0)).norm(), 0.0, 1e-14);
}

// A sphere touches the floor and a slanted edge, so its centre moves on an ellipse, along which its pull turns. The device is held, and the
// sphere slips until the pull is on the dynamic cone. With straight motions it would need some hundred.
TEST(ReferenceProxy, AFloorAndAnEdgeLeadASphereUnderFrictionOnAnEllipse) {
  constexpr double kRadius = 0.1;
  constexpr double kMu = 0.1;
  for (const double rise : {0.6, 0.7, 0.8, 0.9}) {
    ReferenceProxy proxy(kRadius, {Material{.friction_static = kMu, .friction_dynamic = kMu}}, 4);
    add_floor(proxy);
    const Vec3 edge(std::sqrt(1.0 - rise * rise), 0, rise);
    const Vec3 crossing(0, 0, kRadius);  // of the edge and the plane in which the centre moves
    proxy.add_face({PreparedTriangle(crossing - 1.5 * kRadius * edge, crossing + 2.0 * kRadius * edge, Vec3(0.4, 0, 0.05)), 2, 0});
    const auto centre_at = [&](double angle) { return Vec3(-kRadius / rise * std::cos(angle), kRadius * std::sin(angle), kRadius); };
    const Vec3 device(-0.02, 0.08, -0.1);
    const auto excess_at = [&](double angle) {
      const Vec3 pull = device - centre_at(angle);
      const double along = pull.dot(Vec3(std::sin(angle) / rise, std::cos(angle), 0).normalized());
      return along - kMu * std::sqrt(pull.squaredNorm() - along * along);
    };
    double moving = 0.0;
    double held = 1.5;
    ASSERT_GT(excess_at(moving), 0.0);
    ASSERT_LT(excess_at(held), 0.0);
    proxy.place_held(centre_at(moving), true);
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (moving + held);
      (excess_at(middle) > 0.0 ? moving : held) = middle;
    }
    proxy.follow(device, device, {});
    EXPECT_LT((proxy.state().position - centre_at(held)).norm(), 1e-10) << rise;
    EXPECT_LT(proxy.counters().motions, 90U) << rise;
    EXPECT_TRUE(proxy.state().sliding) << rise;
  }
}

// The sphere slips from a corner of a box, of which the octant x, y, z < 0 is the part nearby: from p, whose part outside the octant is
// p.cwiseMax(0), in the direction of steepest descent. Returns where it enters a face. kPiece: by the midpoint rule, an error below 1e-9.
Vec3 follow_to_face(Vec3 p, const Vec3& device, double radius) {
  constexpr double kPiece = 5e-6;
  const auto direction_at = [&](const Vec3& at) -> Vec3 {
    const Vec3 normal = at.cwiseMax(0.0).normalized();
    const Vec3 pull = device - at;
    return (pull - pull.dot(normal) * normal).normalized();
  };
  while ((p.array() > 0.0).count() > 1) {
    p += kPiece * direction_at(p + 0.5 * kPiece * direction_at(p));
    const Vec3 outside = p.cwiseMax(0.0);
    p += (radius / outside.norm() - 1.0) * outside;
  }
  return p;
}

// While the device holds still, a sphere under friction slips off the corner of a box: round the corner and an edge along its pull, which
// turns on the way, then straight over a face until its pull is on the dynamic cone.
TEST(ReferenceProxy, UnderFrictionASphereSlipsOffAVertexAlongItsPull) {
  constexpr double kRadius = 0.1;
  const TriangleMesh box = scaled_and_moved(make_box(Vec3::Constant(0.4)), 1.0, Vec3::Constant(-0.2));
  for (const double friction : {0.02, 0.1}) {
    for (const Vec3& start : {Vec3(3, 2, 1), Vec3(2, 5, 3), Vec3(3, 4, 6)}) {
      ReferenceProxy proxy(kRadius, {Material{.friction_static = friction, .friction_dynamic = friction}}, box.triangles.size());
      for (std::uint32_t i = 0; i < box.triangles.size(); ++i)
        proxy.add_face({PreparedTriangle(box.corner(i, 0), box.corner(i, 1), box.corner(i, 2)), i, 0});
      const Vec3 device(-0.06, -0.08, -0.07);
      proxy.place_held(kRadius * start.normalized(), true);
      Vec3 expected = follow_to_face(proxy.state().position, device, kRadius);
      const Vec3 normal = (expected.array() > 0.0).cast<double>();
      const Vec3 along = device - expected - normal.dot(device - expected) * normal;
      expected += along - friction * normal.dot(expected - device) * along.normalized();
      proxy.follow(device, device, {});
      EXPECT_LT((proxy.state().position - expected).norm(), 1e-8) << friction << ", from " << start.transpose();
      EXPECT_LT(proxy.counters().motions, 4000U) << friction << ", from " << start.transpose();
      EXPECT_TRUE(proxy.state().sliding) << friction << ", from " << start.transpose();
    }
  }
}

std::unique_ptr<ReferenceProxy> proxy_over(const TouchGeometry& geometry, const TriangleMesh& mesh) {
  auto proxy = std::make_unique<ReferenceProxy>(0.0, std::vector<Material>{Material{}}, mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const ObjectGeometry::Corners at = geometry.corners(i);
    proxy->add_face({PreparedTriangle(at.a, at.b, at.c), i, 0});
  }
  return proxy;
}

// Two blocks with a gap between them, the second a little lower. The path from the first block to the device leads down into the gap; a
// path straight on over the edge would lead onto the second block.
TEST(ReferenceProxy, WhereTheProxyJumpsItStaysOnTheSurface) {
  const auto block = [](double x, double top) { return scaled_and_moved(make_box(Vec3(0.1, 0.2, 0.1)), 1.0, Vec3(x, top - 0.1, 0.0)); };
  const TriangleMesh blocks = joined(block(-0.05, 0.0), block(0.06, -1e-6));
  ReferenceProxy proxy(0.0, {Material{}}, blocks.triangles.size());
  for (std::uint32_t i = 0; i < blocks.triangles.size(); ++i) {
    proxy.add_face({PreparedTriangle(blocks.corner(i, 0), blocks.corner(i, 1), blocks.corner(i, 2)), i, 0});
  }
  const Vec3 device(0.03, -0.05, 0.01);
  proxy.place_held(Vec3(-0.02, 1e-9, 0.01), false);
  proxy.follow(device, device, {});
  EXPECT_LT((proxy.surface_position(device) - Vec3(0.01, -0.05, 0.01)).norm(), 1e-9);
  proxy.place_held(Vec3(-0.02, 1e-9, 0.01), false);
  proxy.follow(device, device, {.keeps_to_surface = false});
  EXPECT_LT((proxy.surface_position(device) - Vec3(0.03, -1e-6, 0.01)).norm(), 1e-9);
}

// The surface follower moves by adjacency, from face to face. From any place on bumps, with the device below and aside, both
// implementations descend in the steepest direction to the same local minimum.
TEST(ReferenceProxy, DescendsAsTheSurfaceFollowerDoes) {
  constexpr std::uint64_t kSeed = 3;
  const TriangleMesh mesh = make_bumpy_sphere(0.5, 0.4, 1500, kSeed);
  const TouchGeometry geometry({&mesh});
  const std::vector<Material> materials(1);
  const auto follower = std::make_unique<SurfaceFollower>(geometry, materials);
  const auto proxy = proxy_over(geometry, mesh);
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  int compared_descents = 0;
  double farthest = 0.0;
  for (int i = 0; i < 1500; ++i) {
    const auto triangle = static_cast<std::uint32_t>(random() % mesh.triangles.size());
    const ObjectGeometry::Corners at = geometry.corners(triangle);
    const Vec3 start = 0.5 * at.a + 0.3 * at.b + 0.2 * at.c;
    const Vec3 up = (at.b - at.a).cross(at.c - at.a).normalized();
    const Vec3 aside = 0.03 * Vec3(normal(random), normal(random), normal(random));
    const Vec3 device = start - 0.02 * up + aside - aside.dot(up) * up;
    if (!follower->land(triangle, false, start) || follower->descend(device) != SurfaceFollower::Outcome::settled) continue;
    proxy->place_held(start + 0x1p-30 * up, false);
    proxy->follow(device, device, {});
    EXPECT_LT((proxy->surface_position(device) - follower->point()).norm(), 1e-9) << "seed " << kSeed << " descent " << i;
    farthest = std::max(farthest, (follower->point() - start).norm());
    ++compared_descents;
  }
  EXPECT_GT(compared_descents, 900);
  EXPECT_GT(farthest, 0.05);
  EXPECT_EQ(proxy->counters().unconverged, 0U);
}

// Adds a floor and three walls on it beside p: two nearer than 2^-20, up to where a proxy that creeps lists faces, and one farther.
constexpr std::uint32_t kFirstWall = 2;
void add_floor_with_walls(ReferenceProxy& proxy, const Vec3& p) {
  add_floor(proxy);
  const auto add_wall = [&](const Vec3& middle, const Vec3& along) {
    const PreparedTriangle shape(middle - 0.01 * along, middle + 0.01 * along, middle + Vec3(0, 0, 0.01));
    proxy.add_face({shape, static_cast<std::uint32_t>(proxy.faces()), 0});
  };
  add_wall(p + Vec3(0, 0x1p-21, -0.001), Vec3::UnitX());
  add_wall(p - Vec3(0x1.8p-21, 0, 0.001), Vec3::UnitY());
  add_wall(p - Vec3(0, 0x1.8p-20, 0.001), Vec3::UnitX());
}

TEST(ReferenceProxy, OneThatCreptStopsAtTheSameFacesAsAFreshOne) {
  constexpr unsigned kSeed = 20261201;
  SCOPED_TRACE(kSeed);
  const Vec3 start(0.1, 0.2, ReferenceProxy::kPointRadius);
  const auto device_at = [&](const Vec3& moved) -> Vec3 { return start + moved - Vec3(0, 0, 0.001); };
  ReferenceProxy crept(0.0, {Material{}}, 16);
  add_floor_with_walls(crept, start);
  crept.place_held(start, false);
  Vec3 device = start;
  for (int i = 0; i < 10; ++i) {
    const Vec3 from = std::exchange(device, device_at(Vec3(i * 0x1p-40, 0, 0)));
    crept.follow(from, device, {});
  }
  ReferenceProxy::State at_rest = crept.make_state();
  crept.save(at_rest);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> angle(0.0, 6.28);
  std::uniform_real_distribution<double> exponent(-24.0, -17.0);
  std::array<int, 3> stops{};
  for (int i = 0; i < 300; ++i) {
    const double direction = angle(random);
    const Vec3 to = device_at(std::exp2(exponent(random)) * Vec3(std::cos(direction), std::sin(direction), 0));
    ReferenceProxy fresh(0.0, {Material{}}, 16);
    add_floor_with_walls(fresh, start);
    fresh.restore(at_rest);
    crept.restore(at_rest);
    fresh.follow(device, to, {});
    crept.follow(device, to, {});
    EXPECT_EQ(crept.state().position, fresh.state().position) << i;
    for (const auto& contact : fresh.state().contacts) {
      if (contact.face.triangle >= kFirstWall) ++stops.at(contact.face.triangle - kFirstWall);
    }
  }
  for (const int count : stops) EXPECT_GT(count, 20);
}

}  // namespace
}  // namespace hapton
