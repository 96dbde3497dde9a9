#include "tools/check/tool_check.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

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
    const CheckFindings findings = check_tool(scene).value();
    ASSERT_EQ(findings.size(), gap_m < 1e-6 ? 1U : 0U) << gap_m;
    if (findings.empty()) continue;
    EXPECT_EQ(findings[0].fault, SceneFault::overlaps);
    EXPECT_EQ(findings[0].object, "brick");
    scene.objects[1].is_movable = false;
    EXPECT_TRUE(check_tool(scene).value().empty()) << "nobody picks it up";
  }
}

TEST(ToolCheck, AMovableObjectThatCannotBePickedUpIsNamed) {
  Scene scene;
  scene.objects = {block_at("table", Vec3::Zero(), false), block_at("nothing", Vec3::Zero(), true)};
  scene.objects[1].mesh = made::shared(TriangleMesh());
  const CheckFindings findings = check_tool(scene).value();
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].object, "nothing");
  EXPECT_EQ(findings[0].what.find("it cannot be picked up: "), 0U) << findings[0].what;
}

// The rotational stiffness of a rod of length L is k L^2 / 18 about its middle (two thirds of k L^2 / 12), four times that about an end.
TEST(ToolCheck, ABodyTurnsAsStifflyAsSpringsOverItsSurface) {
  constexpr double kLengthM = 0.3;
  const auto rod = made::shared(made::box(Vec3(-1e-5, -1e-5, -0.5 * kLengthM), Vec3(1e-5, 1e-5, 0.5 * kLengthM)));
  Scene scene;
  scene.objects = {block_at("table", Vec3::Zero(), false), block_at("rod", Vec3::Zero(), true)};
  scene.objects[0].material.stiffness_n_per_m = 900.0;
  scene.objects[1].material.stiffness_n_per_m = 300.0;
  scene.objects[1].mesh = rod;
  const double about_middle = 900.0 * kLengthM * kLengthM / 18.0;
  ASSERT_EQ(list_rotational_stiffness(scene).size(), 1U) << "the table stays";
  EXPECT_EQ(list_rotational_stiffness(scene)[0].name, "rod");
  EXPECT_NEAR(list_rotational_stiffness(scene)[0].nm_per_rad, 4.0 * about_middle, 1e-3 * about_middle) << "held at its end";
  scene.tool = SceneTool{.name = "peg", .mesh = rod};
  ASSERT_EQ(list_rotational_stiffness(scene).size(), 1U) << "nothing else is picked up";
  EXPECT_EQ(list_rotational_stiffness(scene)[0].name, "peg");
  EXPECT_NEAR(list_rotational_stiffness(scene)[0].nm_per_rad, about_middle, 1e-3 * about_middle);
  scene.tool.reset();
  scene.objects[1].is_movable = false;
  EXPECT_TRUE(list_rotational_stiffness(scene).empty());
}

TEST(ToolCheck, TheOnlyObjectOverlapsNothing) {
  Scene scene;
  scene.objects = {block_at("brick", Vec3::Zero(), true)};
  EXPECT_TRUE(check_tool(scene).value().empty());
}

TEST(ToolCheck, WhatAToolDoesNotFeelIsNamedWhereThereIsATool) {
  Scene scene;
  scene.objects = {block_at("sheet", Vec3::Zero(), false)};
  scene.objects[0].material.two_sided = false;
  EXPECT_TRUE(check_tool(scene).value().empty()) << "a probe feels it";
  scene.tool = SceneTool{.name = "peg", .mesh = scene.objects[0].mesh};
  const CheckFindings findings = check_tool(scene).value();
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].fault, SceneFault::shape_alone);
  EXPECT_EQ(findings[0].object, "sheet");
  scene.tool.reset();
  scene.objects.push_back(block_at("brick", Vec3::Constant(0.05), true));
  ASSERT_EQ(check_tool(scene).value().size(), 1U);
  EXPECT_NE(check_tool(scene).value()[0].what.find("the probe feels all of it"), std::string::npos);
}

TEST(ToolCheck, AToolThatTheNodeRejectsIsRejected) {
  Scene scene;
  scene.objects = {block_at("table", Vec3::Zero(), false)};
  TriangleMesh line = *scene.objects[0].mesh;
  for (Vec3& p : line.vertices) p.setZero();
  scene.tool = SceneTool{.name = "dot", .mesh = made::shared(line)};
  const auto findings = check_tool(scene);
  ASSERT_FALSE(findings);
  EXPECT_EQ(findings.error().what, "tool dot: the tool has no surface about its grip point");
}

TEST(ToolCheck, AToolInAnotherUnitOrFarFromItsGripIsNamed) {
  Scene scene;
  scene.objects = {block_at("table", Vec3::Zero(), false)};
  const auto faults_of = [&](const Vec3& low_m, double size_m) {
    scene.tool = SceneTool{.name = "peg", .mesh = made::shared(made::box(low_m, low_m + Vec3::Constant(size_m)))};
    std::string faults;
    const CheckFindings findings = check_tool(scene).value();
    for (const CheckFinding& finding : findings) {
      EXPECT_EQ(finding.fault, SceneFault::odd_tool);
      EXPECT_EQ(finding.object, "peg");
      faults += finding.what + "; ";
    }
    return faults;
  };
  EXPECT_EQ(faults_of(Vec3::Constant(-0.005), 0.01), "");
  EXPECT_EQ(faults_of(Vec3(0.0, 0.0, 0.008), 0.001), "") << "a tip";
  EXPECT_EQ(faults_of(Vec3::Constant(-5e-6), 1e-5), "the tool is 0.01 mm long, the scene 20 mm; ");
  EXPECT_EQ(faults_of(Vec3::Constant(-5.0), 10.0), "the tool is 10000 mm long, the scene 20 mm; ");
  EXPECT_EQ(faults_of(Vec3(0.15, 0.0, 0.0), 0.01), "the tool is 150 mm away from where the stylus holds it, and 10 mm long; ");
}

}  // namespace
}  // namespace hapton
