#include "core/force/mapped_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/force/force_method.h"
#include "core/force/touch_step.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/core/force/made_maps.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr unsigned kMappedSeed = 77;

// Brute-force twin: a search over every triangle.
TEST(MappedSurface, FindsThePlaceOfTheNearestPointWhereverTheSearchBegins) {
  SCOPED_TRACE(testing::Message() << "seed " << kMappedSeed);
  const TriangleMesh torus = make_torus(0.035, 0.015, 30, 12);
  const SurfaceMaps maps = made_maps(torus);
  const MappedSurface surface(maps.triangles);
  EXPECT_EQ(surface.triangles(), maps.triangles);
  std::mt19937_64 random(kMappedSeed);
  std::uniform_real_distribution<double> uniform(-0.06, 0.06);
  for (int n = 0; n < 500; ++n) {
    const Vec3 p(uniform(random), uniform(random), 0.5 * uniform(random));
    double nearest_m = std::numeric_limits<double>::infinity();
    Eigen::Vector2d expected = Eigen::Vector2d::Zero();
    for (const MappedTriangle& triangle : *maps.triangles) {
      const ClosestPoint found = closest_point(triangle.corner[0], triangle.corner[1], triangle.corner[2], p);
      if (!(found.distance < nearest_m)) continue;
      nearest_m = found.distance;
      const MapPlace place = map_gradients(triangle);
      const Vec3 off = found.point - triangle.corner[0];
      expected = place.texcoord + Eigen::Vector2d(place.du.dot(off), place.dv.dot(off));
    }
    std::size_t last = random() % torus.triangles.size();
    EXPECT_LT((surface.find(p, last).texcoord - expected).norm(), 1e-9) << n;
  }
}

TEST(MappedSurface, AStepSharesTheMappedSurfaceOfItsTrianglesAndNoOther) {
  const TriangleMesh torus = make_torus(0.035, 0.015, 30, 12);
  const SurfaceMaps maps = made_maps(torus);
  TouchScene scene;
  scene.objects.push_back({.mesh = std::make_shared<const TriangleMesh>(torus), .material = {}});
  scene.objects.front().effects.maps = maps;
  const auto surface = std::make_shared<const MappedSurface>(maps.triangles);
  const auto of_another_mesh = std::make_shared<const MappedSurface>(made_maps(make_torus(0.03, 0.01, 30, 12)).triangles);
  TouchScene shared = scene;
  shared.mapped = {surface};
  TouchScene stale = scene;
  stale.mapped = {of_another_mesh};
  TouchScene none = scene;
  none.mapped = {nullptr};
  std::vector<TouchStep> steps;
  for (const TouchScene* each : {&scene, &shared, &stale, &none})
    steps.emplace_back(std::shared_ptr<ForceMethod>(make_method({}, *each).value().release()), *each);
  EXPECT_EQ(surface.use_count(), 3) << "here, in the scene and in the step";
  EXPECT_EQ(of_another_mesh.use_count(), 2) << "here and in the scene";
  int contacts = 0;
  for (int n = 0; n < 400; ++n) {
    const double angle = 0.02 * n;
    const TouchInput input{.p_WD = Vec3(0.035 * std::cos(angle), 0.035 * std::sin(angle), 0.0148 + 0.001 * std::cos(0.5 * angle))};
    const TouchOutput expected = steps.front().step(input);
    contacts += expected.contact ? 1 : 0;
    for (std::size_t other = 1; other < steps.size(); ++other) ASSERT_EQ(steps[other].step(input).force_n, expected.force_n) << n;
  }
  EXPECT_GT(contacts, 100);
}

// A fast push into a damped surface makes the force ten times that of the spring, but does not make the spring of friction stiffer.
TEST(MappedSurface, FrictionOfAnImageIsNoStifferThanTheMaterial) {
  const TriangleMesh sheet = made::sheet(0.1, 0.0, 4);
  TouchScene scene;
  const Material material{.stiffness_n_per_m = 500.0, .damping_ns_per_m = 5.0};
  scene.objects.push_back({.mesh = made::shared(sheet), .material = material});
  SurfaceMaps maps = made_maps(sheet);
  maps.friction = {.image = maps.height.image, .at_black = 2.0, .at_white = 2.0};
  maps.height = {};
  scene.objects.front().effects.maps = maps;
  TouchStep touch(std::shared_ptr<ForceMethod>(make_method({}, scene).value().release()), scene);
  for (const bool is_tuned : {false, true}) {
    if (is_tuned) touch.set_materials(std::vector<Material>{{.stiffness_n_per_m = 250.0, .damping_ns_per_m = 5.0}});
    touch.reset({.p_WD = {0.003, 0.004, 0.001}});
    touch.step({.p_WD = {0.003, 0.004, -0.0001}});
    const TouchOutput felt = touch.step({.p_WD = {0.00301, 0.004, -0.0002}});  // 10 um aside
    EXPECT_GT(felt.force_n.z(), 0.5);
    EXPECT_NEAR(felt.force_n.x(), -1e-5 * (is_tuned ? 250.0 : 500.0), 1e-9);
  }
}

TEST(MappedSurface, MayHaveNoTriangles) {
  const MappedSurface surface(std::make_shared<const std::vector<MappedTriangle>>());
  EXPECT_TRUE(surface.is_empty());
}

}  // namespace
}  // namespace hapton
