#include "core/force/reference_proxy.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

// Two triangles of the plane z = 0.
void add_floor(ReferenceProxy& proxy) {
  proxy.add_face({PreparedTriangle(Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(1, 1, 0)), 0, 0});
  proxy.add_face({PreparedTriangle(Vec3(-1, -1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 0)), 1, 0});
}

TEST(ReferenceProxy, AloneItIsTheDevice) {
  ReferenceProxy proxy(0.0, {Material{}}, 4);
  proxy.place_free(Vec3(0.1, 0.2, 0.3));
  proxy.follow(Vec3(0.1, 0.2, 0.3), Vec3(0.3, 0.2, -0.1), {});
  EXPECT_EQ(proxy.state().place, Vec3(0.3, 0.2, -0.1));
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
  EXPECT_NEAR(proxy.state().place.z(), ReferenceProxy::kPointRadius, 0x1p-37);
  EXPECT_LT((proxy.surface_place(device) - Vec3(0.3, 0.2, 0.0)).norm(), 1e-15);
}

TEST(ReferenceProxy, ASphereKeepsItsRadius) {
  ReferenceProxy proxy(0.05, {Material{}}, 4);
  add_floor(proxy);
  proxy.place_free(Vec3(0.1, 0.2, 0.3));
  const Vec3 device(0.3, 0.2, -0.1);
  proxy.follow(Vec3(0.1, 0.2, 0.3), device, {});
  EXPECT_LT((proxy.surface_place(device) - Vec3(0.3, 0.2, 0.05)).norm(), 1e-11);
}

TEST(ReferenceProxy, ARestoredStateGivesTheSameToTheBit) {
  ReferenceProxy proxy(0.0, {Material{.friction_static = 0.4, .friction_dynamic = 0.3}}, 4);
  add_floor(proxy);
  proxy.place_free(Vec3(0.1, 0.2, 0.3));
  proxy.follow(Vec3(0.1, 0.2, 0.3), Vec3(0.2, 0.2, -0.1), {});
  ReferenceProxy::State start = proxy.make_state();
  proxy.save(start);
  proxy.follow(Vec3(0.2, 0.2, -0.1), Vec3(0.5, 0.1, -0.1), {});
  const Vec3 first = proxy.state().place;
  EXPECT_TRUE(proxy.state().sliding);
  proxy.restore(start);
  EXPECT_NE(proxy.state().place, first);
  proxy.follow(Vec3(0.2, 0.2, -0.1), Vec3(0.5, 0.1, -0.1), {});
  EXPECT_EQ(proxy.state().place, first);
}

TEST(ReferenceProxy, FrictionCanBeLeftOut) {
  ReferenceProxy proxy(0.0, {Material{.friction_static = 0.4, .friction_dynamic = 0.4}}, 4);
  add_floor(proxy);
  const Vec3 device(0.5, 0.1, -0.1);
  proxy.place_held(Vec3(0.2, 0.2, 1e-9), false);
  proxy.follow(device, device, {});
  EXPECT_NEAR((proxy.surface_place(device) - Vec3(0.5, 0.1, 0.0)).norm(), 0.04, 1e-9);
  proxy.follow(device, device, {.friction = false});
  EXPECT_NEAR((proxy.surface_place(device) - Vec3(0.5, 0.1, 0.0)).norm(), 0.0, 1e-14);
}

}  // namespace
}  // namespace hapton
