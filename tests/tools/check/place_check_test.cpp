#include "tools/check/place_check.h"

#include <gtest/gtest.h>

#include <memory>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

SceneObject named_object(std::string name, TriangleMesh mesh) {
  SceneObject object;
  object.name = std::move(name);
  object.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
  return object;
}

TriangleMesh ball_around(double radius_m, const Vec3& middle) { return scaled_and_moved(make_icosphere(radius_m, 3), 1.0, middle); }

TEST(PlaceCheck, TheSecondOfTwoObjectsInOnePlaceIsNamed) {
  Scene scene;
  scene.objects = {named_object("a", ball_around(0.03, Vec3::Zero())), named_object("b", ball_around(0.03, Vec3(1e-13, 0, 0)))};
  const CheckFindings findings = check_places(scene);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].fault, SceneFault::coincides);
  EXPECT_EQ(findings[0].object, "b");
  scene.objects[1] = named_object("b", ball_around(0.03, Vec3(1e-4, 0, 0)));
  EXPECT_TRUE(check_places(scene).empty());
}

TEST(PlaceCheck, ObjectsWithoutTrianglesAreInNoPlace) {
  Scene scene;
  scene.objects = {named_object("a", {}), named_object("b", {}), named_object("ball", ball_around(0.03, Vec3::Zero()))};
  scene.view.camera = SceneCamera{.p_WE = Vec3(0, 0, 0.2), .p_WC = Vec3::Zero()};
  EXPECT_TRUE(check_places(scene).empty());
}

TEST(PlaceCheck, WhatIsAltogetherInsideAClosedBodyIsNamed) {
  Scene scene;
  scene.objects = {named_object("kernel", ball_around(0.01, Vec3::Zero())), named_object("shell", ball_around(0.03, Vec3::Zero()))};
  CheckFindings findings = check_places(scene);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].fault, SceneFault::enclosed);
  EXPECT_EQ(findings[0].object, "kernel");
  const auto has_no_finding = [&](TriangleMesh kernel, TriangleMesh shell) {
    scene.objects = {named_object("kernel", std::move(kernel)), named_object("shell", std::move(shell))};
    return check_places(scene).empty();
  };
  EXPECT_TRUE(has_no_finding(ball_around(0.01, Vec3(0.025, 0, 0)), ball_around(0.03, Vec3::Zero()))) << "it protrudes";
  const TriangleMesh hollow = joined(ball_around(0.03, Vec3::Zero()), flipped(ball_around(0.02, Vec3::Zero())));
  EXPECT_TRUE(has_no_finding(ball_around(0.01, Vec3::Zero()), hollow)) << "in a cavity, beside the material";
  TriangleMesh bowl = ball_around(0.03, Vec3::Zero());
  std::erase_if(bowl.triangles, [&](const Triangle& t) { return bowl.vertices[t[0]].z() > 0.015; });
  EXPECT_TRUE(has_no_finding(ball_around(0.005, Vec3::Zero()), std::move(bowl))) << "in a bowl";
}

TEST(PlaceCheck, CameraAndLightsInsideABodyAreNamed) {
  Scene scene;
  scene.objects = {named_object("ball", ball_around(0.03, Vec3::Zero()))};
  scene.view.camera = SceneCamera{.p_WE = Vec3(0, 0, 0.02), .p_WC = Vec3(0, 0, -0.1)};
  scene.view.lights = {{}, {.has_position = true, .towards_or_p_W = Vec3(0, 0.01, 0)}};
  const CheckFindings findings = check_places(scene);
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_NE(findings[0].what.find("the camera is inside object 'ball'"), std::string::npos) << findings[0].what;
  EXPECT_NE(findings[1].what.find("[[light]] 2 is inside object 'ball'"), std::string::npos) << findings[1].what;
  scene.view.camera->p_WE = Vec3(0, 0, 0.2);
  scene.view.lights[1].towards_or_p_W = Vec3(0, 0.1, 0);
  EXPECT_TRUE(check_places(scene).empty());
}

TEST(PlaceCheck, FrictionBeyondAnyDrySurfaceIsNamedWithTheValue) {
  SceneObject object = named_object("pad", ball_around(0.03, Vec3::Zero()));
  object.material.friction_static = kMaxFriction;
  EXPECT_TRUE(check_friction(object).empty());
  object.material.friction_static = 8.0;
  const CheckFindings findings = check_friction(object);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_NE(findings[0].what.find("friction_static = 8: the tip sticks until it is pulled 82.9 degrees"), std::string::npos)
      << findings[0].what;
  EXPECT_NE(findings[0].fix.find("up to 2"), std::string::npos) << findings[0].fix;
}

}  // namespace
}  // namespace hapton
