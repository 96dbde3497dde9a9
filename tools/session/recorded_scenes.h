#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/force/touch_step.h"
#include "link/messages.h"
#include "plugin/plugin_choice.h"
#include "runtime/clock.h"
#include "scene/object_names.h"
#include "scene/program_shape.h"
#include "scene/scene_loading.h"

namespace hapton {

// The scenes that a recording, or a running system, names by path, loading and hash. A recording of an earlier version does not say how the
// scene was loaded: metres, no fit, and the cracks sealed or not; the recorded hash must be that of either. Each is loaded once. Error: one
// line: the scene cannot be read, or it is not the one that was recorded. RT: no.
class RecordedScenes {
 public:
  // scene: its file, where it is not where the haptics node had it; empty: it is.
  explicit RecordedScenes(std::string scene = {}) : file_(std::move(scene)) {}

  // Before the first make_touch: the file of the method that the recording names.
  void use_method_file(const PluginChoice& choice) { method_file_ = choice; }

  Result<std::unique_ptr<TouchStep>> make_touch(const HapticsSetup& setup);
  Result<std::vector<Material>> make_materials(const HapticsSetup& setup, const MaterialState& state);
  // Null: it is not there, or programs do not deform the object.
  std::shared_ptr<const ProgramShape> find_program_shape(const HapticsSetup& setup, std::int32_t object);
  Result<std::vector<ObjectName>> find_names(const HapticsSetup& setup);
  // The same of a running system, also where the file's materials have changed since (--watch-scene): it must have the same objects, by
  // Scene::given_hash.
  Result<std::vector<ObjectName>> find_names(const HapticsSetup& setup, std::uint64_t given_hash);

 private:
  struct LoadedScene {
    TouchScene touch;
    std::vector<ObjectName> names;
    std::vector<std::shared_ptr<const ProgramShape>> program_shapes;  // by object
    std::uint64_t hash = 0;
    std::uint64_t given_hash = 0;
  };

  Result<const LoadedScene*> find_recorded(const HapticsSetup& setup);
  Result<const LoadedScene*> find(const std::string& path, const SceneLoading& loading);

  Result<std::unique_ptr<ForceMethod>> make_recorded(const MethodSettings& settings, const TouchScene& scene) const;

  std::string file_;
  std::optional<PluginChoice> method_file_;
  SimulatedClock clock_;  // stands still: calls of a plug-in may take any time
  std::map<std::pair<std::string, std::uint32_t>, LoadedScene> scenes_;
};

}  // namespace hapton
