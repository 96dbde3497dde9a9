#include "haptics_node/material_task.h"

#include <chrono>
#include <utility>

#include "core/force/virtual_coupling.h"
#include "haptic_step/haptics_setup.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"
#include "scene/scene_file.h"
#include "scene/tool_obstacles.h"

namespace hapton {

MaterialTask::MaterialTask(const Scene& scene, double coupling_n_per_m, OnTuned on_tuned, DescribeTool describe_tool)
    : tuning_(scene),
      scene_(scene.touch_scene()),
      coupling_n_per_m_(coupling_n_per_m),
      on_tuned_(std::move(on_tuned)),
      describe_tool_(std::move(describe_tool)),
      thread_(start_thread([this] { run(); })) {}

MaterialTask::~MaterialTask() {
  stop_.store(true);
  thread_.join();
  free_retired();
  delete result_.load();
}

std::unique_ptr<TunedMaterials> MaterialTask::take() noexcept {
  // There is one slot for a retired result: no new result is handed out before the slot is empty.
  if (result_.load(std::memory_order_relaxed) == nullptr || retired_.load(std::memory_order_acquire) != nullptr) return nullptr;
  return std::unique_ptr<TunedMaterials>(result_.exchange(nullptr, std::memory_order_acq_rel));
}

void MaterialTask::run() {
  // Polls instead of waiting: waking a sleeping thread would be a system call in the real-time loop.
  constexpr auto kPeriod = std::chrono::milliseconds(10);
  while (!stop_.load()) {
    free_retired();
    // A result must not replace one that was not taken: an accepted change would be lost.
    if (result_.load(std::memory_order_acquire) == nullptr && !follow_file() && requests_.take()) tune(requests_.value());
    std::this_thread::sleep_for(kPeriod);
  }
}

void MaterialTask::follow(const MaterialState& state) {
  const std::scoped_lock lock(followed_mutex_);
  followed_state_ = state;
}

void MaterialTask::follow(const Scene& scene, std::uint32_t revision) {
  const std::scoped_lock lock(followed_mutex_);
  followed_state_.reset();
  accepted_state_.reset();
  followed_scene_.emplace(scene.touch_scene(), revision);
  followed_tuning_.emplace(scene);
}

// True: a result was published.
bool MaterialTask::follow_file() {
  std::optional<MaterialState> state;
  {
    const std::scoped_lock lock(followed_mutex_);
    if (followed_scene_) {
      scene_ = std::move(followed_scene_->first);
      scene_revision_ = followed_scene_->second;
      tuning_ = std::move(*followed_tuning_);
      followed_scene_.reset();
      followed_tuning_.reset();
    }
    state = std::exchange(followed_state_, std::nullopt);
  }
  if (!state) return false;
  tuning_.reset_to(*state);
  auto result = std::make_unique<TunedMaterials>();
  result->state = tuning_.state();
  result->state.request = last_request_;
  add_materials(*result);
  publish(std::move(result));
  return true;
}

std::optional<MaterialState> MaterialTask::accepted() const {
  const std::scoped_lock lock(followed_mutex_);
  return accepted_state_;
}

void MaterialTask::add_materials(TunedMaterials& result) const {
  result.materials = tuned_materials(scene_, tuning_.state(), coupling_n_per_m_);
  if (!describe_tool_) return;
  TouchScene tuned = scene_;
  const std::vector<Material> uncoupled = tuned_materials(scene_, tuning_.state(), 0.0);
  for (std::size_t o = 0; o < uncoupled.size(); ++o) tuned.objects[o].material = uncoupled[o];
  ToolObstacles obstacles = make_tool_obstacles(couple_scene(std::move(tuned), coupling_n_per_m_));
  result.tool_materials = {obstacles.stiffness_n_per_m, std::move(obstacles.friction), std::move(obstacles.damping)};
  result.tool_method = describe_tool_(obstacles.stiffness_n_per_m);
}

void MaterialTask::publish(std::unique_ptr<TunedMaterials> result) {
  result->scene_revision = scene_revision_;
  if (!result->materials.empty()) {
    const std::scoped_lock lock(followed_mutex_);
    if (!followed_scene_) accepted_state_ = result->state;  // else they are of a scene that is no longer in use
  }
  const std::vector<Material> materials = result->materials;
  result_.store(result.release(), std::memory_order_release);  // before on_tuned_, which may take a while
  if (materials.empty() || !on_tuned_) return;
  // Called under the lock: after follow() has returned for another scene, on_tuned_ gets no materials of the scene before.
  const std::scoped_lock lock(followed_mutex_);
  if (!followed_scene_) on_tuned_(materials);
}

void MaterialTask::tune(const MaterialRequest& request) {
  auto result = std::make_unique<TunedMaterials>();
  const auto changed = tuning_.change(request);
  result->state = tuning_.state();
  result->state.request = last_request_ = request.request;
  if (changed) {
    add_materials(*result);
    log_info("{}", tuning_.describe_last());
  } else {
    log_warning("{}; no material is changed", changed.error().what);
    put_text(changed.error().what, result->state.rejection);
  }
  publish(std::move(result));
}

}  // namespace hapton
