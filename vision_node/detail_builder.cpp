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
constexpr std::size_t kLargeMeshTriangles = 200'000;
constexpr std::size_t kRoughTriangles = 60'000;
// The first good level of a large mesh has its number of triangles divided by this, and each further level half as many.
constexpr std::size_t kFirstLevelDivisor = 4;
constexpr std::size_t kMinLevelTriangles = 2'000;
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

  bool has_any() const { return total_triangles_ > 0.0; }
  void run();
  void begin();
  void stop();
  std::vector<MadeLevel> take_levels();
  double progress() const { return progress_.load(std::memory_order_relaxed); }

 private:
  void wait_for_begin();
  void build_rough(std::size_t object);
  void build(std::size_t object);
  void offer(MadeLevel made);

  std::vector<std::shared_ptr<const DetailLevel>> full_;
  std::chrono::seconds longest_wait_;
  double total_triangles_ = 0.0;  // triangles of all meshes that get levels
  std::atomic<bool> is_stopping_{false};
  std::atomic<double> progress_{0.0};
  std::mutex mutex_;
  std::condition_variable begin_called_;
  bool has_begun_ = false;
  std::vector<MadeLevel> made_levels_;
};

DetailBuilder::Work::Work(std::vector<std::shared_ptr<const DetailLevel>> full, std::chrono::seconds longest_wait)
    : full_(std::move(full)), longest_wait_(longest_wait) {
  for (const auto& level : full_) {
    if (level->triangles() >= kMinTriangles) total_triangles_ += static_cast<double>(level->triangles());
  }
  if (!has_any()) progress_ = 1.0;
}

std::vector<DetailBuilder::MadeLevel> DetailBuilder::Work::take_levels() {
  const std::lock_guard lock(mutex_);
  return std::exchange(made_levels_, {});
}

void DetailBuilder::Work::offer(MadeLevel made) {
  const std::lock_guard lock(mutex_);
  if (!is_stopping_) made_levels_.push_back(std::move(made));
}

void DetailBuilder::Work::stop() {
  is_stopping_ = true;
  begin();
}

void DetailBuilder::Work::begin() {
  {
    const std::lock_guard lock(mutex_);
    has_begun_ = true;
  }
  begin_called_.notify_one();
}

void DetailBuilder::Work::wait_for_begin() {
  std::unique_lock lock(mutex_);
  begin_called_.wait_for(lock, longest_wait_, [this] { return has_begun_; });
}

void DetailBuilder::Work::run() {
  wait_for_begin();
  // Under Linux this sets the priority of this thread only. If it fails, the thread does the same work.
  (void)setpriority(PRIO_PROCESS, 0, kNiceness);
  for (std::size_t i = 0; i < full_.size() && !is_stopping_; ++i) {
    if (full_[i]->triangles() >= kLargeMeshTriangles) build_rough(i);
  }
  for (std::size_t i = 0; i < full_.size() && !is_stopping_; ++i) {
    if (full_[i]->triangles() >= kMinTriangles) build(i);
  }
  if (!is_stopping_) progress_ = 1.0;
}

void DetailBuilder::Work::build_rough(std::size_t object) {
  const DetailLevel& full = *full_[object];
  // The fast simplification mixes texture positions, and opaque parts with transparent ones.
  if (has_texture_or_alpha(full)) return;
  auto rough = make_rough_level(full, kRoughTriangles);
  if (!rough || is_stopping_) return;
  rough->error = measure_level_error(*rough, full, kErrorSamples);
  divide_into_clusters(*rough);
  offer({.object = object, .level = make_flat(*rough), .is_rough = true});
}

void DetailBuilder::Work::build(std::size_t object) {
  const DetailLevel& full = *full_[object];
  const double begin_progress = progress_;
  const double share = static_cast<double>(full.triangles()) / total_triangles_;
  const DetailLevel* finer = &full;
  DetailLevel last;
  std::size_t target_triangles = full.triangles() / (full.triangles() >= kLargeMeshTriangles ? kFirstLevelDivisor : 2);
  for (; target_triangles >= kMinLevelTriangles && !is_stopping_; target_triangles /= 2) {
    auto level = make_coarser_level(*finer, target_triangles);
    if (!level || is_stopping_) break;
    level->error = measure_level_error(*level, full, kErrorSamples);
    last = std::move(*level);
    finer = &last;
    DetailLevel divided = last;
    divide_into_clusters(divided);
    offer({.object = object, .level = make_flat(divided)});
    progress_ = begin_progress + share * (0.7 - 0.7 * static_cast<double>(target_triangles) / static_cast<double>(full.triangles()));
  }
  if (is_stopping_) return;
  DetailLevel divided = full;
  divide_into_clusters(divided);
  offer({.object = object, .level = make_flat(divided), .is_full = true});
  progress_ = begin_progress + share;
}

DetailBuilder::DetailBuilder(std::vector<std::shared_ptr<const DetailLevel>> full, std::chrono::seconds longest_wait)
    : work_(std::make_shared<Work>(std::move(full), longest_wait)) {
  // Nobody waits for this thread to end: a level of ten million triangles takes many seconds, and meshoptimizer cannot be interrupted.
  if (work_->has_any()) start_thread([work = work_] { work->run(); }).detach();
}

DetailBuilder::~DetailBuilder() { work_->stop(); }

std::vector<DetailBuilder::MadeLevel> DetailBuilder::take_levels() { return work_->take_levels(); }
void DetailBuilder::begin() { work_->begin(); }
double DetailBuilder::progress() const { return work_->progress(); }

}  // namespace hapton
