#pragma once

#include <deque>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/force/force_method.h"
#include "patch/patch_maker.h"
#include "patch/patch_source.h"
#include "patch/patch_store.h"
#include "patch/patch_touch.h"
#include "tests/support/made_meshes.h"
#include "tests/support/made_scene.h"

namespace hapton {

// A wavy sheet of n x n squares, of side 2 * half, with heights up to about 2.5 mm.
inline double wavy_height(double x, double y) {
  return 0.0015 * std::sin(270.0 * x) * std::sin(220.0 * y) + 0.001 * std::sin(400.0 * (x + y));
}
inline TriangleMesh wavy_sheet(double half, int n) {
  TriangleMesh mesh = made::sheet(half, 0.0, n);
  for (Vec3& v : mesh.vertices) v.z() = wavy_height(v.x(), v.y());
  return mesh;
}

// Both ends of touch by patches and a bad network between them, on simulated time, in cycles of 1 ms.
class PatchStage {
 public:
  struct Network {
    double delay_s = 0.05;  // one way
    double jitter_s = 0.0;
    double loss = 0.0;
    std::uint64_t seed = 1;
    double make_s = 0.005;  // how long a patch takes to make
    double bits_per_s = 1e6;
  };

  PatchStage(const TouchScene& scene, const Network& network)
      : network_(network), random_(network.seed), source_(make_tiles(scene), 0.0, 7, 1, {.bits_per_s = network.bits_per_s}) {
    whole_ = std::make_unique<TouchStep>(*make_method({}, scene));
  }

  struct Outputs {
    std::optional<PatchOutput> patch;
    TouchOutput whole;
  };

  // Makes one cycle with the device at p_WD.
  Outputs step(const Vec3& p_WD, const Pose& X_WS = Pose::Identity()) {
    now_ns_ += 1'000'000;
    const TouchInput input{p_WD, X_WS, 1e-3};
    const Vec3 p_SD = X_WS.inverse() * p_WD;
    if (cycle_++ % 50 == 0) send_up(p_SD);
    take_arrivals();
    for (int n = 0; n < 16; ++n) {
      auto part = source_.take(now_ns_);
      if (!part) break;
      if (!is_lost()) down_parts_.push_back({arrival_ns(), *part});
    }
    make_patches(p_SD);
    Outputs felt{touch_.step(input), {}};
    if (cycle_ == 1) whole_->reset(input);
    felt.whole = whole_->step(input);
    return felt;
  }

  // Starts the proxy of the whole scene where that of the patch starts.
  void reset_whole(const Vec3& p_WD) { whole_->reset({p_WD, Pose::Identity(), 1e-3}); }
  const PatchTouch& touch() const { return touch_; }
  const PatchSource& source() const { return source_; }
  const PatchStore& store() const { return store_; }
  PatchMaker& maker() { return maker_; }
  double now_s() const { return 1e-9 * static_cast<double>(now_ns_); }
  void set_network(const Network& network) { network_ = network; }

 private:
  bool is_lost() { return std::uniform_real_distribution<double>(0, 1)(random_) < network_.loss; }
  std::int64_t arrival_ns() {
    return now_ns_ +
           static_cast<std::int64_t>(1e9 * (network_.delay_s + network_.jitter_s * std::uniform_real_distribution<double>(0, 1)(random_)));
  }

  // On its way to the source.
  struct UpDatagram {
    std::int64_t due_ns;
    PatchStatus status;
    HandMotion hand;
  };

  void send_up(const Vec3& p_SD) {
    PatchStatus status = store_.status();
    status.is_wanted = true;
    status.round_trip_s = static_cast<float>(2.0 * network_.delay_s);
    const Vec3 moved = p_SD - std::exchange(last_sent_p_SD_, p_SD);
    if (!is_lost()) up_datagrams_.push_back({arrival_ns(), status, {p_SD, cycle_ > 1 ? Vec3(moved / 0.05) : Vec3(Vec3::Zero())}});
  }

  void take_arrivals() {
    for (auto it = up_datagrams_.begin(); it != up_datagrams_.end();) {
      if (it->due_ns > now_ns_) {
        ++it;
        continue;
      }
      source_.accept(it->status);
      source_.aim(it->hand);
      it = up_datagrams_.erase(it);
    }
    for (auto it = down_parts_.begin(); it != down_parts_.end();) {
      if (it->first > now_ns_) {
        ++it;
        continue;
      }
      if (const auto* tile = std::get_if<PatchTile>(&it->second)) store_.accept(*tile);
      if (const auto* cell = std::get_if<PatchCell>(&it->second)) store_.accept(*cell);
      if (const auto* begin = std::get_if<PatchBegin>(&it->second)) store_.accept(*begin);
      it = down_parts_.erase(it);
    }
  }

  // A patch takes a while to make; meanwhile no other is begun.
  void make_patches(const Vec3& p_SD) {
    maker_.note_hand(touch_.hand_at(p_SD, now_ns_));
    if (next_patch_ == nullptr) {
      next_patch_ = maker_.make_if_due(store_, 0);
      ready_ns_ = now_ns_ + static_cast<std::int64_t>(1e9 * network_.make_s);
    }
    (void)touch_.take_retired();
    if (next_patch_ != nullptr && now_ns_ >= ready_ns_) (void)touch_.offer(std::move(next_patch_));
  }

  Network network_;
  std::mt19937_64 random_;
  PatchSource source_;
  PatchStore store_;
  PatchMaker maker_;
  PatchTouch touch_;
  std::unique_ptr<TouchStep> whole_;
  std::deque<UpDatagram> up_datagrams_;
  std::deque<std::pair<std::int64_t, Message>> down_parts_;  // when each arrives
  std::unique_ptr<Patch> next_patch_;
  std::int64_t ready_ns_ = 0;
  std::int64_t now_ns_ = 1'000'000'000;
  std::uint64_t cycle_ = 0;
  Vec3 last_sent_p_SD_ = Vec3::Zero();
};

}  // namespace hapton
