#include "vision_node/detail_builder.h"

#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

#include "runtime/start_thread.h"

namespace hapton {
namespace {

// For a mesh with so many triangles or more a rough level is made first, in a tenth of the time that a good one takes.
constexpr std::size_t kLarge = 200'000;
constexpr std::size_t kRoughTriangles = 60'000;
// The first good level of a large mesh has its number of triangles divided by this, and each further level half as many.
constexpr std::size_t kFirstOfLarge = 4;
constexpr std::size_t kCoarsest = 2'000;
constexpr std::size_t kErrorSamples = 4'000;
// A low priority, because the servo loop and the haptics node may run on the same cores.
constexpr int kNiceness = 10;

bool has_texture_or_alpha(const DetailLevel& level) {
  return std::any_of(level.paints.begin(), level.paints.end(),
                     [](const VertexPaint& paint) { return paint.layer > 0 || !paint.is_plain(); });
}

}  // namespace

class DetailBuilder::Work {
 public:
  Work(std::vector<std::shared_ptr<const DetailLevel>> full, std::chrono::seconds longest_wait);

  bool has_any() const { return total_ > 0.0; }
  void run();
  void begin();
  void stop();
  std::vector<Made> take_made();
  double progress() const { return progress_.load(std::memory_order_relaxed); }

 private:
  void wait_for_begin();
  void build_rough(std::size_t object);
  void build(std::size_t object);
  void offer(Made made);

  std::vector<std::shared_ptr<const DetailLevel>> full_;
  std::chrono::seconds longest_wait_;
  double total_ = 0.0;  // triangles of all meshes that get levels
  std::atomic<bool> stop_{false};
  std::atomic<double> progress_{0.0};
  std::mutex mutex_;
  std::condition_variable begun_;
  bool has_begun_ = false;
  std::vector<Made> made_;
};

DetailBuilder::Work::Work(std::vector<std::shared_ptr<const DetailLevel>> full, std::chrono::seconds longest_wait)
    : full_(std::move(full)), longest_wait_(longest_wait) {
  for (const auto& level : full_) {
    if (level->triangles() >= kMinTriangles) total_ += static_cast<double>(level->triangles());
  }
  if (!has_any()) progress_ = 1.0;
}

std::vector<DetailBuilder::Made> DetailBuilder::Work::take_made() {
  const std::lock_guard lock(mutex_);
  return std::exchange(made_, {});
}

void DetailBuilder::Work::offer(Made made) {
  const std::lock_guard lock(mutex_);
  if (!stop_) made_.push_back(std::move(made));
}

void DetailBuilder::Work::stop() {
  stop_ = true;
  begin();
}

void DetailBuilder::Work::begin() {
  {
    const std::lock_guard lock(mutex_);
    has_begun_ = true;
  }
  begun_.notify_one();
}

void DetailBuilder::Work::wait_for_begin() {
  std::unique_lock lock(mutex_);
  begun_.wait_for(lock, longest_wait_, [this] { return has_begun_; });
}

void DetailBuilder::Work::run() {
  wait_for_begin();
  // Under Linux this sets the priority of this thread only. If it fails, the thread does the same work.
  (void)setpriority(PRIO_PROCESS, 0, kNiceness);
  for (std::size_t i = 0; i < full_.size() && !stop_; ++i) {
    if (full_[i]->triangles() >= kLarge) build_rough(i);
  }
  for (std::size_t i = 0; i < full_.size() && !stop_; ++i) {
    if (full_[i]->triangles() >= kMinTriangles) build(i);
  }
  if (!stop_) progress_ = 1.0;
}

void DetailBuilder::Work::build_rough(std::size_t object) {
  const DetailLevel& full = *full_[object];
  // The fast simplification mixes texture positions, and opaque parts with transparent ones.
  if (has_texture_or_alpha(full)) return;
  auto rough = make_rough_level(full, kRoughTriangles);
  if (!rough || stop_) return;
  rough->error = measure_level_error(*rough, full, kErrorSamples);
  divide_into_clusters(*rough);
  offer({.object = object, .level = make_flat(*rough), .is_rough = true});
}

void DetailBuilder::Work::build(std::size_t object) {
  const DetailLevel& full = *full_[object];
  const double begin = progress_;
  const double share = static_cast<double>(full.triangles()) / total_;
  const DetailLevel* finer = &full;
  DetailLevel last;
  std::size_t wanted = full.triangles() / (full.triangles() >= kLarge ? kFirstOfLarge : 2);
  for (; wanted >= kCoarsest && !stop_; wanted /= 2) {
    auto level = make_coarser_level(*finer, wanted);
    if (!level || stop_) break;
    level->error = measure_level_error(*level, full, kErrorSamples);
    last = std::move(*level);
    finer = &last;
    DetailLevel divided = last;
    divide_into_clusters(divided);
    offer({.object = object, .level = make_flat(divided)});
    progress_ = begin + share * (0.7 - 0.7 * static_cast<double>(wanted) / static_cast<double>(full.triangles()));
  }
  if (stop_) return;
  DetailLevel divided = full;
  divide_into_clusters(divided);
  offer({.object = object, .level = make_flat(divided), .is_full = true});
  progress_ = begin + share;
}

DetailBuilder::DetailBuilder(std::vector<std::shared_ptr<const DetailLevel>> full, std::chrono::seconds longest_wait)
    : work_(std::make_shared<Work>(std::move(full), longest_wait)) {
  // Nobody waits for this thread to end: a level of ten million triangles takes many seconds, and meshoptimizer cannot be interrupted.
  if (work_->has_any()) start_thread([work = work_] { work->run(); }).detach();
}

DetailBuilder::~DetailBuilder() { work_->stop(); }

std::vector<DetailBuilder::Made> DetailBuilder::take_made() { return work_->take_made(); }
void DetailBuilder::begin() { work_->begin(); }
double DetailBuilder::progress() const { return work_->progress(); }

}  // namespace hapton
