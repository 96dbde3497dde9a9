#include "vision_node/detail_builder.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "runtime/start_thread.h"

namespace hapton {
namespace {

// Of a mesh with more triangles a rough level is made first: it takes a tenth of the time of a good one.
constexpr std::size_t kLarge = 200'000;
constexpr std::size_t kRoughTriangles = 60'000;
// The first good level of a large mesh; each further one has half as many triangles as the one before.
constexpr std::size_t kFirstOfLarge = 4;
constexpr std::size_t kCoarsest = 2'000;
constexpr std::size_t kErrorSamples = 4'000;
// The servo loop and the haptics node may live on the same cores.
constexpr int kNiceness = 10;
constexpr std::chrono::seconds kLongestWait(1);

bool has_texture_or_alpha(const DetailLevel& level) {
  return std::any_of(level.paints.begin(), level.paints.end(),
                     [](const VertexPaint& paint) { return paint.layer > 0 || !paint.is_plain(); });
}

}  // namespace

DetailBuilder::DetailBuilder(std::vector<const DetailLevel*> full) : full_(std::move(full)) {
  for (const DetailLevel* level : full_) {
    if (level->triangles() >= kLeastTriangles) total_ += static_cast<double>(level->triangles());
  }
  if (total_ == 0.0) {
    progress_ = 1.0;
    return;
  }
  thread_ = start_thread([this] { run(); });
}

DetailBuilder::~DetailBuilder() {
  stop_ = true;
  begin();
  if (thread_.joinable()) thread_.join();
}

std::vector<DetailBuilder::Made> DetailBuilder::take_made() {
  const std::lock_guard lock(mutex_);
  return std::exchange(made_, {});
}

void DetailBuilder::offer(Made made) {
  const std::lock_guard lock(mutex_);
  made_.push_back(std::move(made));
}

void DetailBuilder::begin() {
  {
    const std::lock_guard lock(mutex_);
    has_begun_ = true;
  }
  begun_.notify_one();
}

void DetailBuilder::wait_for_begin() {
  std::unique_lock lock(mutex_);
  begun_.wait_for(lock, kLongestWait, [this] { return has_begun_; });
}

void DetailBuilder::run() {
  wait_for_begin();
  // Of this thread alone, as Linux has it. If it fails, the work is the same.
  (void)setpriority(PRIO_PROCESS, 0, kNiceness);
  for (std::size_t i = 0; i < full_.size() && !stop_; ++i) {
    if (full_[i]->triangles() < kLeastTriangles || full_[i]->triangles() < kLarge) continue;
    // The fast simplification mixes positions of a texture, and the opaque with the rest.
    if (has_texture_or_alpha(*full_[i])) continue;
    if (auto rough = make_rough_level(*full_[i], kRoughTriangles)) {
      rough->error = measure_level_error(*rough, *full_[i], kErrorSamples);
      divide_into_clusters(*rough);
      offer({.object = i, .level = make_flat(*rough), .is_rough = true});
    }
  }
  for (std::size_t i = 0; i < full_.size() && !stop_; ++i) {
    if (full_[i]->triangles() >= kLeastTriangles) build(i);
  }
  if (!stop_) progress_ = 1.0;
}

void DetailBuilder::build(std::size_t object) {
  const DetailLevel& full = *full_[object];
  const double begin = progress_;
  const double share = static_cast<double>(full.triangles()) / total_;
  const DetailLevel* finer = &full;
  DetailLevel last;
  std::size_t wanted = full.triangles() / (full.triangles() >= kLarge ? kFirstOfLarge : 2);
  for (; wanted >= kCoarsest && !stop_; wanted /= 2) {
    auto level = make_coarser_level(*finer, wanted);
    if (!level) break;
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

}  // namespace hapton
