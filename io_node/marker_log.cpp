#include "io_node/marker_log.h"

#include <algorithm>
#include <string_view>

namespace hapton {

void MarkerLog::accept(const Marker& marker, const PeerEvent& event, std::uint64_t sample, std::int64_t now_ns) noexcept {
  Source& source = sources_[event.peer];
  const auto known =
      std::find_if(source.replies.begin(), source.replies.end(), [&](const MarkerReply& reply) { return reply.request == marker.request; });
  const bool is_new = known == source.replies.end();
  if (!source.markers.take(now_ns)) {
    stats_.markers_rejected += is_new ? 1 : 0;
    if (!source.rejections.take(now_ns)) return;
    peers_.send_to(event.peer, is_new ? MarkerReply{marker.request, sample, MarkerStatus::too_many} : *known);
    return;
  }
  const MarkerReply reply = is_new ? record(marker, event.role, sample, now_ns) : *known;
  if (is_new) source.replies[source.count++ % kRememberedReplies] = reply;
  peers_.send_to(event.peer, reply);
}

MarkerReply MarkerLog::record(const Marker& marker, NodeRole role, std::uint64_t sample, std::int64_t now_ns) noexcept {
  MarkerReply reply{marker.request, sample, MarkerStatus::no_recording};
  const std::string_view text(marker.text.data());
  if (tap_ != nullptr) reply.status = tap_->on_marker({sample, role, text}, now_ns);
  ++(reply.status == MarkerStatus::recorded ? stats_.markers : stats_.markers_rejected);
  return reply;
}

}  // namespace hapton
