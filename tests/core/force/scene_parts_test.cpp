#include "core/force/scene_parts.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "core/force/proxy/proxy_method.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TouchObject part_box(const Vec3& centre, double stiffness_n_per_m) {
  return {.mesh = std::make_shared<const TriangleMesh>(scaled_and_moved(make_box(Vec3(0.02, 0.02, 0.02)), 1.0, centre)),
          .material = {.stiffness_n_per_m = stiffness_n_per_m, .damping_ns_per_m = stiffness_n_per_m * 1e-3}};
}

// Two boxes that stand still, one that programs may move, and a body that can be carved.
TouchScene scene_of_four_boxes() {
  TouchScene scene{.objects = {part_box(Vec3(0, 0, 0), 500.0), part_box(Vec3(0.1, 0, 0), 600.0), part_box(Vec3(0, 0.1, 0), 700.0),
                               part_box(Vec3(0, 0, 0.1), 800.0)}};
  scene.objects[0].command_pivot = Vec3(0, 0, 0);
  scene.objects[1].sculpt = SculptSettings{.voxel_m = 0.002, .tool_radius_m = 0.006, .button = 1};
  return scene;
}

SceneParts parts_of(const TouchScene& scene) {
  auto made = SceneParts::make(&ProxyMethod::make, {}, scene);
  EXPECT_TRUE(made) << made.error().what;
  return std::move(*made);
}

TEST(SceneParts, StaticObjectsAreTheFirstPartAndCarvedBodiesAreNone) {
  SceneParts parts = parts_of(scene_of_four_boxes());
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_TRUE(parts.has_still());
  EXPECT_EQ(parts.objects(0), (std::vector<int>{2, 3}));
  EXPECT_EQ(parts.objects(1), (std::vector<int>{0}));
  EXPECT_EQ(parts.stiffness(0).least, 700.0);
  EXPECT_EQ(parts.stiffness(0).most, 800.0);
  EXPECT_EQ(parts.damping(0, 3), 0.8);
  EXPECT_NEAR(parts.extent_m(), std::sqrt(3.0) * 0.12, 1e-12) << "of all objects";
}

TEST(SceneParts, AreFeltWhereTheyAreAndNameTheObject) {
  SceneParts parts = parts_of(scene_of_four_boxes());
  const std::vector<Pose> moved = {Pose(Eigen::Translation3d(0.0, 0.0, 0.05))};
  const MethodInput input{.dt_s = 0.0, .commanded = moved};
  parts.begin(input);
  const Pose X_SO = parts.pose(1);
  EXPECT_EQ(X_SO.translation(), Vec3(0, 0, 0.05));
  const auto feel = [&](std::size_t part, double z, double y) {
    const Pose X = parts.pose(part);
    parts.reset(part, X, {0, y, z + 0.01});
    return parts.feel(part, X, {0, y, z}, {});
  };
  const MethodOutput free = feel(1, 0.0605, 0.0);
  EXPECT_FALSE(free.contact);
  EXPECT_EQ(free.p_SP, Vec3(0, 0, 0.0605));
  const MethodOutput on_moved = feel(1, 0.0595, 0.0);
  EXPECT_EQ(on_moved.object, 0);
  EXPECT_NEAR(on_moved.force_n.z(), 500.0 * 5e-4, 1e-6);
  EXPECT_NEAR(on_moved.p_SP.z(), 0.06, 1e-9);
  EXPECT_EQ(feel(0, 0.0095, 0.1).object, 2);
}

TEST(SceneParts, AreFrictionlessWithoutDynamicFriction) {
  TouchScene scene = scene_of_four_boxes();
  scene.objects[0].material.friction_static = 0.5;
  SceneParts parts = parts_of(scene);
  EXPECT_TRUE(parts.is_frictionless(0));
  EXPECT_TRUE(parts.is_frictionless(1)) << "static friction is dynamic friction where the proxy is shared";
  std::vector<Material> materials(4);
  materials[3].friction_dynamic = 0.2;
  parts.set_materials(materials);
  EXPECT_FALSE(parts.is_frictionless(0));
  EXPECT_TRUE(parts.is_frictionless(1));
}

TEST(SceneParts, WithoutMotionAreOneMethod) {
  TouchScene scene{.objects = {part_box(Vec3(0, 0, 0), 500.0), part_box(Vec3(0.1, 0, 0), 600.0)}};
  SceneParts parts = parts_of(scene);
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts.describe(), parts.method(0).describe());
  scene.objects[0].sculpt = scene.objects[1].sculpt = SculptSettings{.voxel_m = 0.002, .tool_radius_m = 0.006, .button = 1};
  EXPECT_EQ(parts_of(scene).size(), 0U) << "all can be carved";
}

}  // namespace
}  // namespace hapton
