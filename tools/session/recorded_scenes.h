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

// The scenes that a recording, or a running system, names by path, loading and hash. A recording of an earlier version does not say how its
// scene was loaded: it is loaded in metres and not fitted, with cracks sealed and then unsealed, and one of the two must have the recorded
// hash. Each scene is loaded once. Error: one line: the scene cannot be read, or is not the one that was recorded. RT: no. Threads: one.
class RecordedScenes {
 public:
  // scene: the file to read in place of the one that the recording names; empty: the one that it names.
  explicit RecordedScenes(std::string scene = {}) : file_(std::move(scene)) {}

  // Sets the file of the method that the recording names. Pre: make_touch() was not called yet.
  void use_method_file(const PluginChoice& choice) { method_file_ = choice; }

  Result<std::unique_ptr<TouchStep>> make_touch(const HapticsSetup& setup);
  Result<std::vector<Material>> make_materials(const HapticsSetup& setup, const MaterialState& state);
  // Null: the scene cannot be loaded, or programs do not deform the object.
  std::shared_ptr<const ProgramShape> find_program_shape(const HapticsSetup& setup, std::int32_t object);
  Result<std::vector<ObjectName>> find_names(const HapticsSetup& setup);
  // The same for a running system. If only the materials in the file have changed since (--watch-scene), it returns the names as well: the
  // file then has the same Scene::given_hash, and so the same objects. given_hash 0: unknown.
  Result<std::vector<ObjectName>> find_names(const HapticsSetup& setup, std::uint64_t given_hash);

 private:
  struct LoadedScene {
    TouchScene touch;
    std::vector<ObjectName> names;
    std::vector<std::shared_ptr<const ProgramShape>> program_shapes;  // by object; null: programs do not deform it
    std::uint64_t hash = 0;
    std::uint64_t given_hash = 0;
  };

  Result<const LoadedScene*> find_recorded(const HapticsSetup& setup);
  Result<const LoadedScene*> find(const std::string& path, const SceneLoading& loading);

  Result<std::unique_ptr<ForceMethod>> make_recorded(const MethodSettings& settings, const TouchScene& scene) const;

  std::string file_;
  std::optional<PluginChoice> method_file_;
  SimulatedClock clock_;  // stands still, so that no call of a plug-in is cut off for its time
  std::map<std::pair<std::string, std::uint32_t>, LoadedScene> scenes_;
};

}  // namespace hapton
