#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "core/base/mailbox.h"
#include "io_node/local_touch.h"
#include "patch/patch_chain.h"

namespace hapton {

// What the network side hands to the device side about patches.
struct PatchOrders {
  bool is_wanted = false;  // force from patches, where there are any
  // False: the haptics node that has just joined may know a contact, and has not replied yet. A patch that begins before would take a hand
  // inside a body for free, and contact would be lost for good.
  bool may_begin = true;
  std::int64_t until_ns = 0;  // no longer than until then: haptics is silent for too long by then
  Pose X_WS = Pose::Identity();
  // Where the probe was as far as haptics knows, in the sample of that time; counts the notifications. Used until a patch reaches the
  // hand.
  std::uint32_t start = 0;
  std::int64_t start_ns = 0;
  Vec3 p_WP = Vec3::Zero();
  Vec3 outward_W = Vec3::Zero();    // unit, zero: free
  std::int64_t start_scene_ns = 0;  // scene time then
  // A sample and its scene time, of the newest force: until patches reach the hand, scene time goes on from there.
  std::int64_t anchor_ns = 0;
  std::int64_t anchor_scene_ns = 0;
  // How many haptics nodes have joined whose parts are kept apart: patches are used once the patch thread has dropped those of the node
  // before.
  std::uint32_t clears = 0;
};

// Force from patches of the scene, on the device's own thread. Patches come from a thread that builds them, and go back to it to be freed.
//
// Of a scene that moves, the scene time of a sample is that of the newest remote force plus the time since, until a patch reaches the hand.
// From then on it advances with the samples of this side, as the haptics node does it: a gap counts as at most kMaxSceneStepNs, and while
// no force is given it stands still.
//
// Frames: W and S as named. RT: step, publish, hand and so on yes; making one and ending it is set-up only.
// Threads: one calls step, one the network side, one the patch thread.
class LocalPatch final : public LocalTouch {
 public:
  static constexpr std::int64_t kMaxSceneStepNs = 50'000'000;  // as HapticsStep

  LocalPatch() = default;
  ~LocalPatch() override;
  LocalPatch(const LocalPatch&) = delete;
  LocalPatch& operator=(const LocalPatch&) = delete;

  // --- the device's thread
  std::optional<LocalForce> step(const DeviceSample& sample) noexcept override;

  // --- the network side
  void publish(const PatchOrders& orders) noexcept { orders_.publish(orders); }
  void publish(const MoveTable& moves) noexcept { moves_.publish(moves); }
  const PatchTouch::Counts& counts() noexcept {
    counts_.take();
    return counts_.value();
  }

  // --- the patch thread
  // The newest place of the hand in the frame of a link (PatchChain); false: none came since the last call.
  bool read_hand_state(PatchHandState& hand, std::size_t link = 0) noexcept;
  // Replaces one that was not taken yet. Pre: the bodies of its generation were offered before.
  void offer(std::unique_ptr<Patch> patch, std::size_t link = 0) noexcept { exchange(built_[link], std::move(patch)); }
  void offer(std::unique_ptr<PatchBodies> bodies) noexcept { exchange(bodies_, std::move(bodies)); }
  void offer(std::unique_ptr<PatchMaterials> materials) noexcept { exchange(materials_, std::move(materials)); }
  // The next stage of a patch of a link, if there is room: the one before was taken. False: there is none.
  bool has_room(std::size_t link) const noexcept { return stages_[link].load(std::memory_order_acquire) == nullptr; }
  void offer(std::unique_ptr<PatchShape> stage, std::size_t link) noexcept { exchange(stages_[link], std::move(stage)); }
  // Patches of other generations are not used from now on.
  void set_generation(std::uint32_t generation) noexcept { generation_.store(generation, std::memory_order_release); }
  // So often all parts were dropped (PatchOrders::clears). The generation of what comes is set before.
  void set_cleared(std::uint32_t clears) noexcept { cleared_.store(clears, std::memory_order_release); }
  void free_retired() noexcept {
    for (std::atomic<Patch*>& retired : retired_) exchange(retired, nullptr);
    for (std::atomic<PatchShape*>& retired : retired_stages_) exchange(retired, nullptr);
    exchange(retired_bodies_, nullptr);
    exchange(retired_materials_, nullptr);
  }

 private:
  static constexpr std::size_t kLinks = PatchChain::kLinks;

  template <class T>
  static void exchange(std::atomic<T*>& slot, std::unique_ptr<T> fresh) noexcept {
    delete slot.exchange(fresh.release(), std::memory_order_acq_rel);
  }
  template <class T>
  static void exchange(std::atomic<T*>& slot, std::nullptr_t) noexcept {
    if (slot.load(std::memory_order_relaxed) != nullptr) delete slot.exchange(nullptr, std::memory_order_acq_rel);
  }
  template <class T>
  bool take_over(std::atomic<T*>& offered, std::atomic<T*>& retired) noexcept;
  void exchange_patches() noexcept;
  void exchange_patch(std::size_t link) noexcept;
  void exchange_stage(std::size_t link) noexcept;
  std::int64_t scene_time_of(const DeviceSample& sample, std::int64_t passed_ns) noexcept;

  Mailbox<PatchOrders> orders_;
  Mailbox<MoveTable> moves_;
  std::array<Mailbox<PatchHandState>, kLinks> hands_;
  Mailbox<PatchTouch::Counts> counts_;
  std::array<std::atomic<Patch*>, kLinks> built_ = {};
  std::array<std::atomic<Patch*>, kLinks> retired_ = {};
  std::array<std::atomic<PatchShape*>, kLinks> stages_ = {};
  std::array<std::atomic<PatchShape*>, kLinks> retired_stages_ = {};
  std::atomic<PatchBodies*> bodies_ = nullptr;
  std::atomic<PatchBodies*> retired_bodies_ = nullptr;
  std::atomic<PatchMaterials*> materials_ = nullptr;
  std::atomic<PatchMaterials*> retired_materials_ = nullptr;
  std::atomic<std::uint32_t> generation_ = 0;
  std::atomic<std::uint32_t> cleared_ = 0;

  // The device's thread.
  PatchChain touch_;
  bool are_bodies_awaited_ = false;  // they are there, and cannot be taken yet
  std::int64_t last_ns_ = 0;         // of the last sample
  Vec3 last_p_WD_ = Vec3::Zero();    // likewise
  std::int64_t scene_ns_ = 0;
  std::uint32_t started_ = 0;
};

}  // namespace hapton
