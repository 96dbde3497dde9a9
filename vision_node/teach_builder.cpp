#include "vision_node/teach_builder.h"

#include <sys/resource.h>

#include <condition_variable>
#include <mutex>
#include <utility>

#include "runtime/start_thread.h"

namespace hapton {
namespace {

constexpr int kTeachNiceness = 10;  // as for levels of detail: the nodes and the drawing of frames have priority

TeachShapes make_notice(std::string text) {
  TeachShapes nothing;
  nothing.caption = std::move(text);
  return nothing;
}

}  // namespace

class TeachBuilder::Work {
 public:
  explicit Work(TouchScene scene) : scene_(std::move(scene)) {}

  void run();
  void stop();
  void request(const TeachChoice& choice, const TeachProbe& probe);
  bool is_busy();
  std::optional<TeachShapes> take_shapes();
  int tree_depth();

 private:
  struct Request {
    TeachChoice choice;
    TeachProbe probe;
  };
  TeachShapes make(const Request& request);
  TeachShapes make_of_tree(const Request& request);

  TouchScene scene_;
  // Used only by the thread, which makes each of them when it first needs it.
  std::unique_ptr<SmoothScene> smooth_;
  std::unique_ptr<UniformGrid> grid_;
  std::unique_ptr<TeachCurvature> curvature_;

  std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<Request> request_;
  std::optional<TeachShapes> made_shapes_;
  bool is_working_ = false;
  bool is_stopping_ = false;
  int tree_depth_ = 0;
};

void TeachBuilder::Work::stop() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  wake_.notify_one();
}

void TeachBuilder::Work::request(const TeachChoice& choice, const TeachProbe& probe) {
  {
    const std::lock_guard lock(mutex_);
    request_ = Request{choice, probe};
  }
  wake_.notify_one();
}

bool TeachBuilder::Work::is_busy() {
  const std::lock_guard lock(mutex_);
  return is_working_ || request_.has_value();
}

std::optional<TeachShapes> TeachBuilder::Work::take_shapes() {
  const std::lock_guard lock(mutex_);
  return std::exchange(made_shapes_, std::nullopt);
}

int TeachBuilder::Work::tree_depth() {
  const std::lock_guard lock(mutex_);
  return tree_depth_;
}

void TeachBuilder::Work::run() {
  // For this thread only: the computation of forces gets the processor first.
  (void)setpriority(PRIO_PROCESS, 0, kTeachNiceness);
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return is_stopping_ || request_; });
    if (is_stopping_) return;
    const Request request = *std::exchange(request_, std::nullopt);
    is_working_ = true;
    lock.unlock();
    TeachShapes shapes = make(request);
    shapes.choice = request.choice;
    lock.lock();
    is_working_ = false;
    made_shapes_ = std::move(shapes);
    if (smooth_ != nullptr) tree_depth_ = smooth_->tree_stats().depth;
  }
}

TeachShapes TeachBuilder::Work::make(const Request& request) {
  if (request.choice.view == TeachView::grid) {
    if (grid_ == nullptr) {
      auto grid = make_teach_grid(scene_);
      if (!grid) return make_notice("grid: " + grid.error().what);
      grid_ = std::make_unique<UniformGrid>(std::move(*grid));
    }
    return make_grid_shapes(*grid_, request.probe);
  }
  if (request.choice.view == TeachView::curvature) {
    if (curvature_ == nullptr) curvature_ = std::make_unique<TeachCurvature>(find_curvature(scene_));
    return make_curvature_shapes(scene_, *curvature_, request.probe);
  }
  return make_of_tree(request);
}

TeachShapes TeachBuilder::Work::make_of_tree(const Request& request) {
  if (smooth_ == nullptr) {
    auto built = SmoothScene::build(scene_, {});
    if (!built) return make_notice(std::string(teach_name(request.choice.view)) + ": " + built.error().what);
    smooth_ = std::make_unique<SmoothScene>(std::move(*built));
  }
  if (request.choice.view == TeachView::contact) return make_contact_shapes(*smooth_, request.probe);
  if (request.choice.view == TeachView::tree) return make_tree_shapes(*smooth_, request.probe, request.choice.level);
  return make_local_set_shapes(*smooth_, request.probe);
}

TeachBuilder::TeachBuilder(TouchScene scene) : work_(std::make_shared<Work>(std::move(scene))) {}

TeachBuilder::~TeachBuilder() { work_->stop(); }

void TeachBuilder::request(const TeachChoice& choice, const TeachProbe& probe) {
  work_->request(choice, probe);
  // Preparing a large scene takes seconds and cannot be interrupted. The thread is detached, so quitting does not wait for it.
  if (!std::exchange(is_started_, true)) start_thread([work = work_] { work->run(); }).detach();
}

bool TeachBuilder::is_busy() { return work_->is_busy(); }
std::optional<TeachShapes> TeachBuilder::take_shapes() { return work_->take_shapes(); }
int TeachBuilder::tree_depth() { return work_->tree_depth(); }

}  // namespace hapton
