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
#include "recording/accepted_datagrams.h"
#include "recording/cycle_table.h"
#include "recording/recording_index.h"

namespace hapton {

// The samples of a recording around a moment. Only the rows near that moment are in memory: for a moment shortly after them the file is
// read on, otherwise from a position shortly before it. Times as in RecordingIndex, never decreasing from row to row. RT: no. Threads: one.
class RecordingRows {
 public:
  // The shortest time for which rows are kept after their own time, for statistics and for single steps backwards.
  static constexpr double kBeforeS = 1.0;
  // latest_s of the CycleTable: a row does not wait longer for its force, and a jump reads on for that long where no force came.
  static constexpr double kLatestS = 0.5;

  // Pre: the index, of the same file, outlives it. Error: see SessionReader::open.
  static Result<RecordingRows> open(const std::filesystem::path& file, const RecordingIndex& index);

  // The newest sample until that time, or else the first of all. Null only if the file has changed. Valid until the next call.
  const CycleRow* at(double t_s);
  // The newest sample until that time whose force came, at most max_age_s old; null: there is none. Pre: max_age_s is at most kBeforeS.
  const CycleRow* replied_at(double t_s, double max_age_s);
  // Times of the first sample after t_s, and of the last one before it; none: there is none.
  std::optional<double> next_s(double t_s);
  std::optional<double> previous_s(double t_s);
  // The round trips of the last kBeforeS, in ascending order, s.
  std::vector<double> round_trips(double t_s);

 private:
  RecordingRows(SessionReader reader, const RecordingIndex& index);
  void go_to(double t_s);
  void jump(double t_s);
  bool read_entry();
  // The first row later than t_s. Pre: go_to(t_s).
  std::deque<CycleRow>::const_iterator find_after(double t_s) const;

  const RecordingIndex* index_;
  AcceptedDatagrams accepted_;
  std::unique_ptr<SessionReader> reader_;
  Codec codec_;
  std::unique_ptr<CycleTable> table_;
  std::unique_ptr<std::deque<CycleRow>> rows_;               // table_ keeps its address, also when this object is moved
  double from_s_ = std::numeric_limits<double>::infinity();  // samples before this time are not in rows_
  bool is_at_end_ = false;
};

}  // namespace hapton
