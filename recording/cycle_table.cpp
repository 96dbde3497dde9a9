#include "recording/cycle_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/ns_between.h"
#include "core/math/rotation_vector.h"
#include "recording/recording_entries.h"

namespace hapton {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMaxEarly = 64;  // forces that wait for their cycle, which is recorded at most a few cycles later

constexpr CycleColumn kCycleColumns[] = {
    {"t_s", "s", [](const CycleRow& r) { return r.sample_t_s; }},
    {"sample", "1", [](const CycleRow& r) { return static_cast<double>(r.sample); }},
    {"x_m", "m", [](const CycleRow& r) { return r.p_WD.x(); }},
    {"y_m", "m", [](const CycleRow& r) { return r.p_WD.y(); }},
    {"z_m", "m", [](const CycleRow& r) { return r.p_WD.z(); }},
    {"qw", "1", [](const CycleRow& r) { return r.q_WT.w(); }},
    {"qx", "1", [](const CycleRow& r) { return r.q_WT.x(); }},
    {"qy", "1", [](const CycleRow& r) { return r.q_WT.y(); }},
    {"qz", "1", [](const CycleRow& r) { return r.q_WT.z(); }},
    {"vx_m_per_s", "m/s", [](const CycleRow& r) { return r.v_WD.x(); }},
    {"vy_m_per_s", "m/s", [](const CycleRow& r) { return r.v_WD.y(); }},
    {"vz_m_per_s", "m/s", [](const CycleRow& r) { return r.v_WD.z(); }},
    {"buttons", "1", [](const CycleRow& r) { return static_cast<double>(r.buttons); }},
    {"proxy_x_m", "m", [](const CycleRow& r) { return r.p_WP.x(); }},
    {"proxy_y_m", "m", [](const CycleRow& r) { return r.p_WP.y(); }},
    {"proxy_z_m", "m", [](const CycleRow& r) { return r.p_WP.z(); }},
    {"wanted_x_n", "N", [](const CycleRow& r) { return r.wanted_n.x(); }},
    {"wanted_y_n", "N", [](const CycleRow& r) { return r.wanted_n.y(); }},
    {"wanted_z_n", "N", [](const CycleRow& r) { return r.wanted_n.z(); }},
    {"written_x_n", "N", [](const CycleRow& r) { return r.written_n.x(); }},
    {"written_y_n", "N", [](const CycleRow& r) { return r.written_n.y(); }},
    {"written_z_n", "N", [](const CycleRow& r) { return r.written_n.z(); }},
    {"proxy_qw", "1", [](const CycleRow& r) { return r.q_WP.w(); }},
    {"proxy_qx", "1", [](const CycleRow& r) { return r.q_WP.x(); }},
    {"proxy_qy", "1", [](const CycleRow& r) { return r.q_WP.y(); }},
    {"proxy_qz", "1", [](const CycleRow& r) { return r.q_WP.z(); }},
    {"wanted_tx_nm", "N m", [](const CycleRow& r) { return r.wanted_nm.x(); }},
    {"wanted_ty_nm", "N m", [](const CycleRow& r) { return r.wanted_nm.y(); }},
    {"wanted_tz_nm", "N m", [](const CycleRow& r) { return r.wanted_nm.z(); }},
    {"written_tx_nm", "N m", [](const CycleRow& r) { return r.written_nm.x(); }},
    {"written_ty_nm", "N m", [](const CycleRow& r) { return r.written_nm.y(); }},
    {"written_tz_nm", "N m", [](const CycleRow& r) { return r.written_nm.z(); }},
    {"contact", "1", [](const CycleRow& r) { return std::isnan(r.wanted_n.x()) ? kUnknown
                                                    : r.is_contact             ? 1.0
                                                                               : 0.0; }},
    {"object", "1", [](const CycleRow& r) { return r.object < 0 ? kUnknown : static_cast<double>(r.object); }},
    {"local", "1", [](const CycleRow& r) { return r.is_local ? 1.0 : 0.0; }},
    {"round_trip_s", "s", [](const CycleRow& r) { return r.round_trip_s; }},
    {"late_s", "s", [](const CycleRow& r) { return r.late_s; }},
    {"missed", "1", [](const CycleRow& r) { return static_cast<double>(r.missed); }},
    {"lost", "1", [](const CycleRow& r) { return static_cast<double>(r.lost); }},
    {"scene_time_s", "s", [](const CycleRow& r) { return r.view_revision ? 1e-9 * static_cast<double>(r.scene_time_ns) : kUnknown; }},
    {"carve_serial", "1", [](const CycleRow& r) { return r.view_revision ? static_cast<double>(r.carve_serial) : kUnknown; }},
};

}  // namespace

std::span<const CycleColumn> cycle_columns() noexcept { return kCycleColumns; }

void CycleTable::add(const SessionEntry& entry, const Datagram* datagram) {
  if (entry.kind == SessionEntry::Kind::cycle) add_cycle(entry);
  if (entry.kind == SessionEntry::Kind::fault) {
    events_ += events_.empty() ? "" : " ";
    events_ += to_string(entry.fault);
  }
  if (entry.kind == SessionEntry::Kind::marker) add_marker(entry.marker);
  const auto* force = datagram != nullptr ? std::get_if<ForceCommand>(&datagram->message) : nullptr;
  if (force != nullptr && entry.kind == SessionEntry::Kind::received) add_force(*force, entry.time_ns);
  pass_complete(entry.time_ns);
}

