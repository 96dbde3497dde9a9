#include "core/force/left_out.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TouchScene scene_with(const std::vector<TouchObject>& objects) {
  TouchScene scene{.objects = objects};
  for (TouchObject& object : scene.objects) object.mesh = std::make_shared<const TriangleMesh>(make_icosphere(0.05, 0));
  return scene;
}

TEST(LeftOut, CountsObjectsWithFrictionOrDamping) {
  const TouchObject plain;
  EXPECT_EQ(note_missing_friction(scene_with({plain, plain})), "");
  for (const Material& material :
       {Material{.damping_ns_per_m = 0.1}, Material{.friction_static = 0.1}, Material{.friction_static = 0.1, .friction_dynamic = 0.1}}) {
    const std::string text = note_missing_friction(scene_with({plain, {.mesh = {}, .material = material}}));
    EXPECT_EQ(text.find("note: 1 of 2 objects: their damping and friction are ignored"), 0U) << text;
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
  }
}

TEST(LeftOut, CountsObjectsWithEffectsForALayer) {
  EXPECT_EQ(note_bare_layer(scene_with({TouchObject{}})), "");
  const std::string text = note_bare_layer(scene_with({{.mesh = {}, .material = {}, .effects = {.viscosity = {.damping_ns_per_m = 4}}}}));
  EXPECT_EQ(text.find("note: 1 of 1 object: their effects begin at the surface"), 0U) << text;
}

}  // namespace
}  // namespace hapton
