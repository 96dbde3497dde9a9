#include "haptics_node/carve_sender.h"

#include <algorithm>

namespace hapton {

CarveSender::CarveSender(std::uint32_t source, std::size_t max_entries) : source_(source), max_entries_(max_entries) {
  carves_.reserve(max_entries);
}

void CarveSender::note(const MadeCarve& made) noexcept {
  if (made.serial == 1 && newest() > 0) begin_anew();
  if (made.serial != newest() + 1 || is_full()) return;
  const auto point = [](const Vec3& p) {
    return Carves::Point{static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
  };
  carves_.push_back({.object = made.object,
                     .from_m = point(made.carve.from_m),
                     .to_m = point(made.carve.to_m),
                     .radius_m = static_cast<float>(made.carve.radius_m),
                     .begins = made.begins,
                     .undone_first = made.undone.first,
                     .undone_last = made.undone.last});
}

void CarveSender::begin_anew() noexcept {
  source_ += 2;
  carves_.clear();
  next_fresh_ = 1;
  next_requested_ = 0;
  repeats_left_ = 0;
}

void CarveSender::accept(const CarveStatus& status) noexcept {
  if (status.source != source_ || status.complete >= next_fresh_ - 1) return;
  const std::uint32_t missing = status.complete + 1;
  next_requested_ = next_requested_ == 0 ? missing : std::min(next_requested_, missing);
}

std::optional<Carves> CarveSender::take_due(std::int64_t now_ns) noexcept {
  if (now_ns < next_send_ns_) return std::nullopt;
  const bool has_fresh = next_fresh_ <= newest();
  const bool has_requested = next_requested_ != 0;
  const bool is_repeat = !has_fresh && !has_requested && repeats_left_ > 0 && now_ns >= repeat_ns_;
  if (!has_fresh && !has_requested && !is_repeat) return std::nullopt;
  next_send_ns_ = now_ns + kEveryNs;
  if (is_repeat) {
    --repeats_left_;
    repeat_ns_ = now_ns + kRepeatNs;
    return gather(find_tail(), newest());
  }
  last_was_fresh_ = has_fresh && !(has_requested && last_was_fresh_);
  return last_was_fresh_ ? take_fresh(now_ns) : take_requested();
}

// The serial of the first of the newest entries that fit into one datagram.
std::uint32_t CarveSender::find_tail() const noexcept {
  constexpr auto kMaxHere = static_cast<std::uint32_t>(Carves::kMax);
  return newest() > kMaxHere ? newest() - kMaxHere + 1 : 1;
}

Carves CarveSender::take_fresh(std::int64_t now_ns) noexcept {
  const Carves fresh = gather(next_fresh_ > kOverlap ? next_fresh_ - kOverlap : 1, newest());
  next_fresh_ = fresh.first + fresh.count;
  repeats_left_ = kRepeats;
  repeat_ns_ = now_ns + kRepeatNs;
  return fresh;
}

Carves CarveSender::take_requested() noexcept {
  const Carves requested = gather(next_requested_, next_fresh_ - 1);
  next_requested_ = requested.first + requested.count;
  if (next_requested_ >= next_fresh_) next_requested_ = 0;
  return requested;
}

Carves CarveSender::announce() const noexcept { return {.source = source_, .newest = newest()}; }

// Returns the entries from first to last, or as many of them as fit.
Carves CarveSender::gather(std::uint32_t first, std::uint32_t last) const noexcept {
  Carves carves = announce();
  carves.first = first;
  carves.count = std::min(last - first + 1, static_cast<std::uint32_t>(Carves::kMax));
  std::copy_n(carves_.begin() + (first - 1), carves.count, carves.carves.begin());
  return carves;
}

}  // namespace hapton
