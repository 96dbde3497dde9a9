#include "vision_node/time_line.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace hapton {
namespace {

// More than the rounding error of a double for a time of several days, less than the time between two samples.
constexpr double kSameMomentS = 1e-6;

int column_of(const RecordingIndex& index, double t_s) {
  return std::min(kTimeLineColumns - 1, static_cast<int>(find_time_line_share(index, t_s) * kTimeLineColumns));
}

std::vector<TimeLineShown::Band> make_bands(const RecordingIndex& index) {
  std::vector<TimeLineShown::Band> bands;
  int last = -2;
  constexpr double kWidth = 1.0 / kTimeLineColumns;  // width of a column, as a share of the line
  for (const RecordingSpan& span : index.spans()) {
    if (!span.is_contact) continue;
    const double from_s = RecordingIndex::kSpanS * static_cast<double>(span.number);
    const int from = column_of(index, from_s);
    const int to = column_of(index, from_s + RecordingIndex::kSpanS);
    if (from > last + 1 || bands.empty()) bands.push_back({kWidth * from, 0.0});
    last = std::max(last, to);
    bands.back().to = kWidth * (last + 1);
  }
  return bands;
}

std::vector<TimeLineShown::Tick> make_ticks(const RecordingIndex& index) {
  std::vector<TimeLineShown::Tick> ticks;
  int last[2] = {-1, -1};
  for (const RecordingMark& mark : index.marks()) {
    const int column = column_of(index, mark.t_s);
    if (column == last[mark.is_fault ? 1 : 0]) continue;
    last[mark.is_fault ? 1 : 0] = column;
    ticks.push_back({find_time_line_share(index, mark.t_s), mark.is_fault});
  }
  return ticks;
}

}  // namespace

TimeLineShown make_time_line(const RecordingIndex& index) {
  return {make_bands(index), make_ticks(index), describe_time(index.begin_s()), describe_time(index.end_s())};
}

double find_time_line_share(const RecordingIndex& index, double t_s) {
  const double length_s = index.end_s() - index.begin_s();
  return length_s > 0.0 ? std::clamp((t_s - index.begin_s()) / length_s, 0.0, 1.0) : 0.0;
}

double find_time_line_moment(const RecordingIndex& index, double share) {
  return index.begin_s() + std::clamp(share, 0.0, 1.0) * (index.end_s() - index.begin_s());
}

double TimeLinePlace::share_at(double x_px) const { return width_px > 0.0 ? std::clamp((x_px - left_px) / width_px, 0.0, 1.0) : 0.0; }

TimeLinePlace place_time_line(PictureSize size) {
  TimeLinePlace place;
  const double strip_height = std::clamp(0.055 * size.height_px, 22.0, 80.0);
  place.strip_height_px = strip_height;
  place.left_px = 0.07 * size.width_px;
  place.width_px = size.width_px - 2.0 * place.left_px;
  place.height_px = 0.34 * strip_height;
  place.bottom_px = 0.5 * (strip_height - place.height_px);
  return place;
}

std::string describe_time(double t_s, int decimals) {
  const double unit = std::pow(10.0, decimals);
  const double rounded_s = std::round(std::abs(t_s) * unit) / unit;
  const auto minutes = static_cast<long long>(rounded_s / 60.0);
  const double seconds = rounded_s - 60.0 * static_cast<double>(minutes);
  const std::string sign = t_s < 0.0 && rounded_s > 0.0 ? "-" : "";
  const int width = decimals > 0 ? 3 + decimals : 2;
  if (minutes < 60) return fmt::format("{}{}:{:0{}.{}f}", sign, minutes, seconds, width, decimals);
  return fmt::format("{}{}:{:02}:{:0{}.{}f}", sign, minutes / 60, minutes % 60, seconds, width, decimals);
}

const RecordingMark* find_next_mark(const RecordingIndex& index, double t_s) {
  const auto found = std::ranges::upper_bound(index.marks(), t_s + kSameMomentS, {}, &RecordingMark::t_s);
  return found != index.marks().end() ? &*found : nullptr;
}

const RecordingMark* find_previous_mark(const RecordingIndex& index, double t_s) {
  const auto found = std::ranges::lower_bound(index.marks(), t_s - kSameMomentS, {}, &RecordingMark::t_s);
  return found != index.marks().begin() ? &*std::prev(found) : nullptr;
}

}  // namespace hapton
