#include "vision_node/recorded_state.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/math/rotation_vector.h"
#include "vision_node/time_line.h"

namespace hapton {
namespace {

// The oldest force that is shown: as in the hub, the command timeout of the governor.
constexpr double kMaxReplyAgeS = 0.02;
constexpr double kMarkShownS = 2.0;  // how long the HUD shows a marker or a fault: long enough to read

float microseconds_at(const std::vector<double>& sorted_s, double share) {
  if (sorted_s.empty()) return 0.0F;
  const auto at = static_cast<std::size_t>(share * static_cast<double>(sorted_s.size() - 1));
  return static_cast<float>(1e6 * sorted_s[at]);
}

ProbeState make_state(const CycleRow& row) {
  ProbeState state;
  state.sample = row.sample;
  state.sample_time_ns = static_cast<std::int64_t>(std::llround(1e9 * row.sample_t_s));
  state.p_WD = row.p_WD;
  state.q_WT = row.q_WT;
  state.buttons = row.buttons;
  state.contact = row.is_contact;
  state.object = row.object;
  state.scene_time_ns = row.scene_time_ns;
  if (row.p_WP.allFinite()) state.visual_offset_m = row.p_WP - row.p_WD;
  if (row.q_WP.coeffs().allFinite()) state.visual_turn = turn_between(row.q_WT, row.q_WP);
  return state;
}

std::vector<CurvePoint> make_curve(std::span<const RecordingSpan> spans, double t_s, double (*value)(const RecordingSpan&)) {
  std::vector<CurvePoint> points;
  for (const RecordingSpan& span : spans) {
    const double age_s = t_s - RecordingIndex::kSpanS * static_cast<double>(span.number);
    if (value(span) >= 0.0 && age_s <= RecentCurve::kSeconds) points.push_back({std::max(0.0, age_s), value(span)});
  }
  return points;
}

}  // namespace

std::optional<RecordedState> find_recorded_state(const RecordingIndex& index, RecordingRows& rows, double t_s) {
  const CycleRow* newest = rows.at(t_s);
  if (newest == nullptr) return std::nullopt;
  const Vec3 written_n = newest->written_n;
  const Vec3 written_nm = newest->written_nm;
  RecordedState recorded;
  recorded.state = make_state(*newest);
  std::optional<std::uint32_t> view = newest->view_revision;
  if (const CycleRow* replied = rows.replied_at(t_s, kMaxReplyAgeS)) {
    recorded.has_reply = true;
    view = replied->view_revision;
    recorded.state = make_state(*replied);
  }
  ProbeState& state = recorded.state;
  recorded.X_WS = index.find_view(view, t_s);
  state.force_n = written_n;
  state.torque_nm = written_nm;
  state.servo_rate_hz = static_cast<float>(find_recorded_rate_hz(index, t_s));
  const std::vector<double> trips = rows.round_trips(t_s);
  state.round_trip_p50_us = microseconds_at(trips, 0.5);
  state.round_trip_p99_us = microseconds_at(trips, 0.99);
  const DeviceNotice* notice = index.find_notice(t_s);
  if (notice != nullptr) {
    state.status = notice->status;
    state.energy_percent = notice->energy_percent;
    state.force_limit_n = notice->force_limit_n;
  } else if (!recorded.has_reply) {
    state.status = ProbeStatus::no_haptics;
  }
  return recorded;
}

double find_recorded_rate_hz(const RecordingIndex& index, double t_s) {
  // Counts whole spans only: those of the last second. In the first second of the recording, those of this first second.
  const double to_s = std::max(t_s, std::min(index.begin_s() + 1.0, index.end_s())) - RecordingIndex::kSpanS;
  const double from_s = std::max(to_s - 1.0 + RecordingIndex::kSpanS, index.begin_s() + RecordingIndex::kSpanS);
  const auto spans = index.spans_between(from_s, to_s);
  if (spans.empty()) return 0.0;
  double samples = 0.0;
  for (const RecordingSpan& span : spans) samples += span.samples;
  return samples / (RecordingIndex::kSpanS * static_cast<double>(spans.back().number - spans.front().number + 1));
}

std::vector<PlotContent> make_recorded_plots(const RecordingIndex& index, double t_s) {
  const auto spans = index.spans_between(t_s - RecentCurve::kSeconds, t_s);
  const DeviceNotice* notice = index.find_notice(t_s);
  const double limit_n = notice != nullptr && std::isfinite(notice->force_limit_n) ? std::max(0.0F, notice->force_limit_n) : 0.0;
  const auto force = make_curve(spans, t_s, [](const RecordingSpan& span) { return static_cast<double>(span.written_n); });
  const auto trip = make_curve(spans, t_s, [](const RecordingSpan& span) { return 1e3 * static_cast<double>(span.round_trip_s); });
  return {make_plot(force, "force", "N", limit_n, kMinTopN), make_plot(trip, "round trip", "ms", 0.0, 1.0)};
}

std::string describe_recording(const std::string& name, const SessionPlayer& player, std::uint64_t sample) {
  return fmt::format("recording {}   {} of {}   sample {}   {:g}x{}", name, describe_time(player.moment_s(), 3),
                     describe_time(player.end_s(), 3), sample, player.speed(), player.is_paused() ? ", paused" : "");
}

std::string describe_mark(const RecordingIndex& index, double t_s) {
  const auto after = std::ranges::upper_bound(index.marks(), t_s + 1e-6, {}, &RecordingMark::t_s);
  if (after == index.marks().begin()) return {};
  const RecordingMark& mark = *std::prev(after);
  if (t_s - mark.t_s > kMarkShownS) return {};
  return (mark.is_fault ? "FAULT: " : "marker: ") + mark.text;
}

}  // namespace hapton
