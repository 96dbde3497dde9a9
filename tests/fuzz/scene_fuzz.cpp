// Any bytes as a scene file, beside a mesh that it may use.
#include "scene/scene_file.h"
#include "tests/fuzz/input_file.h"

FUZZ_TARGET(scene) {
  using namespace hapton;
  static fuzz::InputFile file("scene.toml");
  static const auto mesh = file.folder().write("a.obj", "o lid\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\no box\nf 1 2 4\n");
  const auto scene = load_scene(file.write(bytes));
  if (!scene) {
    fuzz::require(!scene.error().what.empty());
    fuzz::require(scene.error().what.find('\n') == std::string::npos);
    return;
  }
  fuzz::require(!scene->objects.empty());
  for (const SceneObject& object : scene->objects) {
    fuzz::require(object.mesh != nullptr && !object.mesh->triangles.empty());
    for (const Vec3& vertex : object.mesh->vertices) fuzz::require(vertex.allFinite());
    fuzz::require(object.material.stiffness_n_per_m > 0.0);
    fuzz::require(object.material.friction_dynamic <= object.material.friction_static);
    fuzz::require(object.effects.snap.bound_n() <= kMaxEffectForceN);
    fuzz::require(object.effects.layers.count() <= TissueLayers::kMax);
  }
  for (const SceneEffect& effect : scene->effects) {
    fuzz::require(bound_of(effect.effect) >= 0.0 && bound_of(effect.effect) <= kMaxEffectForceN);
  }
}
