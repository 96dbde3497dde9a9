#include "io_node/patch_thread.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include "runtime/clock.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

// The thread polls, because waking it would cost the network side a system call. While parts arrive, a patch is due every few milliseconds.
constexpr auto kPatchPollPeriod = std::chrono::milliseconds(2);
constexpr auto kIdlePatchPollPeriod = std::chrono::milliseconds(50);
// A stage of fewer vertices counts as one of this many: a short wait for the CPU would dominate its time, and say nothing about large ones.
constexpr std::uint32_t kMinCountedVertices = 1000;
constexpr float kDecayShare = 0.125F;  // share of the difference by which the estimate falls with each faster stage

}  // namespace

PatchThread::PatchThread(LocalPatch& local) : local_patch_(local) {
  for (std::uint32_t body = 0; body < PatchBody::kMaxBodies; ++body) makers_.emplace_back(PatchMaker::kFewTriangles, body);
  failed_work_.assign(makers_.size(), WorkShare(kFailureShare, kFailureBurstNs));
  thread_ = start_thread([this] { run(); });
}

PatchThread::~PatchThread() {
  stop_.store(true);
  thread_.join();
  local_patch_.free_retired();
}

bool PatchThread::write(const Message* part, Arrival arrival) noexcept {
  const std::size_t end = end_.load(std::memory_order_relaxed);
  if (end - begin_.load(std::memory_order_acquire) == kRingSlots) return false;
  Slot& slot = ring_[end % kRingSlots];
  slot.is_clear = part == nullptr;
  slot.arrival = arrival;
  if (part != nullptr) slot.part = *part;
  end_.store(end + 1, std::memory_order_release);
  return true;
}

bool PatchThread::clear() noexcept {
  const bool is_written = write(nullptr, Arrival::newest);
  requested_clears_ += is_written ? 1 : 0;
  return is_written;
}

std::optional<ShapeStatus> PatchThread::take_shape_request() noexcept {
  ShapeStatus request;
  return shape_requests_.pop(request) ? std::optional(request) : std::nullopt;
}

void PatchThread::run() {
  while (!stop_.load()) {
    local_patch_.free_retired();
    const bool has_parts = drain();
    const bool has_hand = build_where_due();
    request_missing_shapes();
    if (std::exchange(has_made_stage_, false) || has_parts) {
      PatchStatus status = store_.status();
      status.shape_s_per_vertex = shape_s_per_vertex_;
      statuses_.publish({status, done_clears_});
      thread_counts_.store = store_.counts();
      counts_.publish(thread_counts_);
    }
    std::this_thread::sleep_for(has_hand || has_parts ? kPatchPollPeriod : kIdlePatchPollPeriod);
  }
}

bool PatchThread::drain() {
  const std::size_t first = begin_.load(std::memory_order_relaxed);
  const std::size_t end = end_.load(std::memory_order_acquire);
  for (std::size_t at = first; at != end; ++at) {
    const Slot& slot = ring_[at % kRingSlots];
    if (slot.is_clear) {
      store_.clear();
    } else if (!store_.accept_shape(slot.part, slot.arrival)) {
      (void)store_.accept_part(slot.part);
    }
    if (slot.is_clear || store_.status().epoch != epoch_) begin_epoch(slot.is_clear);
    if (slot.is_clear) local_patch_.set_cleared(++done_clears_);
    begin_.store(at + 1, std::memory_order_release);
  }
  offer_news();
  return first != end;
}

void PatchThread::begin_epoch(bool is_cleared) {
  epoch_ = is_cleared ? 0 : store_.status().epoch;
  for (PatchMaker& maker : makers_) maker.forget();
  are_bodies_offered_ = false;
  local_patch_.set_generation(++generation_);
}

// Bodies are offered before any of their patches.
void PatchThread::offer_news() {
  if (!are_bodies_offered_ && store_.has_bodies()) {
    local_patch_.offer(store_.make_bodies(generation_));
    are_bodies_offered_ = true;
  }
  if (std::exchange(material_version_, store_.material_version()) == store_.material_version()) return;
  auto materials = std::make_unique<PatchMaterials>();
  materials->version = store_.material_version();
  for (const auto& [object, material] : store_.materials()) materials->objects.emplace_back(static_cast<int>(object), material);
  local_patch_.offer(std::move(materials));
}

bool PatchThread::is_in_use(std::size_t link) const noexcept {
  if (!are_bodies_offered_) return link == 0;
  return link < store_.begin().body_count;
}

// True: a new sample of the hand has arrived.
bool PatchThread::build_where_due() {
  bool has_hand = false;
  for (std::size_t link = 0; link < makers_.size(); ++link) {
    PatchHandState hand;
    if (!local_patch_.read_hand_state(hand, link)) continue;
    has_hand = true;
    if (!is_in_use(link)) continue;
    makers_[link].note_hand(hand);
    if (!are_bodies_offered_) continue;
    build_if_due(link);
    if (local_patch_.has_room(link)) make_stage_if_due(link);
  }
  return has_hand;
}

void PatchThread::request_missing_shapes() {
  const std::int64_t now_ns = SteadyClock().now_ns();
  if (const auto newest = store_.take_shape_request(now_ns)) (void)shape_requests_.push(*newest);
  requests_.clear();
  store_.take_shape_requests_ahead(now_ns, requests_);
  for (const ShapeStatus& ahead : requests_) (void)shape_requests_.push(ahead);
}

void PatchThread::make_stage_if_due(std::size_t link) {
  const SteadyClock clock;
  const std::int64_t began_ns = clock.now_ns();
  if (!stage_work_.may_begin(began_ns)) return;
  auto stage = makers_[link].make_stage_if_due(store_);
  const std::int64_t took_ns = clock.now_ns() - began_ns;
  stage_work_.note(took_ns);
  thread_counts_.stages_s += 1e-9 * static_cast<double>(took_ns);
  if (stage == nullptr) return;
  if (const StreamedParts* const stream = store_.find_stream(static_cast<std::uint32_t>(link))) note_stage(took_ns, stream->total());
  local_patch_.offer(std::move(stage), link);
}

// The measured time includes CPU time that other programs take. The estimate rises at once, because a late stage can be felt.
void PatchThread::note_stage(std::int64_t took_ns, std::uint32_t vertices) noexcept {
  const float newest_s = 1e-9F * static_cast<float>(took_ns) / static_cast<float>(std::max(vertices, kMinCountedVertices));
  shape_s_per_vertex_ = std::max(newest_s, shape_s_per_vertex_ + kDecayShare * (newest_s - shape_s_per_vertex_));
  has_made_stage_ = true;
  ++thread_counts_.stages;
}

void PatchThread::build_if_due(std::size_t link) {
  PatchMaker& maker = makers_[link];
  const SteadyClock clock;
  const std::int64_t began_ns = clock.now_ns();
  if (!failed_work_[link].may_begin(began_ns)) return;
  std::unique_ptr<Patch> patch = maker.make_if_due(store_, generation_);
  if (patch == nullptr) return failed_work_[link].note(clock.now_ns() - began_ns);
  local_patch_.offer(std::move(patch), link);
  ++thread_counts_.built;
  thread_counts_.triangles = maker.triangles();
  thread_counts_.radius_m = maker.radius_m();
  const double seconds = 1e-9 * static_cast<double>(clock.now_ns() - began_ns);
  maker.note_made(seconds);
  thread_counts_.build_ms = 1e3 * seconds;
  counts_.publish(thread_counts_);
}

}  // namespace hapton
