#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/sculpt/sculpture.h"
#include "link/messages.h"
#include "runtime/clock.h"

namespace hapton {

// Keeps the carves and undos (entries) of this process and determines when which entries are sent: new ones at once, others again if vision
// nodes request them. A datagram has many entries; at most 200 datagrams a second are sent. New and requested entries take turns.
//
// A datagram may be lost. So each one repeats the newest entries of the one before, and the last entries of a motion are sent twice more. A
// vision node requests what it still lacks; one that joins late requests everything. A request only sets the serial from which entries are
// sent again, so many requests cost no more than one. RT: yes, except construction. Threads: one.
class CarveSender {
 public:
  static constexpr std::size_t kMax = Sculpture::kMaxCarves;  // 44 MB
  static constexpr std::int64_t kEveryNs = 5 * kNanosecondsPerMillisecond;
  // Entries repeated before new ones, and times that the last ones are sent again: most losses then need no request (decision 161).
  static constexpr std::uint32_t kOverlap = 8;
  static constexpr std::int64_t kRepeatNs = 50 * kNanosecondsPerMillisecond;
  static constexpr int kRepeats = 2;

  // source: as in Carves, odd. Takes memory for `max_entries` entries.
  explicit CarveSender(std::uint32_t source, std::size_t max_entries = kMax);

  // Adds the next entry. Its serial is newest() + 1, or 1 if other bodies have taken the place of those carved before: then the source
  // changes, as if it were another process. An entry with another serial, or for which there is no memory, is left out.
  void note(const MadeCarve& made) noexcept;
  bool is_full() const noexcept { return carves_.size() == max_entries_; }
  std::uint32_t source() const noexcept { return source_; }
  std::uint32_t newest() const noexcept { return static_cast<std::uint32_t>(carves_.size()); }

  // Takes the report of a vision node, which tells what it has received. A report about another process is ignored.
  void accept(const CarveStatus& status) noexcept;

  // The datagram that is due, if any.
  std::optional<Carves> take_due(std::int64_t now_ns) noexcept;
  // A message without carves that tells how many there are, for nodes that missed the last ones or know those of another process.
  Carves announce() const noexcept;

 private:
  void begin_anew() noexcept;
  Carves gather(std::uint32_t first, std::uint32_t last) const noexcept;
  Carves take_fresh(std::int64_t now_ns) noexcept;
  Carves take_requested() noexcept;
  std::uint32_t find_tail() const noexcept;

  std::uint32_t source_;
  std::size_t max_entries_;
  std::vector<Carves::One> carves_;   // the index is serial - 1
  std::uint32_t next_fresh_ = 1;      // serial of the first entry that has not been sent yet
  std::uint32_t next_requested_ = 0;  // entries from this serial to before next_fresh_ are sent again; 0: none
  bool last_was_fresh_ = false;
  std::int64_t next_send_ns_ = 0;
  std::int64_t repeat_ns_ = 0;
  int repeats_left_ = 0;
};

}  // namespace hapton
