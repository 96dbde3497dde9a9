#include "link/refusal_watch.h"

namespace hapton {

std::string_view describe(Refusal refusal) noexcept {
  switch (refusal) {
    case Refusal::malformed:
      return "datagrams of no known form";
    case Refusal::wrong_version:
      return "datagrams of another protocol version";
    case Refusal::wrong_key:
      return "handshakes with another key or none";
    case Refusal::replayed_handshake:
      return "replayed handshakes";
    case Refusal::too_many_handshakes:
      return "handshakes beyond the rate limit";
    case Refusal::no_place:
      return "handshakes while every place is taken";
    case Refusal::unknown_session:
      return "datagrams of no session";
    case Refusal::replayed:
      return "replayed datagrams";
    case Refusal::forged:
      return "forged datagrams";
    case Refusal::oversized:
      return "datagrams too long to be ours";
  }
  return "datagrams";
}

std::optional<Flood> RefusalWatch::take(std::int64_t now_ns) noexcept {
  if (!has_begun_) since_ns_ = now_ns;
  has_begun_ = true;
  if (now_ns - since_ns_ < kEveryNs) return std::nullopt;
  std::optional<Flood> flood;
  std::uint64_t noted = 0;
  for (const Seen& seen : seen_) noted += seen.count;
  // Each of those noted stands for so many.
  const double weight = noted == 0 ? 0.0 : static_cast<double>(noted + kept_out_) / static_cast<double>(noted);
  for (std::size_t n = 0; n < kRefusals; ++n) {
    const auto refusal = static_cast<Refusal>(n);
    const double per_second = 1e9 * weight * static_cast<double>(seen_[n].count) / static_cast<double>(now_ns - since_ns_);
    if (per_second <= is_flood_above(refusal) || (flood && per_second <= flood->per_second)) continue;
    flood = Flood{refusal, seen_[n].from, seen_[n].is_from_several, per_second, kept_out_ > noted};
  }
  seen_ = {};
  kept_out_ = 0;
  since_ns_ = now_ns;
  return flood;
}

}  // namespace hapton
