#include "io_node/local_patch.h"

#include <algorithm>
#include <utility>

namespace hapton {
namespace {

constexpr double kFirstStepS = 1e-3;
constexpr double kLongestStepS = 0.02;  // after a gap
constexpr std::uint32_t kNoGeneration = 0xFFFFFFFF;

}  // namespace

LocalPatch::~LocalPatch() {
  delete built_.load();
  delete retired_.load();
}

// Nothing is freed here: one slot takes back what is not needed any more, and nothing new comes before it is empty.
void LocalPatch::exchange_patches() noexcept {
  if (retired_.load(std::memory_order_acquire) != nullptr) return;
  if (auto retired = touch_.take_retired()) {
    retired_.store(retired.release(), std::memory_order_release);
  } else if (built_.load(std::memory_order_relaxed) != nullptr) {
    auto superseded = touch_.offer(std::unique_ptr<Patch>(built_.exchange(nullptr, std::memory_order_acq_rel)));
    retired_.store(superseded.release(), std::memory_order_release);
  }
}

std::optional<LocalForce> LocalPatch::step(const DeviceSample& sample) noexcept {
  orders_.take();
  const PatchOrders& orders = orders_.value();
  if (!orders.is_wanted) {
    if (touch_.is_placed()) touch_.forget();
    return std::nullopt;
  }
  exchange_patches();
  // Where a haptics node has just joined, what is there is of the one before, until the builder has seen to it.
  const bool is_cleared = cleared_.load(std::memory_order_acquire) == orders.clears;
  touch_.set_generation(is_cleared ? generation_.load(std::memory_order_acquire) : kNoGeneration);
  const Pose X_SW = orders.X_WS.inverse(Eigen::Isometry);
  if (std::exchange(started_, orders.start) != orders.start && !touch_.has_arrived()) {
    touch_.start_at(X_SW * orders.p_WP, X_SW.linear() * orders.outward_W, 1e-9 * static_cast<double>(last_ns_ - orders.start_ns));
  }
  const std::int64_t passed_ns = sample.time_ns - std::exchange(last_ns_, sample.time_ns);
  const double dt_s = passed_ns > 0 ? std::min(1e-9 * static_cast<double>(passed_ns), kLongestStepS) : kFirstStepS;
  const std::optional<PatchOutput> output = touch_.step({sample.p_WD, orders.X_WS, dt_s});
  counts_.publish(touch_.counts());
  hands_.publish(touch_.hand_at(X_SW * sample.p_WD, sample.time_ns));
  // The proxy goes on following the device, so that the surface is the same once haptics replies again.
  if (!output || sample.time_ns >= orders.until_ns) return std::nullopt;
  return LocalForce{output->force_n,        output->visual_offset_m, output->contact,
                    output->is_handed_over, output->difference_n,    output->object};
}

bool LocalPatch::take_hand(PatchHand& hand) noexcept {
  if (!hands_.take()) return false;
  hand = hands_.value();
  return true;
}

}  // namespace hapton
