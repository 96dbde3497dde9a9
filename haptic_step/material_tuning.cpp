#include "haptic_step/material_tuning.h"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <span>

#include "core/base/similar_word.h"
#include "core/force/virtual_coupling.h"
#include "scene/material_limits.h"
#include "scene/scene_file.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

// MaterialState::Object::object of a change of all objects. It is less than every index, so this change is the first in a state and is
// applied before the changes of single objects.
constexpr std::int32_t kAllObjects = -1;

// A number that a change may have: its bit in MaterialChange::fields, and where it is in a change and in a material.
struct MaterialNumber {
  std::uint32_t bit;
  double MaterialChange::*in_change;
  double Material::*in_material;
};

constexpr MaterialNumber kMaterialNumbers[] = {
    {MaterialChange::kStiffness, &MaterialChange::stiffness_n_per_m, &Material::stiffness_n_per_m},
    {MaterialChange::kDamping, &MaterialChange::damping_ns_per_m, &Material::damping_ns_per_m},
    {MaterialChange::kFrictionStatic, &MaterialChange::friction_static, &Material::friction_static},
    {MaterialChange::kFrictionDynamic, &MaterialChange::friction_dynamic, &Material::friction_dynamic},
};

void apply(const MaterialChange& change, Material& material) {
  for (const MaterialNumber& number : kMaterialNumbers) {
    if ((change.fields & number.bit) != 0) material.*number.in_material = change.*number.in_change;
  }
}

// Adds the numbers of a later change; where both changes have a number, that of the later one replaces the other.
void merge(const MaterialChange& later, MaterialChange& into) {
  for (const MaterialNumber& number : kMaterialNumbers) {
    if ((later.fields & number.bit) != 0) into.*number.in_change = later.*number.in_change;
  }
  into.fields |= later.fields;
}

// Removes the numbers with these bits from a change and sets them to zero: the codec rejects a change with another value there.
void remove(std::uint32_t bits, MaterialChange& from) {
  for (const MaterialNumber& number : kMaterialNumbers) {
    if ((bits & number.bit) != 0) from.*number.in_change = 0.0;
  }
  from.fields &= ~bits;
}

std::span<MaterialState::Object> objects_of(MaterialState& state) { return std::span(state.objects).first(state.object_count); }

// Merges a change into that of an object; kAllObjects is allowed. The entries of a state are in ascending order of `object`, as the codec
// requires. False: there is no room for another entry.
bool merge_into(MaterialState& state, std::int32_t object, const MaterialChange& change) {
  const auto end = state.objects.begin() + state.object_count;
  const auto at = std::lower_bound(state.objects.begin(), end, object,
                                   [](const MaterialState::Object& one, std::int32_t number) { return one.object < number; });
  if (at == end || at->object != object) {
    if (end == state.objects.end()) return false;
    ++state.object_count;
    std::move_backward(at, end, end + 1);
    *at = {object, {}};
  }
  merge(change, at->change);
  return true;
}

// Removes the numbers with these bits from all changes of a state, and the changes that have no numbers then. A new change of all objects
// replaces earlier ones of single objects, which would otherwise be applied after it.
void remove_from_each(MaterialState& state, std::uint32_t bits) {
  for (MaterialState::Object& one : objects_of(state)) remove(bits, one.change);
  const auto known = objects_of(state);
  const auto end = std::remove_if(known.begin(), known.end(), [](const MaterialState::Object& one) { return one.change.fields == 0; });
  std::fill(end, known.end(), MaterialState::Object());
  state.object_count = static_cast<std::uint32_t>(end - known.begin());
}

Material tuned_material(const Material& scene_material, std::int32_t object, const MaterialState& state) {
  Material material = scene_material;
  for (std::size_t i = 0; i < state.object_count; ++i) {
    if (state.objects[i].object == kAllObjects || state.objects[i].object == object) apply(state.objects[i].change, material);
  }
  return material;
}

}  // namespace

std::vector<Material> tuned_materials(const TouchScene& scene, const MaterialState& state, double coupling_n_per_m) {
  std::vector<Material> materials;
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const Material tuned = tuned_material(scene.objects[o].material, static_cast<std::int32_t>(o), state);
    materials.push_back(couple_material(tuned, coupling_n_per_m));
  }
  return materials;
}

MaterialTuning::MaterialTuning(const Scene& scene) : scene_(scene.touch_scene()) {
  for (const SceneObject& object : scene.objects) names_.push_back(object.name);
}

std::vector<std::size_t> MaterialTuning::find_objects(std::string_view name) const {
  std::vector<std::size_t> found;
  for (std::size_t o = 0; o < names_.size(); ++o) {
    if (name.empty() || names_[o] == name) found.push_back(o);
  }
  return found;
}

Result<void> MaterialTuning::change(const MaterialRequest& request) {
  const std::string_view name(request.object.data());
  const std::vector<std::size_t> objects = find_objects(name);
  if (objects.empty()) {
    const std::vector<std::string_view> known(names_.begin(), names_.end());
    return fail("the scene has no object '{}'{}", printable(name), similar_word_hint(name, known));
  }
  MaterialState new_state = state_;
  bool has_room = true;
  if (name.empty()) {
    remove_from_each(new_state, request.change.fields);
    has_room = merge_into(new_state, kAllObjects, request.change);
  } else {
    for (const std::size_t o : objects) has_room = has_room && merge_into(new_state, static_cast<std::int32_t>(o), request.change);
  }
  if (!has_room) {
    return fail("no more than {} objects can be changed one by one: change all, or the scene file", MaterialState::kMaxObjects);
  }
  std::optional<Error> first_error;
  bool is_any_valid = false;
  for (const std::size_t o : objects) {
    const Material& scene_material = scene_.objects[o].material;
    const auto checked = check_material(tuned_material(scene_material, static_cast<std::int32_t>(o), new_state), scene_material,
                                        scene_.objects[o].effects, names_[o]);
    if (checked) {
      is_any_valid = true;
    } else if (!first_error) {
      first_error = checked.error();
    }
  }
  if (first_error && is_any_valid && name.empty()) {
    return fail("{}; or change one of the others (--object NAME)", first_error->what);
  }
  if (first_error) return tl::unexpected(*first_error);
  state_ = new_state;
  last_objects_ = objects;
  return {};
}

std::string MaterialTuning::describe_last() const {
  if (last_objects_.empty()) return {};
  const std::size_t first = last_objects_[0];
  const Material material = tuned_material(scene_.objects[first].material, static_cast<std::int32_t>(first), state_);
  const std::string which = last_objects_.size() == 1 ? fmt::format("object '{}'", printable(names_[first]))
                                                      : fmt::format("{} objects, the first", last_objects_.size());
  return fmt::format("{}: stiffness {:g} N/m, damping {:g} Ns/m, friction {:g} / {:g} (static / dynamic)", which,
                     material.stiffness_n_per_m, material.damping_ns_per_m, material.friction_static, material.friction_dynamic);
}

}  // namespace hapton
