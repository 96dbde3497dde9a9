#include "vision_node/teach_builder.h"

#include <sys/resource.h>

#include <utility>

#include "runtime/start_thread.h"

namespace hapton {
namespace {

constexpr int kTeachNiceness = 10;

TeachShapes make_notice(std::string text) {
  TeachShapes nothing;
  nothing.caption = std::move(text);
  return nothing;
}

}  // namespace

TeachBuilder::TeachBuilder(TouchScene scene) : scene_(std::move(scene)) {}

TeachBuilder::~TeachBuilder() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void TeachBuilder::request(const TeachChoice& choice, const TeachProbe& probe) {
  {
    const std::lock_guard lock(mutex_);
    request_ = Request{choice, probe};
  }
  if (!thread_.joinable()) thread_ = start_thread([this] { run(); });
  wake_.notify_one();
}

bool TeachBuilder::is_busy() {
  const std::lock_guard lock(mutex_);
  return is_working_ || request_.has_value();
}

std::optional<TeachShapes> TeachBuilder::take_made() {
  const std::lock_guard lock(mutex_);
  return std::exchange(made_, std::nullopt);
}

int TeachBuilder::tree_depth() {
  const std::lock_guard lock(mutex_);
  return depth_;
}

void TeachBuilder::run() {
  // Of this thread alone: a force has the processor first.
  (void)setpriority(PRIO_PROCESS, 0, kTeachNiceness);
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return stop_ || request_; });
    if (stop_) return;
    const Request request = *std::exchange(request_, std::nullopt);
    is_working_ = true;
    lock.unlock();
    TeachShapes shapes = make(request);
    shapes.choice = request.choice;
    lock.lock();
    is_working_ = false;
    made_ = std::move(shapes);
    if (smooth_ != nullptr) depth_ = smooth_->tree_stats().depth;
  }
}

TeachShapes TeachBuilder::make(const Request& request) {
  if (request.choice.view == TeachView::grid) {
    if (grid_ == nullptr) {
      auto grid = make_teach_grid(scene_);
      if (!grid) return make_notice("grid: " + grid.error().what);
      grid_ = std::make_unique<UniformGrid>(std::move(*grid));
    }
    return show_grid(*grid_, request.probe);
  }
  if (request.choice.view == TeachView::curvature) {
    if (curvature_ == nullptr) curvature_ = std::make_unique<TeachCurvature>(find_curvature(scene_));
    return show_curvature(scene_, *curvature_, request.probe);
  }
  return make_of_tree(request);
}

TeachShapes TeachBuilder::make_of_tree(const Request& request) {
  if (smooth_ == nullptr) {
    auto built = SmoothScene::build(scene_, {});
    if (!built) return make_notice(std::string(teach_name(request.choice.view)) + ": " + built.error().what);
    smooth_ = std::make_unique<SmoothScene>(std::move(*built));
  }
  if (request.choice.view == TeachView::contact) return show_contact(*smooth_, request.probe);
  if (request.choice.view == TeachView::tree) return show_tree(*smooth_, request.probe, request.choice.level);
  return show_local_set(*smooth_, request.probe);
}

}  // namespace hapton