void CycleTable::add_cycle(const SessionEntry& entry) {
  const CycleNote& cycle = entry.cycle;
  if (!cycle.device) {
    ++without_sample_;
    return;
  }
  Waiting waiting;
  waiting.time_ns = entry.time_ns;
  CycleRow& row = waiting.row;
  row.sample_t_s = seconds_between(start_ns_, cycle.device->time_ns);
  row.sample = cycle.sample;
  row.p_WD = cycle.device->p_WD;
  row.q_WT = cycle.device->q_WT;
  if (previous_sample_ && cycle.device->time_ns > previous_sample_->time_ns)
    row.v_WD = (cycle.device->p_WD - previous_sample_->p_WD) / seconds_between(previous_sample_->time_ns, cycle.device->time_ns);
  // No sample counts as lost before the first row: a flight record begins somewhere within the session.
  if (previous_sample_ && cycle.sample > previous_number_ + 1) row.lost = cycle.sample - previous_number_ - 1;
  lost_ += row.lost;
  gaps_ += row.lost > 0 ? 1 : 0;
  previous_number_ = cycle.sample;
  previous_sample_ = cycle.device;
  row.buttons = cycle.device->buttons;
  row.p_WP = row.wanted_n = row.wanted_nm = Vec3::Constant(kUnknown);
  row.q_WP.coeffs().setConstant(kUnknown);
  row.round_trip_s = kUnknown;
  row.written_n = cycle.written_n;
  row.written_nm = cycle.written_nm;
  row.late_s = seconds_between(0, cycle.late_ns);
  row.missed = cycle.missed;
  row.event = std::exchange(events_, {});
  for (; !markers_.empty() && markers_.front().first <= row.sample; markers_.pop_front())
    row.markers.push_back(std::move(markers_.front().second));
  if (cycle.local) {
    row.is_local = true;
    row.p_WP = row.p_WD + cycle.local->visual_offset_m;
    row.wanted_n = cycle.local->force_n;
    row.wanted_nm = Vec3::Zero();
    row.q_WP = row.q_WT;
    row.is_contact = !row.wanted_n.isZero(0.0);
    row.object = cycle.local->object;
    waiting.is_complete = true;
  }
  waiting_.push_back(std::move(waiting));
  for (const auto& [force, time_ns] : std::exchange(early_forces_, {})) add_force(force, time_ns);
}

// A cycle is recorded at its end, so a marker usually precedes its row. If that row was lost, the next one gets the marker.
void CycleTable::add_marker(const MarkerNote& marker) {
  const auto is_before = [](const Waiting& waiting, std::uint64_t sample) { return waiting.row.sample < sample; };
  const auto found = std::lower_bound(waiting_.begin(), waiting_.end(), marker.sample, is_before);
  if (found != waiting_.end()) {
    found->row.markers.emplace_back(marker.text);
  } else {
    markers_.emplace_back(marker.sample, marker.text);
  }
}

void CycleTable::add_force(const ForceCommand& force, std::int64_t time_ns) {
  const auto is_before = [](const Waiting& waiting, std::uint64_t sample) { return waiting.row.sample < sample; };
  const auto found = std::lower_bound(waiting_.begin(), waiting_.end(), force.echo_sample, is_before);
  if (found == waiting_.end()) {
    // The cycle of this force is still to come. A force whose cycle was lost is dropped once kMaxEarly others wait.
    early_forces_.emplace_back(force, time_ns);
    if (early_forces_.size() > kMaxEarly) early_forces_.pop_front();
    return;
  }
  if (found->row.sample != force.echo_sample || found->is_complete) return;
  CycleRow& row = found->row;
  row.p_WP = row.p_WD + force.visual_offset_m;
  row.wanted_n = force.force_n;
  row.q_WP = turn_by(force.visual_turn) * row.q_WT;
  row.wanted_nm = force.torque_nm;
  row.is_contact = force.contact;
  row.object = force.object;
  row.view_revision = force.view_revision;
  row.scene_time_ns = force.scene_time_ns;
  row.carve_serial = force.carve_serial;
  row.round_trip_s = seconds_between(force.echo_sample_time_ns, time_ns);
  found->is_complete = true;
}

void CycleTable::pass_complete(std::int64_t now_ns) {
  while (waiting_.size() > 1 && (waiting_.front().is_complete || seconds_between(waiting_.front().time_ns, now_ns) > latest_s_))
    pass_front();
}

void CycleTable::pass_front() {
  take_(waiting_.front().row);
  ++rows_;
  waiting_.pop_front();
}

void CycleTable::add_all(SessionReader& reader) {
  (void)for_each_entry(reader, [&](const SessionEntry& entry, const Datagram* datagram) -> Result<void> {
    add(entry, datagram);
    return {};
  });
  finish();
}

void CycleTable::finish() {
  // The faults of the last cycle are recorded after it.
  if (!waiting_.empty() && !events_.empty()) {
    std::string& event = waiting_.back().row.event;
    event += (event.empty() ? "" : " ") + std::exchange(events_, {});
  }
  if (!waiting_.empty())
    for (; !markers_.empty(); markers_.pop_front()) waiting_.back().row.markers.push_back(std::move(markers_.front().second));
  while (!waiting_.empty()) pass_front();
}

}  // namespace hapton
