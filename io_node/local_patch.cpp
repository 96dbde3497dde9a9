#include "io_node/local_patch.h"

#include <algorithm>
#include <utility>

#include "core/math/contact_resumption.h"

namespace hapton {
namespace {

// The time step of the first sample, before which there was no other: a cycle at 1 kHz is assumed.
constexpr double kFirstStepS = 1e-3;
// A longer gap between two samples counts as this. A free choice.
constexpr double kLongestStepS = 0.02;
constexpr std::uint32_t kNoGeneration = 0xFFFFFFFF;

}  // namespace

LocalPatch::~LocalPatch() {
  free_retired();
  for (std::atomic<Patch*>& built : offered_patches_) exchange(built, nullptr);
  for (std::atomic<PatchShape*>& stage : stages_) exchange(stage, nullptr);
  exchange(bodies_, nullptr);
  exchange(materials_, nullptr);
}

// Nothing is freed here: a patch that is not needed any more goes into the link's `retired_patches_` slot, which another thread empties.
// Until then no new patch is taken.
void LocalPatch::exchange_patch(std::size_t link) noexcept {
  if (retired_patches_[link].load(std::memory_order_acquire) != nullptr) return;
  if (auto retired = touch_.take_retired(link)) {
    retired_patches_[link].store(retired.release(), std::memory_order_release);
  } else if (offered_patches_[link].load(std::memory_order_relaxed) != nullptr) {
    auto superseded = touch_.offer(link, std::unique_ptr<Patch>(offered_patches_[link].exchange(nullptr, std::memory_order_acq_rel)));
    retired_patches_[link].store(superseded.release(), std::memory_order_release);
  }
}

// A stage that was taken, or whose patch is gone, goes into the link's `retired_stages_` slot in the same way.
void LocalPatch::exchange_stage(std::size_t link) noexcept {
  PatchShape* const stage = stages_[link].load(std::memory_order_acquire);
  if (stage == nullptr || retired_stages_[link].load(std::memory_order_acquire) != nullptr || !touch_.take(link, *stage)) return;
  stages_[link].store(nullptr, std::memory_order_release);
  retired_stages_[link].store(stage, std::memory_order_release);
}

// Takes what is offered, if anything is. False: the offer has to wait, because the slot for what it replaces is still full.
template <class T>
bool LocalPatch::take_over(std::atomic<T*>& offered, std::atomic<T*>& retired) noexcept {
  if (offered.load(std::memory_order_relaxed) == nullptr) return true;
  if (retired.load(std::memory_order_acquire) != nullptr) return false;
  auto replaced = touch_.take(std::unique_ptr<T>(offered.exchange(nullptr, std::memory_order_acq_rel)));
  retired.store(replaced.release(), std::memory_order_release);
  return true;
}

// Bodies last: they are offered before their patches, so a step that gets a patch gets its bodies too.
void LocalPatch::exchange_patches() noexcept {
  for (std::size_t link = 0; link < kLinks; ++link) {
    exchange_patch(link);
    if (touch_.is_in_use(link)) exchange_stage(link);
  }
  (void)take_over(materials_, retired_materials_);
  const PatchChain& known = touch_;
  const bool had_moves = moves_.take();
  const bool were_offered = bodies_.load(std::memory_order_acquire) != nullptr;
  are_bodies_awaited_ = !take_over(bodies_, retired_bodies_);
  if ((had_moves || were_offered) && !are_bodies_awaited_ && known.body_count() > 1) touch_.note_moves(moves_.value());
}

std::int64_t LocalPatch::scene_time_of(const DeviceSample& sample, std::int64_t passed_ns) noexcept {
  const PatchOrders& orders = orders_.value();
  if (!touch_.has_arrived()) return std::max<std::int64_t>(orders.remote_force_scene_ns + (sample.time_ns - orders.remote_force_ns), 0);
  const bool is_given = sample.time_ns < orders.until_ns;
  return scene_time_ns_ + (is_given ? std::clamp<std::int64_t>(passed_ns, 0, kMaxSceneStepNs) : 0);
}

std::optional<LocalForce> LocalPatch::step(const DeviceSample& sample) noexcept {
  orders_.take();
  const PatchOrders& orders = orders_.value();
  if (!orders.is_wanted) {
    if (touch_.is_placed()) touch_.forget();
    return std::nullopt;
  }
  exchange_patches();
  // A device whose path is not known may have gone around an object: the proxy must not follow it in a straight line.
  if (sample.p_WD.allFinite()) {
    if (touch_.is_placed() && !is_path_known(last_p_WD_, sample.p_WD, sample.time_ns - last_ns_)) touch_.forget();
    last_p_WD_ = sample.p_WD;
  }
  // Just after another haptics node has joined, the patches here are still those of the previous one, until the patch thread has cleared
  // them.
  const bool is_cleared = clear_count_.load(std::memory_order_acquire) == orders.clear_count;
  touch_.set_generation(is_cleared && orders.may_begin ? generation_.load(std::memory_order_acquire) : kNoGeneration);
  const Pose X_SW = orders.X_WS.inverse(Eigen::Isometry);
  if (std::exchange(handled_start_, orders.start_serial) != orders.start_serial && !touch_.has_arrived()) {
    touch_.start_at(X_SW * orders.p_WP, X_SW.linear() * orders.outward_W, 1e-9 * static_cast<double>(last_ns_ - orders.start_ns),
                    1e-9 * static_cast<double>(orders.start_scene_ns));
  }
  const std::int64_t passed_ns = sample.time_ns - std::exchange(last_ns_, sample.time_ns);
  const double dt_s = passed_ns > 0 ? std::min(1e-9 * static_cast<double>(passed_ns), kLongestStepS) : kFirstStepS;
  scene_time_ns_ = scene_time_of(sample, passed_ns);
  const TouchInput input{.p_WD = sample.p_WD,
                         .X_WS = orders.X_WS,
                         .dt_s = dt_s,
                         .buttons = sample.buttons,
                         .time_s = 1e-9 * static_cast<double>(scene_time_ns_)};
  const std::optional<PatchOutput> output = touch_.step(input);
  counts_.publish(touch_.counts());
  touch_.for_each_link([&](std::size_t link) {
    if (touch_.is_in_use(link)) hands_[link].publish(touch_.hand_of(link, sample.time_ns, scene_time_ns_));
  });
  // The proxy has followed the device even if no force is returned, so that it is on the same surface once the haptics node replies again.
  if (!output || are_bodies_awaited_ || sample.time_ns >= orders.until_ns) return std::nullopt;
  const std::int64_t scene_ns = touch_.body_count() > 1 ? scene_time_ns_ : -1;
  return LocalForce{output->force_n,      output->visual_offset_m, output->contact, output->is_handed_over,
                    output->difference_n, output->object,          scene_ns,        output->held_offset_m};
}

bool LocalPatch::read_hand_state(PatchHandState& hand, std::size_t link) noexcept {
  if (!hands_[link].take()) return false;
  hand = hands_[link].value();
  return true;
}

}  // namespace hapton
