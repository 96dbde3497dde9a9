#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "core/force/mapped_surface.h"
#include "core/tool/prepared_objects.h"
#include "haptic_step/grasp.h"
#include "haptics_node/material_task.h"
#include "haptics_node/method_builder.h"
#include "haptics_node/scene_describer.h"
#include "runtime/clock.h"
#include "runtime/latency_histogram.h"
#include "scene/annotations.h"
#include "scene/scene_file.h"

namespace hapton {

// The slow task of grasping: prepares the objects for contact with each other, makes a tool of an object that is picked up, moves that tool
// along with the device, and builds the scene again with the object where it was put down. The force never waits for this task.
// Threads: its own thread after start(), otherwise the caller of run_once(). RT: no.
class GraspTask {
 public:
  struct Options {
    double coupling_n_per_m = 0.0;                  // stiffness of the virtual coupling; 0: none
    double rotational_stiffness_nm_per_rad = 0.0;   // 0: derived from the object's size
    int threads = 1;                                // number of threads that share the search for contacts
    std::optional<double> shading_crease_rad = {};  // ProxyMethod::shading_crease_rad of the method
    // Called when the scene with an object that was put down is built, with this scene (its materials in series with the virtual coupling)
    // and its NewScene::revision. The step may begin to use the scene before or after this call; the revision identifies it.
    std::function<void(const TouchScene&, std::uint32_t)> on_scene = {};
    // Called when the tool of an object that is picked up is made.
    std::function<void(const ToolCoupling&)> on_tool = {};
  };

  // scene: as loaded. put_down: objects that start at another place than in it. Pre: link, material_task, builder and clock outlive this.
  GraspTask(Options options, const Scene& scene, const std::vector<PutDown>& put_down, GraspLink& link, const MaterialTask& material_task,
            MethodBuilder& builder, const Clock& clock);
  ~GraspTask();
  GraspTask(const GraspTask&) = delete;
  GraspTask& operator=(const GraspTask&) = delete;

  void start();
  // Ends the thread; then pose_times() is complete.
  void stop() noexcept;
  // Carries out one request, or moves the tool along with the device once, or prepares one object. False: there was nothing to do.
  bool run_once();

  const LatencyHistogram& pose_times() const noexcept { return pose_times_; }

 private:
  void run();
  void carry_out(const GraspRequest& request);
  // The scene with the changes of materials that MaterialTask has accepted (`hapton set`, or the scene file read again).
  TouchScene scene_as_tuned() const;
  void pick_up(const GraspRequest& request);
  void put_down(const GraspRequest& request);
  // Prepares one surface with images that is not yet prepared at its present place. False: all are prepared.
  bool map_next();

  Options options_;
  Scene scene_;  // with the objects where they are now
  Scene loaded_scene_;
  PreparedObjects objects_;
  std::vector<std::shared_ptr<const MappedSurface>> mapped_surfaces_;  // for each object; null: it has no images, or is not prepared yet
  GraspLink& link_;
  const MaterialTask& material_task_;
  MethodBuilder& builder_;
  const Clock& clock_;
  std::unique_ptr<HeldTool> tool_;  // the step holds it until it requests something else
  std::uint32_t revision_ = 0;
  SceneDescriber describer_;
  std::uint32_t last_request_ = 0;  // its serial
  LatencyHistogram pose_times_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

// For each object of the scene: whether the stylus can pick it up.
std::vector<bool> list_movable(const Scene& scene);

}  // namespace hapton
