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

// Polls a scene file and applies its changes while the scene is touched, without a force discontinuity: materials as MaterialTask changes
// them, everything else by a method that MethodBuilder swaps. A file with an error is one line in the log, and the scene in use goes on.
// Threads: poll() from one: its own after start(), otherwise the caller's. The destructor does not wait for a file that is being read.
// RT: no.
class SceneWatcher {
 public:
  struct Options {
    std::filesystem::path path;
    SceneLoading loading;
    double coupling_n_per_m = 0.0;
    bool has_tool = false;  // the stylus holds a rigid tool, of the scene or of the command line
    // Called after another scene is in use: with the scene that is felt now, its materials in series with the virtual coupling.
    std::function<void(const TouchScene&)> on_scene = {};
    // Reads the file. Pre: it may outlive the watcher.
    std::function<Result<Scene>(const std::filesystem::path& path, const SceneLoading& loading)> read = load_scene;
  };

  // scene: in use. Pre: material_task and builder outlive this.
  SceneWatcher(Options options, Scene scene, MaterialTask& material_task, MethodBuilder& builder);
  ~SceneWatcher();
  SceneWatcher(const SceneWatcher&) = delete;
  SceneWatcher& operator=(const SceneWatcher&) = delete;

  // Polls twice a second in a thread of its own, from now on.
  void start();

  enum class Outcome : std::uint8_t {
    unchanged,  // the file
    waiting,    // it has just changed, and may be being written; or the watcher ends while it is read
    rejected,   // it has an error
    same,       // nothing that is felt has changed
    materials,
    scene
  };
  // One poll. A change counts once two polls found the same file. A file that is gone changes nothing; at the second poll the log
  // says so.
  Outcome poll();

 private:
  void run();
  bool may_replace(const Scene& scene) const;
  Outcome take(Scene scene);
  Outcome take_scene(Scene scene, SceneChange change);

  Options options_;
  Scene base_;  // that the material_task's states differ from: what the method in use was made for
  Scene used_;  // what was read last
  MaterialTask& material_task_;
  MethodBuilder& builder_;
  FileWatch file_;
  std::uint32_t revision_ = 0;
  StoppableCalls calls_;
  std::thread thread_;
};

}  // namespace hapton
