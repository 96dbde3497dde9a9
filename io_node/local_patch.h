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
  bool is_wanted = false;  // use the force from patches, where there are any
  // False: a haptics node that has just joined has not replied yet, and may know of a contact. A patch that began before its reply would
  // take a hand inside a body to be in free space, and the contact would be lost for good.
  bool may_begin = true;
  std::int64_t until_ns = 0;  // the force from patches ends then: the haptics node has been silent for too long
  Pose X_WS = Pose::Identity();
  // Where the haptics node has the probe: p_WP, at the sample of start_ns. start_serial counts these notifications; they are used until a
  // patch reaches the hand.
  std::uint32_t start_serial = 0;
  std::int64_t start_ns = 0;
  Vec3 p_WP = Vec3::Zero();
  Vec3 outward_W = Vec3::Zero();    // unit, from the device point to the probe; zero: no contact
  std::int64_t start_scene_ns = 0;  // scene time at start_ns
  // Time of the sample of the newest force, and its scene time: until a patch reaches the hand, scene time goes on from there.
  std::int64_t remote_force_ns = 0;
  std::int64_t remote_force_scene_ns = 0;
  // How many times the parts that had come were to be dropped: patches are used only once the patch thread has dropped parts as often
  // (set_cleared).
  std::uint32_t clear_count = 0;
};

// Computes the force from patches of the scene, in the device's own thread. The patch thread builds the patches; they go back to it to be
// freed. Each body of the scene has patches of its own, in a link of the PatchChain: link is the body's number.
//
// Scene time, if the scene moves: until a patch reaches the hand, that of a sample is the scene time of the newest remote force plus the
// time since. From then on it advances with the samples here, as in the haptics node: a gap counts as at most kMaxSceneStepNs, and while no
// force is given it stands still.
//
// Frames: W world, S static scene; D: device point, P: probe. RT: the functions of the device's thread and of the network side yes; those
// of the patch thread no, as they free memory. Construction and destruction set-up only. Threads: three, each for the functions of its
// section below.
class LocalPatch final : public LocalTouch {
 public:
  static constexpr std::int64_t kMaxSceneStepNs = 50'000'000;  // as in HapticsStep

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
  // Sets hand to its newest place in the frame of a link. False: none has come since the last call.
  bool read_hand_state(PatchHandState& hand, std::size_t link = 0) noexcept;
  // Replaces a patch of this link that was not taken yet. Pre: the bodies of its generation were offered before.
  void offer(std::unique_ptr<Patch> patch, std::size_t link = 0) noexcept { exchange(offered_patches_[link], std::move(patch)); }
  void offer(std::unique_ptr<PatchBodies> bodies) noexcept { exchange(bodies_, std::move(bodies)); }
  void offer(std::unique_ptr<PatchMaterials> materials) noexcept { exchange(materials_, std::move(materials)); }
  // Whether the next stage of a link's patch can be offered: the stage before was taken.
  bool has_room(std::size_t link) const noexcept { return stages_[link].load(std::memory_order_acquire) == nullptr; }
  void offer(std::unique_ptr<PatchShape> stage, std::size_t link) noexcept { exchange(stages_[link], std::move(stage)); }
  // Patches of other generations are not used from now on.
  void set_generation(std::uint32_t generation) noexcept { generation_.store(generation, std::memory_order_release); }
  // How many times all parts were dropped (PatchOrders::clear_count). Pre: set_generation was called for the parts that come after.
  void set_cleared(std::uint32_t clear_count) noexcept { clear_count_.store(clear_count, std::memory_order_release); }
  void free_retired() noexcept {
    for (std::atomic<Patch*>& retired : retired_patches_) exchange(retired, nullptr);
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
  std::array<std::atomic<Patch*>, kLinks> offered_patches_ = {};
  std::array<std::atomic<Patch*>, kLinks> retired_patches_ = {};
  std::array<std::atomic<PatchShape*>, kLinks> stages_ = {};
  std::array<std::atomic<PatchShape*>, kLinks> retired_stages_ = {};
  std::atomic<PatchBodies*> bodies_ = nullptr;
  std::atomic<PatchBodies*> retired_bodies_ = nullptr;
  std::atomic<PatchMaterials*> materials_ = nullptr;
  std::atomic<PatchMaterials*> retired_materials_ = nullptr;
  std::atomic<std::uint32_t> generation_ = 0;
  std::atomic<std::uint32_t> clear_count_ = 0;

  // The device's thread.
  PatchChain touch_;
  bool are_bodies_awaited_ = false;  // bodies are offered, and cannot be taken yet
  std::int64_t last_ns_ = 0;         // of the last sample
  Vec3 last_p_WD_ = Vec3::Zero();    // likewise
  std::int64_t scene_time_ns_ = 0;
  std::uint32_t handled_start_ = 0;
};

}  // namespace hapton
