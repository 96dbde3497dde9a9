#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "core/force/force_fade.h"
#include "patch/patch_maker.h"
#include "patch/patch_source.h"
#include "patch/patch_store.h"
#include "patch/patch_touch.h"
#include "remote_touch/sample_link.h"

namespace hapton {

// Patches of the scene beside the device: the classes of patch/, at the rates at which the nodes run them. The haptics node gets 20 samples
// a second and replies to each. The hub acknowledges the parts that have come every 100 ms, or after 50 ms if there are new ones. To make
// the next patch takes kTriangleNs a triangle.
class RemotePatch final : public RemoteTouch {
 public:
  static constexpr std::int64_t kSampleNs = 50'000'000;
  static constexpr std::int64_t kStatusNs = 100'000'000;
  static constexpr std::int64_t kSoonNs = 50'000'000;
  static constexpr std::int64_t kSendNs = 4'000'000;  // period at which the haptics node chooses what to send
  // Time to make a patch for each triangle, and at least. Assumed, not measured here.
  static constexpr std::int64_t kTriangleNs = 1000;
  static constexpr std::int64_t kMinMakeNs = 5'000'000;

  struct Options {
    PatchSource::Options source = {};
  };

  // method: with the whole scene, for the replies of the haptics node.
  RemotePatch(std::shared_ptr<ForceMethod> method, const TiledScene& tiles, const RemoteNetwork& network, const Options& options);

  RemoteStep step(const Vec3& p_WD, std::int64_t now_ns) override;
  // True: parts were sent, and then none for longer than it takes to learn that one was lost.
  bool is_ready() const override;
  RemoteTraffic traffic() const override;

  const PatchTouch::Counts& counts() const noexcept { return touch_.counts(); }
  const PatchSource& source() const noexcept { return source_; }
  const PatchStore& store() const noexcept { return store_; }

 private:
  void send_status(std::int64_t now_ns);
  void run_haptics(std::int64_t now_ns);
  void follow_hand(const SampleOnTheWay& sample);
  void take_parts(std::int64_t now_ns);
  void make_patches(const Vec3& p_WD, std::int64_t now_ns);

  SampleLink link_;
  NetworkPath<PatchStatus> up_;
  NetworkPath<Message> down_;
  std::size_t status_bytes_;

  // The haptics node.
  PatchSource source_;
  HandMotion hand_;
  std::optional<std::int64_t> last_sample_ns_;
  bool is_requested_ = false;
  std::int64_t last_send_check_ns_ = 0;
  std::int64_t part_sent_ns_ = -1;

  // The hub.
  PatchStore store_;
  PatchMaker maker_;
  PatchTouch touch_;
  ForceFade fade_;
  std::unique_ptr<Patch> next_patch_;
  std::int64_t next_patch_ready_ns_ = 0;
  std::int64_t last_status_ns_ = 0;
  std::int64_t now_ns_ = 0;
  std::int64_t last_step_ns_ = 0;
  double round_trip_s_ = -1.0;
  bool has_new_parts_ = false;
  bool had_patch_force_ = false;
};

}  // namespace hapton
