#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "link/messages.h"

namespace hapton {

// The markers that a key of the window sets in the recording: "key 1", "key 2" and so on. A marker is sent again until its reply comes,
// as a datagram may be lost. Times: any one monotonic clock, ns. RT: no.
class MarkerKey {
 public:
  static constexpr std::int64_t kRepeatNs = 100'000'000;          // between two sendings of a marker; a free choice
  static constexpr std::int64_t kReplyTimeoutNs = 2'000'000'000;  // then the marker is not sent any more; a free choice
  static constexpr std::size_t kMaxWaiting = 32;                  // more presses are dropped

  void press(std::int64_t now_ns);
  // The next marker to send now, if any.
  std::optional<Marker> take_due(std::int64_t now_ns);
  // Takes a reply. Returns a line for the log; none: the reply is not to a marker that waits for one.
  std::optional<std::string> accept(const MarkerReply& reply);

 private:
  struct Waiting {
    Marker marker;
    std::int64_t next_ns = 0;
    std::int64_t end_ns = 0;
  };

  std::vector<Waiting> waiting_;
  std::uint32_t presses_ = 0;
};

}  // namespace hapton
