#include "core/force/reference/reference_proxy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
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

}  // namespace
}  // namespace hapton
