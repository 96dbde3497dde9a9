// The object that each method names as touched.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "core/force/force_method.h"
#include "core/geometry/closest_point.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

// Every method, with the settings that change how it follows a surface.
std::vector<MethodSettings> all_settings() {
  return {{.name = "proxy"},
          {.name = "proxy", .shading = 1.0},
          {.name = "proxy", .probe_radius_m = 0.0005},
          {.name = "sweep"},
          {.name = "smooth"},
          {.name = "reference"},
          {.name = "reference", .probe_radius_m = 0.0005}};
}

std::string name_of(const MethodSettings& settings) {
  return settings.name + (settings.shading > 0 ? " with shading" : "") + (settings.probe_radius_m > 0 ? " of a sphere" : "");
}

// Three boxes side by side, 1 mm apart, their tops at z = 0; their order in the list is not their order along x.
TouchScene three_boxes(double friction) {
  TouchScene scene;
  for (const double x : {0.02, -0.02, 0.0}) {
    scene.objects.push_back({made::shared(made::box({x - 0.0095, -0.01, -0.02}, {x + 0.0095, 0.01, 0.0})),
                             {.friction_static = friction, .friction_dynamic = friction}});
  }
  return scene;
}

TEST(TouchedObject, IsTheOneUnderTheProbe) {
  for (const MethodSettings& settings : all_settings()) {
    for (const double friction : {0.0, 0.5}) {
      const TouchScene scene = three_boxes(friction);
      auto made = make_method(settings, scene);
      ASSERT_TRUE(made) << made.error().what;
      ForceMethod& method = **made;
      for (const auto& [x, object] : {std::pair(-0.021, 1), std::pair(0.001, 2), std::pair(0.022, 0)}) {
        method.reset({x, 0.001, 0.002});
        const MethodOutput free = method.step({.p_SD = {x, 0.001, 0.001}});
        EXPECT_EQ(free.object, -1) << name_of(settings);
        const MethodOutput pressed = method.step({.p_SD = {x, 0.001, -0.001}});
        ASSERT_TRUE(pressed.contact) << name_of(settings);
        EXPECT_EQ(pressed.object, object) << name_of(settings) << ", friction " << friction;
        // A motion along the same top, then one off it.
        EXPECT_EQ(method.step({.p_SD = {x + 0.002, 0.003, -0.001}}).object, object) << name_of(settings);
        EXPECT_EQ(method.step({.p_SD = {x + 0.002, 0.003, 0.003}}).object, -1) << name_of(settings);
      }
    }
  }
}

TEST(TouchedObject, IsNoneForASampleThatIsNotFinite) {
  for (const MethodSettings& settings : all_settings()) {
    auto made = make_method(settings, three_boxes(0.0));
    ASSERT_TRUE(made);
    (*made)->reset({0.001, 0.001, 0.002});
    ASSERT_EQ((*made)->step({.p_SD = {0.001, 0.001, -0.001}}).object, 2);
    EXPECT_EQ((*made)->step({.p_SD = Vec3::Constant(std::numeric_limits<double>::quiet_NaN())}).object, -1) << name_of(settings);
  }
}

// A floor and a wall: in the corner, the touched object is the one that pushes more. Only for methods whose proxy both can hold.
TEST(TouchedObject, InACornerIsTheOneThatPushesMore) {
  TouchScene scene;
  scene.objects.push_back({made::shared(made::box({-0.05, -0.05, -0.02}, {0.05, 0.05, 0.0})), {}});
  scene.objects.push_back({made::shared(made::box({0.02, -0.04, -0.01}, {0.04, 0.04, 0.03})), {}});
  for (const MethodSettings& settings : all_settings()) {
    if (settings.name != "proxy" && settings.name != "reference") continue;
    auto made = make_method(settings, scene);
    ASSERT_TRUE(made) << made.error().what;
    for (const auto& [into_floor, into_wall, object] : {std::tuple(0.002, 0.001, 0), std::tuple(0.001, 0.002, 1)}) {
      (*made)->reset({0.015, 0.001, 0.002});
      (*made)->step({.p_SD = {0.019, 0.001, 0.002}});
      MethodOutput corner;
      for (int k = 0; k < 3; ++k) corner = (*made)->step({.p_SD = {0.02 + into_wall, 0.001, -into_floor}});
      ASSERT_TRUE(corner.contact) << name_of(settings);
      EXPECT_EQ(corner.object, object) << name_of(settings);
    }
  }
}

// A random walk over the three boxes, in and out: the touched object is always the one nearest to the proxy.
TEST(TouchedObject, IsNearestToTheProxyOnAWalk) {
  constexpr std::uint64_t kSeed = 4;
  const TouchScene scene = three_boxes(0.0);
  const auto distance_to = [&](int object, const Vec3& p) {
    double least = 1e9;
    const TriangleMesh& mesh = *scene.objects[object].mesh;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      least = std::min(least, closest_point(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), p).distance);
    }
    return least;
  };
  for (const MethodSettings& settings : all_settings()) {
    if (settings.name == "reference") continue;  // slow, and covered above
    auto made = make_method(settings, scene);
    ASSERT_TRUE(made);
    std::mt19937_64 random(kSeed);
    std::normal_distribution<double> normal(0.0, 3e-4);
    Vec3 p(0, 0, 0.002);
    (*made)->reset(p);
    int contact_steps = 0;
    for (int k = 0; k < 3000; ++k) {
      p = (p + Vec3(2 * normal(random), normal(random), normal(random)))
              .cwiseMax(Vec3(-0.028, -0.009, -0.002))
              .cwiseMin(Vec3(0.028, 0.009, 0.003));
      const MethodOutput output = (*made)->step({.p_SD = p});
      ASSERT_EQ(output.object >= 0, output.contact) << name_of(settings) << ", step " << k << ", seed " << kSeed;
      if (!output.contact) continue;
      ++contact_steps;
      double least = 1e9;
      for (int object = 0; object < 3; ++object) least = std::min(least, distance_to(object, output.p_SP));
      ASSERT_LE(distance_to(output.object, output.p_SP), least + 1e-6) << name_of(settings) << ", step " << k << ", seed " << kSeed;
    }
    EXPECT_GT(contact_steps, 500) << name_of(settings);
  }
}

}  // namespace
}  // namespace hapton
