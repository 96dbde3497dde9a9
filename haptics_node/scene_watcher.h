#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include "haptic_step/scene_change.h"
#include "haptics_node/material_task.h"
#include "haptics_node/method_builder.h"
#include "runtime/file_watch.h"
#include "runtime/stoppable_calls.h"
#include "scene/scene_file.h"

namespace hapton {

// Polls a scene file and applies its changes while the scene is touched, without a force discontinuity: materials by MaterialTask,
// everything else by a new method from MethodBuilder. If the file has an error, the log says so in one line, and the scene in use stays.
// Threads: one calls poll(): the watcher's own after start(), otherwise the caller's. The destructor does not wait while the file is read.
// RT: no.
class SceneWatcher {
 public:
  struct Options {
    std::filesystem::path path;
    SceneLoading loading;
    double coupling_n_per_m = 0.0;
    bool has_tool = false;  // the stylus holds a rigid tool, of the scene or of the command line
    // Called when another scene comes into use, with that scene, its materials in series with the virtual coupling.
    std::function<void(const TouchScene&)> on_scene = {};
    // Reads the file. Pre: it may outlive the watcher.
    std::function<Result<Scene>(const std::filesystem::path& path, const SceneLoading& loading)> read = load_scene;
  };

  // scene: the one in use. Pre: material_task and builder outlive this.
  SceneWatcher(Options options, Scene scene, MaterialTask& material_task, MethodBuilder& builder);
  ~SceneWatcher();
  SceneWatcher(const SceneWatcher&) = delete;
  SceneWatcher& operator=(const SceneWatcher&) = delete;

  // Polls twice a second in a thread of its own, from now on.
  void start();

  enum class Outcome : std::uint8_t {
    unchanged,  // the file has not changed
    waiting,    // it has just changed, and may still be written; or the watcher ends while it is read
    rejected,   // it has an error, or a change that needs a new start of the node; the log says which
    same,       // nothing that is felt has changed
    materials,  // only numbers of materials have changed
    scene       // anything else has changed
  };
  // One poll. A change counts once two polls in a row have found the same file. A missing file changes nothing; the second poll
  // that misses it logs that.
  Outcome poll();

 private:
  void run();
  bool may_replace(const Scene& scene) const;
  Outcome take(Scene scene);
  Outcome take_scene(Scene scene, SceneChange change);

  Options options_;
  Scene built_scene_;   // for which the method in use was made; MaterialTask::follow gets the differences from it
  Scene scene_in_use_;  // read last of those that came into use
  MaterialTask& material_task_;
  MethodBuilder& builder_;
  FileWatch file_;
  std::uint32_t revision_ = 0;
  StoppableCalls calls_;
  std::thread thread_;
};

}  // namespace hapton
