#include "haptic_step/scene_change.h"

#include "scene/scene_hash.h"

namespace hapton {
namespace {

bool is_same_motion(const SceneObject& a, const SceneObject& b) {
  return a.motion == b.motion || (a.motion != nullptr && b.motion != nullptr && *a.motion == *b.motion);
}

bool is_same_deformation(const SceneObject& a, const SceneObject& b) {
  if ((a.program_shape == nullptr) != (b.program_shape == nullptr)) return false;
  if (a.program_shape != nullptr && !(*a.program_shape == *b.program_shape)) return false;
  return a.deformation == b.deformation || (a.deformation != nullptr && b.deformation != nullptr && *a.deformation == *b.deformation);
}

bool is_commanded_alike(const SceneObject& a, const SceneObject& b) {
  if (a.commanded == nullptr || b.commanded == nullptr) return a.commanded == b.commanded;
  return a.commanded->pivot() == b.commanded->pivot() && a.commanded->radius_m() == b.commanded->radius_m();
}

bool is_same_shape(const SceneObject& a, const SceneObject& b) {
  return is_same_motion(a, b) && is_commanded_alike(a, b) && is_same_deformation(a, b) && a.sculpt == b.sculpt &&
         a.material.two_sided == b.material.two_sided && hash_mesh(*a.mesh) == hash_mesh(*b.mesh) &&
         a.mesh->authored_normals == b.mesh->authored_normals;
}

bool is_same_material(const Material& a, const Material& b) {
  return a.stiffness_n_per_m == b.stiffness_n_per_m && a.damping_ns_per_m == b.damping_ns_per_m && a.friction_static == b.friction_static &&
         a.friction_dynamic == b.friction_dynamic;
}

}  // namespace

SceneChange compare_scenes(const Scene& before, const Scene& after) {
  if (before.objects.size() != after.objects.size()) return SceneChange::shape;
  bool has_same_materials = true;
  bool has_same_names = true;
  TouchScene with_old_materials = after.touch_scene();
  for (std::size_t o = 0; o < before.objects.size(); ++o) {
    const SceneObject& a = before.objects[o];
    const SceneObject& b = after.objects[o];
    if (!is_same_shape(a, b)) return SceneChange::shape;
    has_same_materials = has_same_materials && is_same_material(a.material, b.material);
    has_same_names = has_same_names && a.name == b.name && a.material_name == b.material_name;
    with_old_materials.objects[o].material = a.material;
  }
  // Shapes and materials are the same here, so only effects can make the hashes differ.
  if (hash_scene(before.touch_scene()) != hash_scene(with_old_materials)) return SceneChange::effects;
  if (!has_same_names) return has_same_materials ? SceneChange::names : SceneChange::effects;
  return has_same_materials ? SceneChange::none : SceneChange::materials;
}

std::optional<MaterialState> describe_materials(const Scene& before, const Scene& after) {
  MaterialState state;
  for (std::size_t o = 0; o < before.objects.size(); ++o) {
    const Material& now = after.objects[o].material;
    if (is_same_material(before.objects[o].material, now)) continue;
    if (state.object_count == MaterialState::kMaxObjects) return std::nullopt;
    state.objects[state.object_count++] = {static_cast<std::int32_t>(o),
                                           {.fields = MaterialChange::kAll,
                                            .stiffness_n_per_m = now.stiffness_n_per_m,
                                            .damping_ns_per_m = now.damping_ns_per_m,
                                            .friction_static = now.friction_static,
                                            .friction_dynamic = now.friction_dynamic}};
  }
  return state;
}

}  // namespace hapton
