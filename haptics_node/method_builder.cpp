#include "haptics_node/method_builder.h"

#include <chrono>
#include <string>
#include <utility>

#include "haptic_step/haptics_setup.h"
#include "haptic_step/method_text.h"
#include "haptics_node/haptics_report.h"
#include "link/wire_text.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"

namespace hapton {

Result<std::unique_ptr<ForceMethod>> make_built_in(MethodSettings& settings, const TouchScene& scene) {
  return make_method(settings, scene);
}

MethodBuilder::MethodBuilder(MethodSettings settings, TouchScene scene, std::weak_ptr<ForceMethod> in_use, MakeMethod make)
    : make_(std::move(make)),
      settings_(std::move(settings)),
      scene_(std::move(scene)),
      method_in_use_(std::move(in_use)),
      thread_(start_thread([this] { run(); })) {}

MethodBuilder::~MethodBuilder() {
  stop_.store(true);
  thread_.join();
  build_requested_scene();  // so that a caller of rebuild_for() does not wait forever
  free_retired();
  delete built_.load();
}

std::unique_ptr<BuiltMethod> MethodBuilder::take() noexcept {
  // There is one slot for a retired method: no new one is handed out before the old one is collected.
  if (built_.load(std::memory_order_relaxed) == nullptr || retired_.load(std::memory_order_acquire) != nullptr) {
    return nullptr;
  }
  return std::unique_ptr<BuiltMethod>(built_.exchange(nullptr, std::memory_order_acq_rel));
}

void MethodBuilder::run() {
  // Polls instead of waiting: waking a sleeping thread would cost a system call in the real-time loop. The period is a choice.
  constexpr auto kPeriod = std::chrono::milliseconds(10);
  while (!stop_.load()) {
    free_retired();
    build_requested_scene();
    if (requests_.take()) {
      build(requests_.value());
    }
    if (!prepare()) {
      idle_polls_.fetch_add(1, std::memory_order_acq_rel);
      std::this_thread::sleep_for(kPeriod);
    }
  }
}

bool MethodBuilder::prepare() {
  const std::shared_ptr<ForceMethod> method = method_in_use_.lock();
  return method != nullptr && method->prepare();
}

Result<void> MethodBuilder::rebuild_for(std::shared_ptr<const NewScene> scene) {
  std::future<Result<void>> built;
  {
    const std::scoped_lock lock(scene_mutex_);
    next_scene_ = std::move(scene);
    scene_built_ = {};
    built = scene_built_.get_future();
  }
  return built.get();
}

void MethodBuilder::build_requested_scene() {
  std::shared_ptr<const NewScene> scene;
  std::promise<Result<void>> done;
  {
    const std::scoped_lock lock(scene_mutex_);
    if (next_scene_ == nullptr) return;
    scene = std::exchange(next_scene_, nullptr);
    done = std::move(scene_built_);
  }
  done.set_value(build_scene(scene));
}

Result<void> MethodBuilder::build_scene(const std::shared_ptr<const NewScene>& scene) {
  auto ready = std::make_unique<BuiltMethod>();
  std::shared_ptr<ForceMethod> method = scene->keeps_shape ? method_in_use_.lock() : nullptr;
  MethodSettings settings = settings_;
  if (method == nullptr) {
    settings.build_on_approach = false;
    auto made = make_(settings, scene->touch);
    if (!made) return tl::unexpected(made.error());
    if (scene->put_down_serial == 0) log_method(**made);
    method = std::move(*made);
  }
  scene_ = scene->touch;
  method_in_use_ = method;
  ready->step = std::make_unique<TouchStep>(std::move(method), scene->touch);
  put_text(to_text(settings), ready->text);
  ready->scene = scene;
  publish(std::move(ready));
  return {};
}

// Replaces a method that was built and not yet taken, and keeps its scene and the id of its request.
void MethodBuilder::publish(std::unique_ptr<BuiltMethod> ready) {
  const std::unique_ptr<BuiltMethod> before(built_.exchange(nullptr, std::memory_order_acq_rel));
  if (before != nullptr && ready->request_id == 0) ready->request_id = before->request_id;
  if (before != nullptr && ready->scene == nullptr) ready->scene = before->scene;
  built_.store(ready.release(), std::memory_order_release);
}

void MethodBuilder::build(const Request& request) {
  MethodSettings settings = settings_;
  settings.build_on_approach = false;
  settings.name.assign(text_of(request.name));
  auto method = make_(settings, scene_);
  if (!method) {
    log_warning("{}; the current method stays in use", method.error().what);
    rejections_.draft().request_id = request.request_id;
    put_text(method.error().what, rejections_.draft().why);
    rejections_.publish_draft();
    return;
  }
  log_info("built and now in use:");
  log_method(**method);
  auto ready = std::make_unique<BuiltMethod>();
  ready->step = std::make_unique<TouchStep>(std::move(*method), scene_);
  put_text(to_text(settings), ready->text);
  ready->request_id = request.request_id;
  method_in_use_ = ready->step->share_method();
  settings_.name = settings.name;
  publish(std::move(ready));
}

}  // namespace hapton
