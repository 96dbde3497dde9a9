#include "core/force/contact_material.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "core/force/force_method.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

const Material kHard{.stiffness_n_per_m = 1800.0, .damping_ns_per_m = 1.0, .friction_static = 0.6, .friction_dynamic = 0.4};
const Material kSoft{.stiffness_n_per_m = 300.0, .damping_ns_per_m = 3.0, .friction_static = 0.2, .friction_dynamic = 0.1};

TEST(ContactMaterial, IsTheMeanWeightedByMultipliers) {
  ContactMaterial mix;
  mix.add(kHard, 3.0);
  mix.add(kSoft, 1.0);
  EXPECT_DOUBLE_EQ(mix.mean().stiffness_n_per_m, 1425.0);
  EXPECT_DOUBLE_EQ(mix.mean().damping_ns_per_m, 1.5);
  EXPECT_DOUBLE_EQ(mix.mean().friction_static, 0.5);
  EXPECT_DOUBLE_EQ(mix.mean().friction_dynamic, 0.325);
}

TEST(ContactMaterial, DoesNotDependOnTheOrderNorOnTheUnit) {
  ContactMaterial one, other;
  one.add(kHard, 0.3);
  one.add(kSoft, 0.5);
  one.add(kHard, 0.1);
  other.add(kSoft, 500.0);
  other.add(kHard, 100.0);
  other.add(kHard, 300.0);
  EXPECT_NEAR(one.mean().stiffness_n_per_m, other.mean().stiffness_n_per_m, 1e-10);
  EXPECT_NEAR(one.mean().friction_static, other.mean().friction_static, 1e-14);
}

TEST(ContactMaterial, OneMaterialStaysExactlyItself) {
  ContactMaterial mix;
  for (const double multiplier : {0.1, 0.7, 1e-12}) mix.add(kSoft, multiplier);
  EXPECT_EQ(mix.mean().stiffness_n_per_m, kSoft.stiffness_n_per_m);
  EXPECT_EQ(mix.mean().friction_dynamic, kSoft.friction_dynamic);
}

TEST(ContactMaterial, AConstraintWithoutMultiplierHasNoWeight) {
  ContactMaterial mix;
  mix.add(kHard, 0.0);
  EXPECT_EQ(mix.mean().stiffness_n_per_m, kHard.stiffness_n_per_m) << "there is no other";
  mix.add(kSoft, 1e-9);
  mix.add(kHard, 0.0);
  EXPECT_EQ(mix.mean().stiffness_n_per_m, kSoft.stiffness_n_per_m);
}

// A soft wall on a hard floor: they form a concave edge along z, at x = 0, y = 0; the probe is in x > 0, y > 0.
TouchScene corner_scene(double friction_factor) {
  const auto block = [](const Vec3& middle) {
    return std::make_shared<TriangleMesh>(scaled_and_moved(make_box({0.1, 0.1, 0.1}, 5), 1.0, middle));
  };
  TouchScene scene;
  scene.objects.push_back({block({0.003, -0.05, 0.001}), kHard});
  scene.objects.push_back({block({-0.05, 0.03, 0.0}), kSoft});
  for (TouchObject& object : scene.objects) {
    object.material.damping_ns_per_m = 0.0;
    object.material.friction_static *= friction_factor;
    object.material.friction_dynamic *= friction_factor;
  }
  return scene;
}

class TwoMaterials : public testing::TestWithParam<const char*> {
 protected:
  static std::unique_ptr<ForceMethod> make(const std::string& name, const TouchScene& scene) {
    MethodSettings settings;
    settings.name = name;
    return std::move(*make_method(settings, scene));
  }
};

// The device goes down beside the wall, into it, and out of it again while it stays below the floor.
Vec3 device_at(int step, int steps) {
  const double t = static_cast<double>(step) / steps;
  const double down = std::min(1.0, 4.0 * t);
  const double position = t < 0.25 ? 0.0 : (t < 0.6 ? (t - 0.25) / 0.35 : (1.0 - t) / 0.4);
  return {0.002 - 0.004 * position, 0.002 - 0.004 * down, 0.0003};
}

// At the edge the components of the penetration vector along both normals are the multipliers, because the faces are at right angles.
TEST_P(TwoMaterials, MeetInOneConcaveEdgeByTheRuleWithoutAForceDiscontinuity) {
  const auto method = make(GetParam(), corner_scene(0.0));
  constexpr int kSteps = 1200;
  method->reset(device_at(0, kSteps));
  Vec3 last_force = Vec3::Zero();
  Vec3 last_device = device_at(0, kSteps);
  int steps_in_edge = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const Vec3 device = device_at(i, kSteps);
    const Vec3 force = method->step({device, 1e-3}).force_n;
    const double into_floor = std::max(0.0, -device.y());
    const double into_wall = into_floor > 0.0 ? std::max(0.0, -device.x()) : 0.0;
    if (into_floor > 0.0) {
      const double stiffness = (into_floor * kHard.stiffness_n_per_m + into_wall * kSoft.stiffness_n_per_m) / (into_floor + into_wall);
      EXPECT_LE((force - stiffness * Vec3(into_wall, into_floor, 0.0)).norm(), 1e-6)
          << "step " << i << ": floor " << into_floor << ", wall " << into_wall;
      steps_in_edge += into_wall > 0.0 ? 1 : 0;
    }
    EXPECT_LE((force - last_force).norm(), 2.0 * kHard.stiffness_n_per_m * (device - last_device).norm() + 1e-6) << "step " << i;
    last_force = force;
    last_device = device;
  }
  EXPECT_GT(steps_in_edge, 400);
}

INSTANTIATE_TEST_SUITE_P(Methods, TwoMaterials, testing::Values("proxy", "reference"));

TEST(TwoMaterialsWithFriction, ProxyAndReferenceAgree) {
  const TouchScene scene = corner_scene(1.0);
  MethodSettings settings;
  settings.name = "proxy";
  const auto proxy = std::move(*make_method(settings, scene));
  settings.name = "reference";
  const auto reference = std::move(*make_method(settings, scene));
  constexpr int kSteps = 1200;
  proxy->reset(device_at(0, kSteps));
  reference->reset(device_at(0, kSteps));
  for (int i = 1; i <= kSteps; ++i) {
    const Vec3 device = device_at(i, kSteps) + Vec3(0, 0, 2e-6 * i);
    const Vec3 one = proxy->step({device, 1e-3}).force_n;
    const Vec3 other = reference->step({device, 1e-3}).force_n;
    EXPECT_LE((one - other).norm(), 0.02 * other.norm() + 1e-3) << "step " << i;
  }
}

}  // namespace
}  // namespace hapton
