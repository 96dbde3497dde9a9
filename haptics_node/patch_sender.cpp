#include "haptics_node/patch_sender.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/math/rigid_pose.h"
#include "runtime/clock.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

constexpr std::int64_t kWantedNs = kNanosecondsPerSecond;  // after the last status that says so
constexpr auto kIdleLookEvery = std::chrono::milliseconds(50);
constexpr auto kLookEvery = std::chrono::milliseconds(4);
constexpr double kVelocityS = 0.1;  // over which the hand's velocity is a mean

std::string_view find_scene_obstacle(const TouchScene& scene) {
  if (scene.has_effects()) return "the scene has effects";
  if (scene.has_sculpt()) return "objects of the scene can be carved";
  return scene.has_motion() ? "objects of the scene move" : "";
}

}  // namespace

// Smooth normals are not among the parts yet.
bool PatchSender::can_offer(std::string_view method_text) noexcept {
  method_text = method_text.substr(0, method_text.find('\0'));
  if (method_text.find(" effects=") != std::string_view::npos) return false;
  return method_text.find("name=proxy") != std::string_view::npos && method_text.find("shading=") == std::string_view::npos;
}

PatchSender::PatchSender(TouchScene scene, double probe_radius_m, std::uint64_t scene_hash, bool is_offered,
                         const PatchSource::Options& options)
    : scene_(std::move(scene)),
      scene_obstacle_(find_scene_obstacle(scene_)),
      probe_radius_m_(probe_radius_m),
      scene_hash_(scene_hash),
      options_(options),
      is_offered_(is_offered && scene_obstacle_.empty()),
      thread_(start_thread([this] { run(); })) {}

PatchSender::~PatchSender() {
  stop_.store(true);
  thread_.join();
}

void PatchSender::accept(const PatchStatus& status, std::int64_t now_ns) noexcept {
  wanted_until_ns_ = status.is_wanted ? now_ns + kWantedNs : 0;
  statuses_.publish({status, now_ns});
}

void PatchSender::note_hand(const DeviceState& state, const std::array<float, 12>& X_WS) noexcept {
  hands_.publish({state.p_WD, state.sample_time_ns, X_WS});
}

void PatchSender::run() {
  const SteadyClock clock;
  std::int64_t wanted_until_ns = 0;
  while (!stop_.load()) {
    const std::int64_t now_ns = clock.now_ns();
    const bool has_status = statuses_.take();
    if (has_status) {
      const auto& [status, time_ns] = statuses_.value();
      wanted_until_ns = status.is_wanted ? time_ns + kWantedNs : 0;
      if (source_) source_->accept(status);
    }
    follow_materials();
    if (now_ns < wanted_until_ns) {
      follow_method();
      if (hands_.take()) follow_hand(hands_.value());
      if (fill(now_ns) || has_status) counts_.publish(source_->counts());
    }
    std::this_thread::sleep_for(now_ns < wanted_until_ns ? kLookEvery : kIdleLookEvery);
  }
}

void PatchSender::set_materials(const std::vector<Material>& materials) {
  const std::scoped_lock lock(materials_mutex_);
  materials_ = materials;
}

// A tile has the material of its object, and what a part says holds within its epoch: the next one begins without parts.
void PatchSender::follow_materials() {
  std::vector<Material> materials;
  {
    const std::scoped_lock lock(materials_mutex_);
    materials.swap(materials_);
  }
  for (std::size_t o = 0; o < std::min(materials.size(), scene_.objects.size()); ++o) scene_.objects[o].material = materials[o];
  if (materials.empty()) return;
  tiles_.reset();
  source_.reset();
}

// With a method that parts of the scene do not serve the hub gets an epoch without any.
void PatchSender::follow_method() {
  const bool is_offered = is_offered_.load(std::memory_order_acquire);
  if (source_ && is_offered == was_offered_) return;
  was_offered_ = is_offered;
  if (!tiles_) {
    tiles_ = std::make_unique<TiledScene>(make_tiles(scene_));
    log_info("the hub requests the scene in parts: {} tiles in {} cells, at most {:g} Mbit/s", tiles_->tiles.size(), tiles_->cells.size(),
             1e-6 * options_.bits_per_s);
  }
  TiledScene offered = is_offered ? *tiles_ : TiledScene{.grid = tiles_->grid, .tiles = {}, .tile_bounds = {}, .nodes = {}, .cells = {}};
  source_ = std::make_unique<PatchSource>(std::move(offered), probe_radius_m_, scene_hash_, ++epoch_, options_);
}

void PatchSender::follow_hand(const Hand& hand) {
  const auto X_WS = find_rigid_pose(hand.X_WS);
  if (!X_WS) return;
  const Vec3 p_SD = X_WS->inverse(Eigen::Isometry) * hand.p_WD;
  const double dt_s = 1e-9 * static_cast<double>(hand.time_ns - std::exchange(hand_ns_, hand.time_ns));
  const Vec3 moved = p_SD - std::exchange(motion_.p_SD, p_SD);
  if (dt_s > 0.0 && dt_s < 1.0) motion_.v_SD += std::min(dt_s / kVelocityS, 1.0) * (moved / dt_s - motion_.v_SD);
  source_->aim(motion_);
}

bool PatchSender::fill(std::int64_t now_ns) {
  const std::size_t first = end_.load(std::memory_order_relaxed);
  std::size_t end = first;
  while (end - begin_.load(std::memory_order_acquire) < kRing) {
    auto part = source_->take(now_ns);
    if (!part) break;
    ring_[end % kRing] = *part;
    end_.store(++end, std::memory_order_release);
  }
  return end != first;
}

}  // namespace hapton
