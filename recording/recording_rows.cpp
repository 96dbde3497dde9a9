#include "recording/recording_rows.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

// A moment up to this far ahead is reached by reading on, a later one by a seek; a free choice.
constexpr double kReadOnS = 2.0;
// A sample may be recorded up to this long after it was taken; a seek begins that much earlier, so that it is found.
constexpr double kSlackS = 0.3;

bool has_reply(const CycleRow& row) { return row.p_WP.allFinite(); }

}  // namespace

RecordingRows::RecordingRows(SessionReader reader, const RecordingIndex& index)
    : index_(&index),
      accepted_(reader.header().session),
      reader_(std::make_unique<SessionReader>(std::move(reader))),
      rows_(std::make_unique<std::deque<CycleRow>>()) {}

Result<RecordingRows> RecordingRows::open(const std::filesystem::path& file, const RecordingIndex& index) {
  auto reader = SessionReader::open(file);
  if (!reader) return tl::unexpected(reader.error());
  return RecordingRows(std::move(*reader), index);
}

void RecordingRows::jump(double t_s) {
  rows_->clear();
  from_s_ = t_s - 2.0 * kBeforeS;
  is_at_end_ = false;
  reader_->seek(index_->find_position(from_s_ - kSlackS));
  accepted_ = AcceptedDatagrams(reader_->header().session);
  table_ = std::make_unique<CycleTable>(
      reader_->header().start_ns,
      [rows = rows_.get()](const CycleRow& row) {
        rows->push_back(row);
        if (rows->size() > 1) rows->back().sample_t_s = std::max(row.sample_t_s, (*rows)[rows->size() - 2].sample_t_s);
      },
      kLatestS);
}

bool RecordingRows::read_entry() {
  SessionEntry entry;
  if (is_at_end_ || !reader_->next(entry)) {
    if (!is_at_end_) table_->finish();
    is_at_end_ = true;
    return false;
  }
  Datagram datagram;
  const bool is_readable = !entry.datagram.empty() && codec_.decode(entry.datagram, datagram) == DecodeStatus::ok;
  table_->add(entry, is_readable && accepted_.accept(entry, datagram) ? &datagram : nullptr);
  return true;
}

// Reads until rows_ has a row later than t_s, or the file ends. rows_ then also has the file's rows of the last kBeforeS before t_s.
void RecordingRows::go_to(double t_s) {
  const bool is_near = table_ != nullptr && t_s - kBeforeS >= from_s_ && (rows_->empty() || t_s <= rows_->back().sample_t_s + kReadOnS);
  if (!is_near) jump(t_s);
  while ((rows_->empty() || rows_->back().sample_t_s <= t_s) && read_entry()) {
  }
  while (rows_->size() > 1 && (*rows_)[1].sample_t_s < t_s - 2.0 * kBeforeS) {
    from_s_ = std::max(from_s_, (*rows_)[1].sample_t_s);
    rows_->pop_front();
  }
}

std::deque<CycleRow>::const_iterator RecordingRows::find_after(double t_s) const {
  return std::upper_bound(rows_->begin(), rows_->end(), t_s, [](double t, const CycleRow& row) { return t < row.sample_t_s; });
}

const CycleRow* RecordingRows::at(double t_s) {
  go_to(t_s);
  const auto after = find_after(t_s);
  // If the recording has a gap, or other entries after its last sample, the sample before t_s may be farther back.
  if (after == rows_->begin() && t_s > index_->begin_s()) {
    const auto spans = index_->spans_between(index_->begin_s(), t_s);
    if (!spans.empty()) {
      const double before_s = RecordingIndex::kSpanS * static_cast<double>(spans.back().number);
      jump(before_s);
      while ((rows_->empty() || rows_->back().sample_t_s <= t_s) && read_entry()) {
      }
    }
  }
  if (rows_->empty()) return nullptr;
  const auto found = find_after(t_s);
  return found == rows_->begin() ? &*found : &*std::prev(found);
}

const CycleRow* RecordingRows::replied_at(double t_s, double max_age_s) {
  go_to(t_s);
  for (auto one = find_after(t_s); one != rows_->begin();) {
    --one;
    if (one->sample_t_s < t_s - max_age_s) break;
    if (has_reply(*one)) return &*one;
  }
  return nullptr;
}

std::optional<double> RecordingRows::next_s(double t_s) {
  go_to(t_s);
  const auto after = find_after(t_s);
  return after != rows_->end() ? std::optional(after->sample_t_s) : std::nullopt;
}

std::optional<double> RecordingRows::previous_s(double t_s) {
  // The newest row until the next smaller double is the previous row.
  const double before_s = std::nextafter(t_s, -std::numeric_limits<double>::infinity());
  if (before_s < index_->begin_s()) return std::nullopt;
  const CycleRow* row = at(before_s);
  return row != nullptr && row->sample_t_s < t_s ? std::optional(row->sample_t_s) : std::nullopt;
}

std::vector<double> RecordingRows::round_trips(double t_s) {
  go_to(t_s);
  std::vector<double> trips;
  for (auto one = find_after(t_s); one != rows_->begin();) {
    --one;
    if (one->sample_t_s < t_s - kBeforeS) break;
    if (one->round_trip_s >= 0.0) trips.push_back(one->round_trip_s);
  }
  std::sort(trips.begin(), trips.end());
  return trips;
}

}  // namespace hapton
