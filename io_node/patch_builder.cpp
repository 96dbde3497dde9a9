#include "io_node/patch_builder.h"

#include <chrono>
#include <memory>
#include <utility>

#include "runtime/clock.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

constexpr auto kLookEvery = std::chrono::milliseconds(2);
constexpr auto kIdleLookEvery = std::chrono::milliseconds(50);

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
      maker_.note_hand(hand);
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
      maker_.forget();
      local_.set_generation(++generation_);
    }
    if (slot.is_clear) local_.set_cleared(++cleared_);
    begin_.store(at + 1, std::memory_order_release);
  }
  return first != end;
}

void PatchBuilder::build_if_due() {
  const SteadyClock clock;
  const std::int64_t began_ns = clock.now_ns();
  std::unique_ptr<Patch> patch = maker_.make_if_due(store_, generation_);
  if (patch == nullptr) return;
  local_.offer(std::move(patch));
  ++told_.built;
  told_.triangles = maker_.triangles();
  told_.radius_m = maker_.radius_m();
  const double seconds = 1e-9 * static_cast<double>(clock.now_ns() - began_ns);
  maker_.note_made(seconds);
  told_.build_ms = 1e3 * seconds;
  counts_.publish(told_);
}

}  // namespace hapton
