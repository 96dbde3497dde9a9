#include "link/known_carves.h"

#include <algorithm>

namespace hapton {

KnownCarves::News KnownCarves::take(const Carves& carves, Arrival arrival) noexcept {
  const HapticsSource::Verdict verdict = processes_.note(carves.source, arrival);
  if (verdict == HapticsSource::Verdict::old) return {};
  News news;
  if (verdict == HapticsSource::Verdict::other) {
    news.starts_anew = true;
    source_ = carves.source;
    complete_ = newest_ = 0;
  }
  newest_ = std::max(newest_, carves.newest);
  if (carves.count == 0) return news;
  const std::uint32_t last = carves.first + (carves.count - 1);
  if (last <= complete_) return news;
  // The first carves of this message may be known already.
  const std::uint32_t known = complete_ >= carves.first ? complete_ - carves.first + 1 : 0;
  news.carves = std::span(carves.carves).subspan(known, carves.count - known);
  news.first = carves.first + known;
  if (carves.first <= complete_ + 1) complete_ = last;
  return news;
}

std::optional<CarveStatus> KnownCarves::take_request(std::int64_t now_ns) noexcept {
  if (complete_ >= newest_ || now_ns < next_request_ns_) return std::nullopt;
  next_request_ns_ = now_ns + kRequestEveryNs;
  return CarveStatus{.source = source_, .complete = complete_};
}

}  // namespace hapton
