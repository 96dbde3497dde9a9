#include "core/force/unrendered_notes.h"

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

TEST(LeftOut, CountsObjectsWithEffectsFrictionOrDampingForALayer) {
  EXPECT_EQ(note_bare_layer(scene_with({TouchObject{}})), "");
  for (const Material& material : {Material{.damping_ns_per_m = 0.1}, Material{.friction_static = 0.1, .friction_dynamic = 0.1}}) {
    const std::string note = note_bare_layer(scene_with({{}, {.mesh = {}, .material = material}}));
    EXPECT_EQ(note.find("note: 1 of 2 objects: their effects, damping and friction begin at the surface"), 0U) << note;
    EXPECT_EQ(std::count(note.begin(), note.end(), '\n'), 1);
  }
  const std::string text = note_bare_layer(scene_with({{.mesh = {}, .material = {}, .effects = {.viscosity = {.damping_ns_per_m = 4}}}}));
  EXPECT_EQ(text.find("note: 1 of 1 object: their effects, damping and friction begin at the surface"), 0U) << text;
}

}  // namespace
}  // namespace hapton
