#pragma once

#include <deque>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "link/codec.h"
#include "link/session_reader.h"
#include "session/joined_table.h"
#include "session/session_index.h"

namespace hapton {

// The samples of a recording around a moment. Of the file only what is near that moment is in memory: going on reads what is new, a jump
// reads from a place shortly before. Times as in SessionIndex, never falling from one row to the next. RT: no. Threads: one.
class SessionRows {
 public:
  // So much before the moment is kept, for statistics and for the way back.
  static constexpr double kBeforeS = 1.0;
  // A force that comes later is not waited for.
  static constexpr double kLatestS = 0.5;

  // Pre: the index, of the same file, outlives it. Error: see SessionReader::open.
  static Result<SessionRows> open(const std::filesystem::path& file, const SessionIndex& index);

  // The newest sample at that time, or the first of all. Null only if the file has changed. Valid until the next call.
  const JoinedRow* at(double t_s);
  // The newest one that has a reply, if that is not older than most_age_s; null: none.
  const JoinedRow* replied_at(double t_s, double most_age_s);
  // Of the sample after, or before, those of that time; none: it is the last, or the first.
  std::optional<double> next_s(double t_s);
  std::optional<double> previous_s(double t_s);
  // Round trips in the second before, sorted, s.
  std::vector<double> round_trips(double t_s);

 private:
  SessionRows(SessionReader reader, const SessionIndex& index);
  void go_to(double t_s);
  void jump(double t_s);
  bool read_entry();
  // The first row later than that. Pre: go_to(t_s).
  std::deque<JoinedRow>::const_iterator find_after(double t_s) const;

  const SessionIndex* index_;
  std::unique_ptr<SessionReader> reader_;
  Codec codec_;
  std::unique_ptr<JoinedTable> table_;
  std::unique_ptr<std::deque<JoinedRow>> rows_;              // at an address that the table may keep
  double from_s_ = std::numeric_limits<double>::infinity();  // what is before that was not read
  bool is_at_end_ = false;
};

}  // namespace hapton
