#include "io_node/patch_builder.h"

#include <chrono>
#include <memory>
#include <utility>

#include "runtime/clock.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

// Polls, since to wake it would be a system call in the servo. While parts come a patch is due every few milliseconds.
constexpr auto kLookEvery = std::chrono::milliseconds(2);
constexpr auto kIdleLookEvery = std::chrono::milliseconds(50);

}  // namespace

PatchBuilder::PatchBuilder(LocalPatch& local) : local_(local) {
  for (std::uint32_t body = 0; body < PatchBody::kMostBodies; ++body) makers_.emplace_back(PatchMaker::kFewTriangles, body);
  thread_ = start_thread([this] { run(); });
}

PatchBuilder::~PatchBuilder() {
  stop_.store(true);
  thread_.join();
  local_.free_retired();
}

bool PatchBuilder::write(const Message* part, Arrival arrival) noexcept {
  const std::size_t end = end_.load(std::memory_order_relaxed);
  if (end - begin_.load(std::memory_order_acquire) == kRing) return false;
  Slot& slot = ring_[end % kRing];
  slot.is_clear = part == nullptr;
  slot.arrival = arrival;
  if (part != nullptr) slot.part = *part;
  end_.store(end + 1, std::memory_order_release);
  return true;
}

bool PatchBuilder::clear() noexcept {
  const bool is_written = write(nullptr, Arrival::newest);
  clears_ += is_written ? 1 : 0;
  return is_written;
}

std::optional<ShapeStatus> PatchBuilder::take_shape_request() noexcept {
  ShapeStatus request;
  return shape_requests_.pop(request) ? std::optional(request) : std::nullopt;
}

void PatchBuilder::run() {
  while (!stop_.load()) {
    local_.free_retired();
    const bool has_parts = drain();
    const bool has_hand = build_where_due();
    look_after_shapes();
    if (has_parts) {
      statuses_.publish({store_.status(), cleared_});
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
    } else if (!store_.accept_shape(slot.part, slot.arrival)) {
      (void)store_.accept_part(slot.part);
    }
    if (slot.is_clear || store_.status().epoch != epoch_) begin_epoch(slot.is_clear);
    if (slot.is_clear) local_.set_cleared(++cleared_);
    begin_.store(at + 1, std::memory_order_release);
  }
  offer_news();
  return first != end;
}

void PatchBuilder::begin_epoch(bool is_cleared) {
  epoch_ = is_cleared ? 0 : store_.status().epoch;
  for (PatchMaker& maker : makers_) maker.forget();
  are_bodies_offered_ = false;
  local_.set_generation(++generation_);
}

// Bodies come before all patches of them.
void PatchBuilder::offer_news() {
  if (!are_bodies_offered_ && store_.has_bodies()) {
    local_.offer(store_.make_bodies(generation_));
    are_bodies_offered_ = true;
  }
  if (std::exchange(material_version_, store_.material_version()) == store_.material_version()) return;
  auto materials = std::make_unique<PatchMaterials>();
  materials->version = store_.material_version();
  for (const auto& [object, material] : store_.materials()) materials->objects.emplace_back(static_cast<int>(object), material);
  local_.offer(std::move(materials));
}

bool PatchBuilder::is_in_use(std::size_t link) const noexcept {
  if (!are_bodies_offered_) return link == 0;
  return link < store_.begin().body_count;
}

// True: the hand has moved.
bool PatchBuilder::build_where_due() {
  bool has_hand = false;
  for (std::size_t link = 0; link < makers_.size(); ++link) {
    PatchHandState hand;
    if (!local_.read_hand_state(hand, link)) continue;
    has_hand = true;
    if (!is_in_use(link)) continue;
    makers_[link].note_hand(hand);
    if (!are_bodies_offered_) continue;
    build_if_due(link);
    if (!local_.has_room(link)) continue;
    if (auto stage = makers_[link].make_stage_if_due(store_)) local_.offer(std::move(stage), link);
  }
  return has_hand;
}

void PatchBuilder::look_after_shapes() {
  const std::int64_t now_ns = SteadyClock().now_ns();
  if (const auto newest = store_.take_shape_request(now_ns)) (void)shape_requests_.push(*newest);
  requests_.clear();
  store_.take_shape_requests_ahead(now_ns, requests_);
  for (const ShapeStatus& ahead : requests_) (void)shape_requests_.push(ahead);
}

void PatchBuilder::build_if_due(std::size_t link) {
  PatchMaker& maker = makers_[link];
  const SteadyClock clock;
  const std::int64_t began_ns = clock.now_ns();
  std::unique_ptr<Patch> patch = maker.make_if_due(store_, generation_);
  if (patch == nullptr) return;
  local_.offer(std::move(patch), link);
  ++told_.built;
  told_.triangles = maker.triangles();
  told_.radius_m = maker.radius_m();
  const double seconds = 1e-9 * static_cast<double>(clock.now_ns() - began_ns);
  maker.note_made(seconds);
  told_.build_ms = 1e3 * seconds;
  counts_.publish(told_);
}

}  // namespace hapton
