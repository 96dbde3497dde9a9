#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/sculpt/sculpture.h"
#include "link/messages.h"
#include "runtime/clock.h"

namespace hapton {

// Keeps the carves and undos of this process and determines which ones are sent when: new ones at once, and again what vision nodes
// request, in datagrams of many, at most 200 a second. New ones and requested ones take turns, so that neither waits for the other.
//
// A datagram may be lost: each one repeats the newest ones of the one before, and the last ones of a motion come twice more. What is
// missing all the same, a vision node requests; one that joins late requests everything. Requests only set a place to go on from, so any
// number of them costs no more than one. RT: yes, except construction. Threads: one.
class CarveSender {
 public:
  static constexpr std::size_t kMax = Sculpture::kMaxCarves;  // 44 MB
  static constexpr std::int64_t kEveryNs = 5 * kNanosecondsPerMillisecond;
  // So most losses need no request (decision 161): new ones are sent with so many before them, the last ones twice more.
  static constexpr std::uint32_t kOverlap = 8;
  static constexpr std::int64_t kAgainNs = 50 * kNanosecondsPerMillisecond;
  static constexpr int kTimesAgain = 2;

  // source: as in Carves, odd. Takes the memory for `most` carves.
  explicit CarveSender(std::uint32_t source, std::size_t most = kMax);

  // The next one, whose serial is newest() + 1, or 1 where other bodies have taken the place of those carved before: for vision nodes they
  // are those of another process. Any other serial, and what there is no memory for, is left out.
  void note(const MadeCarve& made) noexcept;
  bool is_full() const noexcept { return carves_.size() == most_; }
  std::uint32_t source() const noexcept { return source_; }
  std::uint32_t newest() const noexcept { return static_cast<std::uint32_t>(carves_.size()); }

  // Of another process: left out.
  void accept(const CarveStatus& status) noexcept;

  // The datagram that is due, if any.
  std::optional<Carves> take_due(std::int64_t now_ns) noexcept;
  // Without carves: how many there are, for whoever missed the last ones or knows another process.
  Carves announce() const noexcept;

 private:
  void begin_anew() noexcept;
  Carves gather(std::uint32_t first, std::uint32_t last) const noexcept;
  Carves take_fresh(std::int64_t now_ns) noexcept;
  Carves take_requested() noexcept;
  std::uint32_t find_tail() const noexcept;

  std::uint32_t source_;
  std::size_t most_;
  std::vector<Carves::One> carves_;   // by serial, from 1
  std::uint32_t next_fresh_ = 1;      // serial of the first one not sent yet
  std::uint32_t next_requested_ = 0;  // from here up to next_fresh_ they are sent again; 0: none
  bool was_fresh_ = false;
  std::int64_t next_ns_ = 0;
  std::int64_t again_ns_ = 0;
  int times_again_ = 0;
};

}  // namespace hapton
