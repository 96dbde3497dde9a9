#include "haptic_step/scene_facts.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TEST(SceneFacts, SayWhereTheSceneIsAndWhichOneItIs) {
  Scene scene;
  scene.given_hash = 77;
  scene.objects.push_back({.name = "ball", .mesh = made::shared(make_icosphere(0.1, 3)), .material = {}});
  const SceneFacts facts = make_scene_facts(scene);
  EXPECT_EQ(facts.given_hash, 77U);
  EXPECT_EQ(facts.tool_hash, SceneFacts::kNoTool);
  scene.tool = SceneTool{.name = "ball", .mesh = scene.objects[0].mesh, .given_hash = 78};
  EXPECT_EQ(make_scene_facts(scene).tool_hash, 78U);
  EXPECT_NEAR(facts.lowest_m[0], -0.1, 1e-3);
  EXPECT_NEAR(facts.highest_m[2], 0.1, 1e-3);
  EXPECT_EQ(facts.point_count, SceneFacts::kMaxPoints);
  EXPECT_NEAR(Eigen::Map<const Eigen::Vector3f>(facts.points_m[3].data()).norm(), 0.1F, 1e-3F);
}

}  // namespace
}  // namespace hapton
