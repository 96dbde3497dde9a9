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

// The result of a request: the materials of all objects, or why they stay.
struct TunedMaterials {
  std::vector<Material> materials;            // for ForceMethod::set_materials; empty: rejected
  std::optional<ToolMaterials> of_tool = {};  // where a rigid tool is held
  HapticsSetup::Text tool_method = {};        // then, as HapticsSetup has it
  MaterialState state;                        // its serial is left to who puts them into use
  std::uint32_t scene = 0;                    // NewScene::revision that they are of; 0: the first
};

// Checks and works out changes of materials in its own thread, so that the loop that replies to the device only passes on what is ready.
// An accepted change is logged, a rejected one too. RT: request, take and retire yes; the rest set-up only. Threads: one caller.
class MaterialTask {
 public:
  // Called by its thread with the materials of each accepted change, once they are ready for take(). Not once follow() has returned for
  // another scene than theirs. Pre: it calls nothing of this.
  using OnTuned = std::function<void(const std::vector<Material>&)>;

  // describe_tool: where the stylus holds a rigid tool: what HapticsSetup says of it at this stiffness, N/m.
  using DescribeTool = std::function<HapticsSetup::Text(double stiffness_n_per_m)>;
  MaterialTask(const Scene& scene, double coupling_n_per_m, OnTuned on_tuned = {}, DescribeTool describe_tool = {});
  ~MaterialTask();
  MaterialTask(const MaterialTask&) = delete;
  MaterialTask& operator=(const MaterialTask&) = delete;

  // A later request replaces one that has not started.
  void request(const MaterialRequest& request) noexcept { requests_.publish(request); }

  // The scene file was read again, and differs from the scene in these materials alone: they become the result of no request, in place of
  // all that was requested. Threads: any. RT: no.
  void follow(const MaterialState& state);
  // Another scene is in use, with the materials of its file. Threads: any. RT: no.
  void follow(const Scene& scene, std::uint32_t revision);

  // The changes that are accepted, of the scene in use; none: there are none. Threads: any. RT: no.
  std::optional<MaterialState> accepted() const;

  // The result of the next request, once each, in order; none when there is no new one.
  std::unique_ptr<TunedMaterials> take() noexcept;

  // Takes what take() returned, or one before it, to be freed.
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
  std::uint32_t replied_ = 0;  // request
  std::uint32_t scene_revision_ = 0;
  mutable std::mutex followed_mutex_;  // of all that follows
  std::optional<MaterialState> accepted_;
  std::optional<MaterialState> followed_state_;                         // of the file, not published yet
  std::optional<std::pair<TouchScene, std::uint32_t>> followed_scene_;  // not taken yet
  std::optional<MaterialTuning> followed_tuning_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace hapton
