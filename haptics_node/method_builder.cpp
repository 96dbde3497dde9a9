#include "haptics_node/method_builder.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "haptic_step/haptics_setup.h"
#include "haptic_step/method_text.h"
#include "haptics_node/haptics_report.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"

namespace hapton {

MethodBuilder::MethodBuilder(MethodSettings settings, TouchScene scene, std::weak_ptr<ForceMethod> in_use)
    : settings_(std::move(settings)), scene_(std::move(scene)), in_use_(std::move(in_use)), thread_(start_thread([this] { run(); })) {}

MethodBuilder::~MethodBuilder() {
  stop_.store(true);
  thread_.join();
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
  // Polls instead of waiting: waking a sleeping thread would be a system call in the real-time loop.
  constexpr auto kPeriod = std::chrono::milliseconds(10);
  while (!stop_.load()) {
    free_retired();
    if (requests_.take()) {
      build(requests_.value());
    }
    if (!prepare()) {
      idle_looks_.fetch_add(1, std::memory_order_acq_rel);
      std::this_thread::sleep_for(kPeriod);
    }
  }
}

bool MethodBuilder::prepare() {
  const std::shared_ptr<ForceMethod> method = in_use_.lock();
  return method != nullptr && method->prepare();
}

void MethodBuilder::build(const Request& request) {
  MethodSettings settings = settings_;
  settings.build_on_approach = false;
  settings.name.assign(request.name.data(), std::find(request.name.begin(), request.name.end(), '\0') - request.name.begin());
  auto method = make_method(settings, scene_);
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
  in_use_ = ready->step->share_method();
  delete built_.exchange(ready.release(), std::memory_order_acq_rel);
}

}  // namespace hapton
