#include "tools/check/tool_check.h"

#include <gtest/gtest.h>

#include <memory>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

SceneObject block_at(const std::string& name, const Vec3& low_m, bool is_movable) {
  SceneObject object;
  object.name = name;
  object.mesh = made::shared(made::box(low_m, low_m + Vec3::Constant(0.02)));
  object.is_movable = is_movable;
  return object;
}

TEST(ToolCheck, AMovableObjectThatOverlapsOrTouchesAnotherIsNamed) {
  for (const double gap_m : {-0.001, 0.0, 1e-9, 1e-4}) {
    Scene scene;
    scene.objects = {block_at("table", Vec3::Zero(), false), block_at("brick", Vec3(0.001, 0.002, 0.02 + gap_m), true)};
    const CheckFindings found = check_tool(scene);
    ASSERT_EQ(found.size(), gap_m < 1e-6 ? 1U : 0U) << gap_m;
    if (found.empty()) continue;
    EXPECT_EQ(found[0].fault, SceneFault::overlaps);
    EXPECT_EQ(found[0].object, "brick");
    scene.objects[1].is_movable = false;
    EXPECT_TRUE(check_tool(scene).empty()) << "nobody picks it up";
  }
}

TEST(ToolCheck, WhatCannotBePickedUpIsNoCleanScene) {
  Scene scene;
  scene.objects = {block_at("table", Vec3::Zero(), false), block_at("nothing", Vec3::Zero(), true)};
  scene.objects[1].mesh = made::shared(TriangleMesh());
  const CheckFindings found = check_tool(scene);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].object, "nothing");
  EXPECT_EQ(found[0].what.find("it cannot be picked up: "), 0U) << found[0].what;
}

TEST(ToolCheck, TheOnlyObjectOverlapsNothing) {
  Scene scene;
  scene.objects = {block_at("brick", Vec3::Zero(), true)};
  EXPECT_TRUE(check_tool(scene).empty());
}

TEST(ToolCheck, WhatAToolDoesNotFeelIsNamedWhereThereIsATool) {
  Scene scene;
  scene.objects = {block_at("sheet", Vec3::Zero(), false)};
  scene.objects[0].material.two_sided = false;
  EXPECT_TRUE(check_tool(scene).empty()) << "a probe feels it";
  scene.tool = SceneTool{.name = "peg", .mesh = scene.objects[0].mesh};
  const CheckFindings found = check_tool(scene);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].fault, SceneFault::shape_alone);
  EXPECT_EQ(found[0].object, "sheet");
  scene.tool.reset();
  scene.objects.push_back(block_at("brick", Vec3::Constant(0.05), true));
  ASSERT_EQ(check_tool(scene).size(), 1U);
  EXPECT_NE(check_tool(scene)[0].what.find("the probe feels all of it"), std::string::npos);
}

}  // namespace
}  // namespace hapton
