#include "io_node/patch_builder.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "core/force/force_method.h"
#include "runtime/clock.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

constexpr auto kLookEvery = std::chrono::milliseconds(2);
constexpr auto kIdleLookEvery = std::chrono::milliseconds(50);
constexpr double kLeadS = 0.01;       // how far ahead of the hand the next patch is centred: about as long as it takes to build
constexpr double kLeaveShare = 0.35;  // of its radius from the centre: another one is built
constexpr double kGrowth = 1.3;       // so much more is known: another one is built
constexpr double kLiftSteps = 4.0;    // of the grid: a vertex moves by 0.87 of one at most
constexpr double kVelocityS = 0.02;   // over which the hand's velocity is a mean

}  // namespace

PatchBuilder::PatchBuilder(LocalPatch& local) : local_(local), thread_(start_thread([this] { run(); })) {}

PatchBuilder::~PatchBuilder() {
  stop_.store(true);
  thread_.join();
  local_.free_retired();
}

bool PatchBuilder::write(const Message* part) noexcept {
  const std::size_t end = end_.load(std::memory_order_relaxed);
  if (end - begin_.load(std::memory_order_acquire) == kRing) return false;
  Slot& slot = ring_[end % kRing];
  slot.is_clear = part == nullptr;
  if (part != nullptr) slot.part = *part;
  end_.store(end + 1, std::memory_order_release);
  return true;
}

void PatchBuilder::run() {
  while (!stop_.load()) {
    local_.free_retired();
    const bool has_parts = drain();
    PatchHand hand;
    const bool has_hand = local_.take_hand(hand);
    if (has_hand) {
      const double dt_s = 1e-9 * static_cast<double>(hand.time_ns - hand_.time_ns);
      if (has_hand_ && dt_s > 0.0) v_SD_ += std::min(dt_s / kVelocityS, 1.0) * ((hand.p_SD - hand_.p_SD) / dt_s - v_SD_);
      hand_ = hand;
      has_hand_ = true;
      build_if_due();
    }
    if (has_parts) {
      statuses_.publish(store_.status());
      told_.store = store_.counts();
      counts_.publish(told_);
    }
    std::this_thread::sleep_for(has_hand || has_parts ? kLookEvery : kIdleLookEvery);
  }
}

bool PatchBuilder::drain() {
  const std::size_t first = begin_.load(std::memory_order_relaxed);
  const std::size_t end = end_.load(std::memory_order_acquire);
  for (std::size_t at = first; at != end; ++at) {
    const Slot& slot = ring_[at % kRing];
    if (slot.is_clear) {
      store_.clear();
    } else if (const auto* tile = std::get_if<PatchTile>(&slot.part)) {
      store_.accept(*tile);
    } else if (const auto* cell = std::get_if<PatchCell>(&slot.part)) {
      store_.accept(*cell);
    } else if (const auto* begin = std::get_if<PatchBegin>(&slot.part)) {
      store_.accept(*begin);
    }
    if (slot.is_clear || store_.status().epoch != epoch_) {
      epoch_ = store_.status().epoch;
      p_SC_.reset();
      local_.set_generation(++generation_);
    }
    begin_.store(at + 1, std::memory_order_release);
  }
  return first != end;
}

// Where the hand will be, where all around it is known; else where it is.
void PatchBuilder::build_if_due() {
  if (!store_.has_begun() || !hand_.p_SD.allFinite()) return;
  if (p_SC_ && built_from_ == store_.revision() && (hand_.p_SD - *p_SC_).norm() < kLeaveShare * radius_m_) return;
  const Vec3 lead = v_SD_.allFinite() ? Vec3(kLeadS * v_SD_) : Vec3(Vec3::Zero());
  const double here_m = store_.known_radius(hand_.p_SD);
  const double ahead_m = store_.known_radius(hand_.p_SD + lead);
  const Vec3 p_SC = ahead_m > lead.norm() && ahead_m >= here_m ? Vec3(hand_.p_SD + lead) : hand_.p_SD;
  const double known_m = p_SC == hand_.p_SD ? here_m : ahead_m;
  const bool is_left = !p_SC_ || (hand_.p_SD - *p_SC_).norm() >= kLeaveShare * radius_m_;
  const bool has_grown = known_m > kGrowth * radius_m_ && !is_limited_;
  built_from_ = store_.revision();
  if (known_m > 0.0 && (is_left || has_grown)) build(p_SC, known_m);
}

void PatchBuilder::build(const Vec3& p_SC, double known_m) {
  const SteadyClock clock;
  const std::int64_t began_ns = clock.now_ns();
  PatchStore::Piece piece = store_.make_piece(p_SC, known_m, kMostTriangles);
  auto patch = std::make_unique<Patch>();
  patch->p_SC = p_SC;
  patch->radius_m = piece.radius_m;
  patch->lift_m = kLiftSteps * store_.begin().step_m;
  patch->generation = generation_;
  if (!piece.scene.objects.empty()) {
    MethodSettings settings;
    settings.probe_radius_m = store_.begin().probe_radius_m;
    auto method = make_method(settings, piece.scene);
    if (!method) return;
    patch->step = std::make_unique<TouchStep>(std::move(*method));
  }
  p_SC_ = p_SC;
  radius_m_ = piece.radius_m;
  is_limited_ = piece.radius_m < known_m;
  local_.offer(std::move(patch));
  ++told_.built;
  told_.triangles = piece.triangles;
  told_.radius_m = piece.radius_m;
  told_.build_ms = 1e-6 * static_cast<double>(clock.now_ns() - began_ns);
  counts_.publish(told_);
}

}  // namespace hapton
