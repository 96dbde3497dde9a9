#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "link/messages.h"
#include "link/move_source.h"
#include "link/sequence_tracker.h"
#include "runtime/clock.h"

namespace hapton {

// Which carves and undos a program has received from the haptics node, and which it has to request again. It keeps none: an entry that came
// early is passed on at once and once more later, which changes nothing in a CarveList. RT: yes. Threads: one.
class KnownCarves {
 public:
  // A choice: ten requests a second cost nothing, and a picture lacks what was lost no longer.
  static constexpr std::int64_t kRequestEveryNs = 100 * kNanosecondsPerMillisecond;

  struct News {
    bool starts_anew = false;  // the carves before are void: the objects are whole again, but for those here
    std::span<const Carves::One> carves = {};
    std::uint32_t first = 0;  // serial of the first one of these
  };
  // What of a message is to be applied. arrival: as HubClient::last_arrival of it. The span is valid as long as the message.
  News take(const Carves& carves, Arrival arrival) noexcept;

  // A request for the missing ones, when one is due.
  std::optional<CarveStatus> take_request(std::int64_t now_ns) noexcept;

  std::uint32_t source() const noexcept { return source_; }      // as in Carves; 0: nothing was received
  std::uint32_t complete() const noexcept { return complete_; }  // all up to this serial have come
  std::uint32_t newest() const noexcept { return newest_; }      // of the haptics node, as far as known

 private:
  MoveSource processes_;
  std::uint32_t source_ = 0;
  std::uint32_t complete_ = 0;
  std::uint32_t newest_ = 0;
  std::int64_t next_request_ns_ = 0;
};

}  // namespace hapton
