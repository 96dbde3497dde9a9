#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "link/haptics_source.h"
#include "link/messages.h"
#include "link/sequence_tracker.h"
#include "runtime/clock.h"

namespace hapton {

// Which carves and undos a program has received from the haptics node, and which it has to request again. It stores none of them: one that
// comes before a missing one is passed on at once and once more later, which changes nothing in a CarveList. RT: yes. Threads: one.
class KnownCarves {
 public:
  // A choice: ten requests a second cost nothing, and a picture lacks a lost carve for little longer than this.
  static constexpr std::int64_t kRequestEveryNs = 100 * kNanosecondsPerMillisecond;

  struct News {
    bool starts_anew = false;  // all earlier carves are void: the objects are whole again, except for `carves`
    std::span<const Carves::One> carves = {};
    std::uint32_t first = 0;  // serial of the first of `carves`
  };
  // Returns what of a message is to be applied. arrival: HubClient::last_arrival() of it. The span is valid as long as the message.
  News take(const Carves& carves, Arrival arrival) noexcept;

  // A request for the missing entries, if one is due.
  std::optional<CarveStatus> take_request(std::int64_t now_ns) noexcept;

  std::uint32_t source() const noexcept { return source_; }      // as in Carves; 0: nothing was received
  std::uint32_t complete() const noexcept { return complete_; }  // all up to this serial have arrived
  std::uint32_t newest() const noexcept { return newest_; }      // newest serial of the haptics node that is known

 private:
  HapticsSource processes_;
  std::uint32_t source_ = 0;
  std::uint32_t complete_ = 0;
  std::uint32_t newest_ = 0;
  std::int64_t next_request_ns_ = 0;
};

}  // namespace hapton
