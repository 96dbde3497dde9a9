#include "tools/session/recorded_scenes.h"

#include <fmt/core.h>

#include "core/force/virtual_coupling.h"
#include "haptic_step/material_tuning.h"
#include "haptic_step/method_text.h"
#include "plugin/plugin_method.h"
#include "scene/scene_file.h"
#include "scene/scene_hash.h"

namespace hapton {

Result<std::unique_ptr<TouchStep>> RecordedScenes::make_touch(const HapticsSetup& setup) {
  const auto scene = find_recorded(setup);
  if (!scene) return tl::unexpected(scene.error());
  auto settings = parse_method_text(setup.method.data());
  if (!settings) return tl::unexpected(settings.error());
  // No slow task runs beside these steps, so everything is built at the start.
  settings->build_on_approach = false;
  auto method = make_recorded(*settings, (*scene)->touch);
  if (!method) return tl::unexpected(method.error());
  return std::make_unique<TouchStep>(std::move(*method), (*scene)->touch);
}

Result<std::unique_ptr<ForceMethod>> RecordedScenes::make_recorded(const MethodSettings& settings, const TouchScene& scene) const {
  if (!is_plugin_method(settings.name)) return make_method(settings, scene);
  if (!method_file_)
    return fail("the session has a method from a file, {}: name the same file with the same parameters, --method FILE.so:KEY=VALUE,...",
                settings.name);
  auto made = PluginMethod::make(*method_file_, couple_scene(scene, settings.coupling_n_per_m), clock_);
  if (!made) return tl::unexpected(made.error());
  if ((*made)->full_name() != settings.name)
    return fail("{}: is another method than the one of the session ({}, recorded {}); name that file, with its parameters",
                method_file_->file, (*made)->full_name(), settings.name);
  return std::move(*made);
}

Result<std::vector<Material>> RecordedScenes::make_materials(const HapticsSetup& setup, const MaterialState& state) {
  const auto scene = find_recorded(setup);
  if (!scene) return tl::unexpected(scene.error());
  const auto settings = parse_method_text(setup.method.data());
  if (!settings) return tl::unexpected(settings.error());
  return tuned_materials((*scene)->touch, state, settings->coupling_n_per_m);
}

std::shared_ptr<const ProgramShape> RecordedScenes::find_program_shape(const HapticsSetup& setup, std::int32_t object) {
  const auto scene = find_recorded(setup);
  if (!scene || object < 0 || static_cast<std::size_t>(object) >= (*scene)->program_shapes.size()) return nullptr;
  return (*scene)->program_shapes[static_cast<std::size_t>(object)];
}

Result<std::vector<ObjectName>> RecordedScenes::find_names(const HapticsSetup& setup) {
  return find_recorded(setup).map([](const LoadedScene* scene) { return scene->names; });
}

Result<std::vector<ObjectName>> RecordedScenes::find_names(const HapticsSetup& setup, std::uint64_t given_hash) {
  auto names = find_names(setup);
  const auto loading = from_code(setup.scene_loading);
  if (names || given_hash == 0 || !loading) return names;
  const auto scene = find(file_.empty() ? setup.scene.data() : file_, *loading);
  if (scene && (*scene)->given_hash == given_hash) return (*scene)->names;
  return names;
}

Result<const RecordedScenes::LoadedScene*> RecordedScenes::find_recorded(const HapticsSetup& setup) {
  const std::string path = file_.empty() ? setup.scene.data() : file_;
  if (setup.scene_hash == 0) return fail("{}: an object was put down, and the recording does not have the scene with it", path);
  const auto loading = from_code(setup.scene_loading);
  auto scene = find(path, loading.value_or(SceneLoading()));
  if (!scene) return fail("{}; give its present place with --scene FILE", scene.error().what);
  const std::uint64_t hash = (*scene)->hash;
  if (hash != setup.scene_hash && !loading) scene = find(path, {.sealing = CrackSealing::off});
  if (!scene || (*scene)->hash != setup.scene_hash) {
    return fail("{}: is not the scene that was recorded (its hash is {:016x}, recorded {:016x}); name that one with --scene", path, hash,
                setup.scene_hash);
  }
  return scene;
}

Result<const RecordedScenes::LoadedScene*> RecordedScenes::find(const std::string& path, const SceneLoading& loading) {
  const auto key = std::pair(path, to_code(loading));
  auto found = scenes_.find(key);
  if (found == scenes_.end()) {
    const auto scene = load_scene(path, loading);
    if (!scene) return tl::unexpected(scene.error());
    std::vector<std::shared_ptr<const ProgramShape>> shapes;
    for (const SceneObject& one : scene->objects) shapes.push_back(one.program_shape);
    found = scenes_
                .emplace(key, LoadedScene{scene->touch_scene(), object_names(*scene), std::move(shapes), hash_scene(scene->touch_scene()),
                                          scene->given_hash})
                .first;
  }
  return &found->second;
}

}  // namespace hapton
