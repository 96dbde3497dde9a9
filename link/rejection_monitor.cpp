#include "link/rejection_monitor.h"

namespace hapton {

std::string_view describe(Rejection rejection) noexcept {
  switch (rejection) {
    case Rejection::malformed:
      return "malformed datagrams";
    case Rejection::wrong_version:
      return "datagrams of another protocol version";
    case Rejection::wrong_key:
      return "handshakes with another key or none";
    case Rejection::replayed_handshake:
      return "replayed handshakes";
    case Rejection::too_many_handshakes:
      return "handshakes beyond the rate limit";
    case Rejection::no_slot:
      return "handshakes above the hub's capacity";
    case Rejection::unknown_session:
      return "datagrams of an unknown session";
    case Rejection::replayed:
      return "replayed datagrams";
    case Rejection::forged:
      return "forged datagrams";
    case Rejection::oversized:
      return "oversized datagrams";
  }
  return "datagrams";
}

std::optional<Flood> RejectionMonitor::take(std::int64_t now_ns) noexcept {
  if (!has_begun_) since_ns_ = now_ns;
  has_begun_ = true;
  if (now_ns - since_ns_ < kEveryNs) return std::nullopt;
  std::optional<Flood> flood;
  std::uint64_t noted = 0;
  for (const NotedRejections& of_kind : rejections_) noted += of_kind.count;
  // Each noted rejection stands for this many, counting those that the kernel filtered.
  const double weight = noted == 0 ? 0.0 : static_cast<double>(noted + filtered_) / static_cast<double>(noted);
  for (std::size_t n = 0; n < kRejections; ++n) {
    const auto rejection = static_cast<Rejection>(n);
    const double per_second = 1e9 * weight * static_cast<double>(rejections_[n].count) / static_cast<double>(now_ns - since_ns_);
    if (per_second <= is_flood_above(rejection) || (flood && per_second <= flood->per_second)) continue;
    flood = Flood{rejection, rejections_[n].from, rejections_[n].is_from_several, per_second, filtered_ > noted};
  }
  rejections_ = {};
  filtered_ = 0;
  since_ns_ = now_ns;
  return flood;
}

}  // namespace hapton
