#include "link/marker_request.h"

#include <algorithm>

#include "link/random_id.h"

namespace hapton {

Result<Marker> make_marker(std::string_view text) {
  if (text.empty()) return fail("a marker needs a text, such as \"trial 7\"");
  if (text.size() > MarkerText::kMaxBytes) return fail("a marker has at most {} bytes of text, not {}", MarkerText::kMaxBytes, text.size());
  if (!MarkerText::is_valid(text)) return fail("a marker is UTF-8 without line ends and other control characters");
  Marker marker{.request = static_cast<std::uint32_t>(make_random_id()) | 1U};
  std::copy(text.begin(), text.end(), marker.text.begin());
  return marker;
}

Result<std::uint64_t> read_reply(const MarkerReply& reply) {
  switch (reply.status) {
    case MarkerStatus::recorded:
      return reply.sample;
    case MarkerStatus::no_recording:
      return fail("the hub does not record; start io_node with --record FILE");
    case MarkerStatus::too_many:
      return fail("the hub rejected the marker: more than 50 a second");
    case MarkerStatus::no_room:
      break;
  }
  return fail("the recording had no room for the marker: the hub's machine is overloaded");
}

}  // namespace hapton
