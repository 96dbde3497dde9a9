#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/mailbox.h"
#include "core/force/touch_scene.h"
#include "core/tool/stylus_tool.h"
#include "haptic_step/material_tuning.h"
#include "link/messages.h"

namespace hapton {

// The result of a request: the materials of all objects, or why none is changed.
struct TunedMaterials {
  std::vector<Material> materials;                   // for ForceMethod::set_materials; empty: rejected
  std::optional<ToolMaterials> tool_materials = {};  // if the stylus holds a rigid tool all the time
  HapticsSetup::Text tool_method = {};               // then: its text for HapticsSetup::method
  MaterialState state;                               // without the serial, which is set when the materials come into use
  std::uint32_t scene_revision = 0;                  // NewScene::revision of the scene that they are for; 0: the first
};

// Checks and computes changes of materials in its own thread, so that the loop that replies to the device only passes on what is ready.
// Logs accepted and rejected changes. RT: request, take and retire yes; the rest set-up only. Threads: one caller, except as noted below.
class MaterialTask {
 public:
  // Called by the task's thread with the materials of each accepted change, once they are ready for take(). After follow() has returned for
  // another scene, it gets no materials of the scene before. Pre: it calls no member of this task.
  using OnTuned = std::function<void(const std::vector<Material>&)>;

  // Only if the stylus holds a rigid tool: returns the tool's text for HapticsSetup::method at this stiffness, N/m.
  using DescribeTool = std::function<HapticsSetup::Text(double stiffness_n_per_m)>;
  MaterialTask(const Scene& scene, double coupling_n_per_m, OnTuned on_tuned = {}, DescribeTool describe_tool = {});
  ~MaterialTask();
  MaterialTask(const MaterialTask&) = delete;
  MaterialTask& operator=(const MaterialTask&) = delete;

  // Requests a change; a later request replaces one that has not started.
  void request(const MaterialRequest& request) noexcept { requests_.publish(request); }

  // To be called when the scene file was read again and differs from the scene in these materials alone: they replace all changes that were
  // requested, and take() returns them like the result of a request. Threads: any. RT: no.
  void follow(const MaterialState& state);
  // To be called when another scene is in use, with the materials of its file. Threads: any. RT: no.
  void follow(const Scene& scene, std::uint32_t revision);

  // All accepted changes of the materials of the scene in use; none: none was accepted. Threads: any. RT: no.
  std::optional<MaterialState> accepted() const;

  // The next result, each once and in order; null: there is none, or the one that was retired last is not freed yet.
  std::unique_ptr<TunedMaterials> take() noexcept;

  // Frees the result in the task's thread: one that take() has returned. Pre: at most once after each result of take().
  void retire(std::unique_ptr<TunedMaterials> result) noexcept { retired_.store(result.release(), std::memory_order_release); }

 private:
  void run();
  void tune(const MaterialRequest& request);
  bool follow_file();
  void add_materials(TunedMaterials& result) const;
  void publish(std::unique_ptr<TunedMaterials> result);
  void free_retired() noexcept { delete retired_.exchange(nullptr, std::memory_order_acq_rel); }

  MaterialTuning tuning_;
  TouchScene scene_;
  double coupling_n_per_m_;
  OnTuned on_tuned_;
  DescribeTool describe_tool_;
  Mailbox<MaterialRequest> requests_;
  std::atomic<TunedMaterials*> result_ = nullptr;
  std::atomic<TunedMaterials*> retired_ = nullptr;
  std::uint32_t last_request_ = 0;  // number of the last request
  std::uint32_t scene_revision_ = 0;
  mutable std::mutex followed_mutex_;  // guards the four members after it
  std::optional<MaterialState> accepted_state_;
  std::optional<MaterialState> followed_state_;                         // from the scene file, not published yet
  std::optional<std::pair<TouchScene, std::uint32_t>> followed_scene_;  // not taken over by the thread yet
  std::optional<MaterialTuning> followed_tuning_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace hapton
