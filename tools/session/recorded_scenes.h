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
#include "scene/object_names.h"
#include "scene/scene_loading.h"

namespace hapton {

// The scenes that a recording, or a running system, names by path, loading and hash. A recording of an earlier version does not say how the
// scene was loaded: metres, no fit, and the cracks sealed or not; the recorded hash must be that of either. Each is loaded once. Error: one
// line: the scene cannot be read, or it is not the one that was recorded. RT: no.
class RecordedScenes {
 public:
  // scene: its file, where it is not where the haptics node had it; empty: it is.
  explicit RecordedScenes(std::string scene = {}) : file_(std::move(scene)) {}

  Result<std::unique_ptr<TouchStep>> make_touch(const HapticsSetup& setup);
  Result<std::vector<Material>> make_materials(const HapticsSetup& setup, const MaterialState& state);
  Result<std::vector<ObjectName>> find_names(const HapticsSetup& setup);

 private:
  struct LoadedScene {
    TouchScene touch;
    std::vector<ObjectName> names;
    std::uint64_t hash = 0;
  };

  Result<const LoadedScene*> find_recorded(const HapticsSetup& setup);
  Result<const LoadedScene*> find(const std::string& path, const SceneLoading& loading);

  std::string file_;
  std::map<std::pair<std::string, std::uint32_t>, LoadedScene> scenes_;
};

}  // namespace hapton
