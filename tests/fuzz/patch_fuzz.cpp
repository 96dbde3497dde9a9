// Any parts of a scene, as a haptics node sends them. They are stored and assembled; a hand moves through the middle and touches them.
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "link/codec.h"
#include "patch/move_table.h"
#include "patch/patch_chain.h"
#include "patch/patch_maker.h"
#include "patch/patch_store.h"
#include "tests/fuzz/datagram_list.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/proto_mutator.h"

namespace hapton {
namespace {

constexpr double kStepS = 1e-3;
constexpr int kSteps = 12;

// Does what the hub does, with the store and the makers of PatchThread and the chain of the device loop.
class PatchHub {
 public:
  PatchHub() {
    for (std::uint32_t body = 0; body < PatchChain::kLinks; ++body) makers_.emplace_back(PatchMaker::kFewTriangles, body);
  }

  void take(const Message& message) {
    if (const auto* move = std::get_if<ObjectMove>(&message)) return take(*move);
    const std::uint32_t epoch = store_.status().epoch;
    if (store_.accept_shape(message, Arrival::newest)) return;
    const bool is_part = store_.accept_part(message);
    fuzz::require(is_part == is_scene_part(message));
    if (store_.status().epoch == epoch) return;
    for (PatchMaker& maker : makers_) maker.forget();
    has_bodies_ = false;
    chain_->set_generation(++generation_);
  }

  void touch() {
    if (!store_.has_begun()) return;
    const double size_m = std::ldexp(store_.begin().step_m, kPatchGridBits);
    const Vec3 centre = store_.begin().origin_m + Vec3::Constant(0.5 * size_m);
    for (int n = 0; n < kSteps; ++n) {
      const double share = static_cast<double>(n) / (kSteps - 1) - 0.5;
      step(centre + size_m * share * Vec3(0.05, -0.02, -0.3));
    }
  }

 private:
  void take(const ObjectMove& move) {
    (void)moves_.take(move);
    chain_->note_moves(moves_);
  }

  void step(const Vec3& p_WD) {
    time_s_ += kStepS;
    if (!has_bodies_ && store_.has_bodies()) {
      (void)chain_->take(store_.make_bodies(generation_));
      chain_->note_moves(moves_);
      has_bodies_ = true;
    }
    make_patches();
    const auto force = chain_->step({.p_WD = p_WD, .dt_s = kStepS, .time_s = time_s_});
    fuzz::require(!force || force->force_n.allFinite());
  }

  void make_patches() {
    const std::uint32_t bodies = has_bodies_ ? store_.begin().body_count : 1;
    for (std::uint32_t body = 0; body < bodies; ++body) {
      const auto time_ns = static_cast<std::int64_t>(1e9 * time_s_);
      const PatchHandState hand = chain_->hand_of(body, time_ns, time_ns);
      const double known_radius_m = store_.known_radius(hand.p_SD, body);
      fuzz::require(!(known_radius_m < 0.0));
      (void)chain_->take_retired(body);
      makers_[body].note_hand(hand);
      if (shapes_[body] == nullptr) shapes_[body] = makers_[body].make_stage_if_due(store_);
      if (shapes_[body] != nullptr && chain_->take(body, *shapes_[body])) shapes_[body].reset();
      auto patch = makers_[body].make_if_due(store_, generation_);
      if (patch == nullptr) continue;
      fuzz::require((patch->step == nullptr) == patch->objects.empty());
      (void)chain_->offer(body, std::move(patch));
    }
  }

  PatchStore store_;
  std::vector<PatchMaker> makers_;
  std::array<std::unique_ptr<PatchShape>, PatchChain::kLinks> shapes_;  // made, but not yet taken by the chain
  std::unique_ptr<PatchChain> chain_ = std::make_unique<PatchChain>();
  MoveTable moves_;
  std::uint32_t generation_ = 0;
  bool has_bodies_ = false;
  double time_s_ = 0.0;
};

fuzz::Bytes mutate_parts(std::span<const std::uint8_t> input, fuzz::Mutation& mutation) {
  std::vector<fuzz::ListedDatagram> parts = fuzz::split_datagrams(input);
  if (parts.empty()) return mutation.change({}, mutation.max_size());
  if (mutation.one_in(8)) {
    mutation.change_order(parts);
  } else {
    fuzz::ListedDatagram& part = parts[mutation.below(parts.size())];
    part.bytes = fuzz::mutate_proto(part.bytes, mutation);
    if (mutation.one_in(8)) part.flags ^= 1U;
  }
  return fuzz::join_datagrams(parts);
}

fuzz::Bytes cross_parts(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b, fuzz::Mutation& mutation) {
  return fuzz::join_datagrams(mutation.cross(fuzz::split_datagrams(a), fuzz::split_datagrams(b)));
}

}  // namespace
}  // namespace hapton

// Bit 0 of a part's flags: the hand moves before the next part comes.
FUZZ_TARGET(patch) {
  using namespace hapton;
  static Codec codec;
  PatchHub hub;
  bool all_valid = true;
  for (const fuzz::ListedDatagram& part : fuzz::split_datagrams(bytes)) {
    Datagram datagram;
    if (codec.decode(fuzz::as_datagram(part.bytes), datagram) != DecodeStatus::ok) {
      all_valid = false;
      continue;
    }
    hub.take(datagram.message);
    if ((part.flags & 1U) != 0) hub.touch();
  }
  hub.touch();
  if (all_valid && !bytes.empty()) fuzz::note_passage();
}

FUZZ_MUTATOR(patch, hapton::mutate_parts);
FUZZ_CROSSOVER(patch, hapton::cross_parts);
