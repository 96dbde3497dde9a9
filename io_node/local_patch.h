#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "io_node/local_touch.h"
#include "patch/patch_touch.h"
#include "runtime/mailbox.h"

namespace hapton {

// What the network side hands to the device side about patches.
struct PatchOrders {
  bool is_wanted = false;     // force from patches, where there are any
  std::int64_t until_ns = 0;  // no longer than until then: haptics is silent for too long by then
  Pose X_WS = Pose::Identity();
  // Where the probe was as far as haptics knows, in the sample of that time; counts the notifications. Used until a patch reaches the
  // hand.
  std::uint32_t start = 0;
  std::int64_t start_ns = 0;
  Vec3 p_WP = Vec3::Zero();
  Vec3 outward_W = Vec3::Zero();  // unit, zero: free
  // How many haptics nodes have joined whose parts are kept apart: patches are used once the builder has dropped those of the node before.
  std::uint32_t clears = 0;
};

// Force from patches of the scene, on the device's own thread. Patches come from a thread that builds them, and go back to it to be freed.
//
// Frames: W and S as named. RT: step, publish, hand and so on yes; making one and ending it is set-up only.
// Threads: one calls step, one the network side, one the builder's side.
class LocalPatch final : public LocalTouch {
 public:
  LocalPatch() = default;
  ~LocalPatch() override;
  LocalPatch(const LocalPatch&) = delete;
  LocalPatch& operator=(const LocalPatch&) = delete;

  // --- the device's thread
  std::optional<LocalForce> step(const DeviceSample& sample) noexcept override;

  // --- the network side
  void publish(const PatchOrders& orders) noexcept { orders_.publish(orders); }
  const PatchTouch::Counts& counts() noexcept {
    counts_.take();
    return counts_.value();
  }

  // --- the builder
  // The newest place of the hand; false: none came since the last call.
  bool take_hand(PatchHand& hand) noexcept;
  // Replaces one that was not taken yet.
  void offer(std::unique_ptr<Patch> patch) noexcept { delete built_.exchange(patch.release(), std::memory_order_acq_rel); }
  // Patches of other generations are not used from now on.
  void set_generation(std::uint32_t generation) noexcept { generation_.store(generation, std::memory_order_release); }
  // So often all parts were dropped (PatchOrders::clears). The generation of what comes is set before.
  void set_cleared(std::uint32_t clears) noexcept { cleared_.store(clears, std::memory_order_release); }
  void free_retired() noexcept { delete retired_.exchange(nullptr, std::memory_order_acq_rel); }

 private:
  void exchange_patches() noexcept;

  Mailbox<PatchOrders> orders_;
  Mailbox<PatchHand> hands_;
  Mailbox<PatchTouch::Counts> counts_;
  std::atomic<Patch*> built_ = nullptr;
  std::atomic<Patch*> retired_ = nullptr;
  std::atomic<std::uint32_t> generation_ = 0;
  std::atomic<std::uint32_t> cleared_ = 0;

  // The device's thread.
  PatchTouch touch_;
  std::int64_t last_ns_ = 0;
  std::uint32_t started_ = 0;
};

}  // namespace hapton
