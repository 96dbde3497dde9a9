#include "vision_node/marker_key.h"

#include <algorithm>

#include "link/marker_request.h"
#include "runtime/log.h"

namespace hapton {

void MarkerKey::press(std::int64_t now_ns) {
  if (waiting_.size() == kMaxWaiting) return;
  if (const auto marker = make_marker(fmt::format("key {}", ++presses_))) waiting_.push_back({*marker, now_ns, now_ns + kReplyTimeoutNs});
}

std::optional<Marker> MarkerKey::take_due(std::int64_t now_ns) {
  std::erase_if(waiting_, [&](const Waiting& one) {
    if (now_ns < one.end_ns) return false;
    log_warning("{} not marked: no reply from the hub", one.marker.text.data());
    return true;
  });
  const auto due = std::find_if(waiting_.begin(), waiting_.end(), [&](const Waiting& one) { return now_ns >= one.next_ns; });
  if (due == waiting_.end()) return std::nullopt;
  due->next_ns = now_ns + kRepeatNs;
  return due->marker;
}

std::optional<std::string> MarkerKey::accept(const MarkerReply& reply) {
  const auto waiting =
      std::find_if(waiting_.begin(), waiting_.end(), [&](const Waiting& one) { return one.marker.request == reply.request; });
  if (waiting == waiting_.end()) return std::nullopt;
  const auto sample = read_reply(reply);
  const std::string name = waiting->marker.text.data();
  waiting_.erase(waiting);
  return sample ? fmt::format("marked sample {}: {}", *sample, name) : fmt::format("{} not marked: {}", name, sample.error().what);
}

}  // namespace hapton
