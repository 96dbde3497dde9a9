#include "tools/session/session_summary.h"

#include <fmt/chrono.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <type_traits>
#include <utility>

#include "scene/scene_loading.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxListedFaults = 20;  // how many faults are listed, from the first; this and the next: free choices
constexpr std::size_t kMaxListedMarkers = 20;

const char* name_of(const Message& message) {
  constexpr std::array kNames = {
      "Hello",         "Welcome",     "Bye",         "DeviceState",      "ForceCommand",       "ViewTransform", "ProbeState",
      "FrameAck",      "HandTarget",  "Settings",    "HapticsSetup",     "ReportRequest",      "ReportPart",    "SceneFacts",
      "ViewRejected",  "PatchBegin",  "PatchCell",   "PatchTile",        "PatchStatus",        "LoopFacts",     "MaterialRequest",
      "MaterialState", "ObjectPose",  "Marker",      "MarkerReply",      "MoveRequest",        "MoveReply",     "ObjectMove",
      "Carves",        "CarveStatus", "PatchBody",   "PatchMaterial",    "CarveUndo",          "ShapeRequest",  "ShapeReply",
      "ObjectShape",   "ShapeStart",  "ShapeStatus", "PatchDeformation", "PatchDisplacements", "PatchStream",   "PatchEffects"};
  static_assert(kNames.size() == std::variant_size_v<Message>, "each kind of Message has its name here");
  return kNames[message.index()];
}

double in_us(double ns) { return 1e-3 * ns; }

std::string quantiles(const LatencyHistogram& h) {
  return fmt::format("p50 {:.1f} / p99 {:.1f} / p99.9 {:.1f} / max {:.1f} us, n {}", in_us(h.quantile_ns(0.5)), in_us(h.quantile_ns(0.99)),
                     in_us(h.quantile_ns(0.999)), in_us(static_cast<double>(h.max_ns())), h.count());
}

std::string date_of(std::int64_t unix_ns) {
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(static_cast<std::time_t>(unix_ns / 1'000'000'000)));
}

}  // namespace

void SessionSummary::add(const SessionEntry& entry, const Datagram* datagram) {
  if (entries_++ == 0) first_ns_ = entry.time_ns;
  last_ns_ = std::max(last_ns_, entry.time_ns);
  switch (entry.kind) {
    case SessionEntry::Kind::received:
    case SessionEntry::Kind::sent: {
      Traffic& traffic = traffic_[datagram != nullptr ? name_of(datagram->message) : "not used"];
      ++(entry.kind == SessionEntry::Kind::received ? traffic.received : traffic.sent);
      traffic.bytes += entry.datagram.size();
      break;
    }
    case SessionEntry::Kind::cycle:
      if (cycles_ > 0 && entry.cycle.sample > newest_sample_ + 1) {
        lost_samples_ += entry.cycle.sample - newest_sample_ - 1;
        ++gaps_;
      }
      newest_sample_ = entry.cycle.sample;
      ++cycles_;
      lateness_.record(entry.cycle.late_ns);
      max_written_n_ = std::max(max_written_n_, entry.cycle.written_n.norm());
      max_written_nm_ = std::max(max_written_nm_, entry.cycle.written_nm.norm());
      local_forces_ += entry.cycle.local ? 1 : 0;
      missed_cycles_ += entry.cycle.missed;
      if (entry.cycle.cause != MissCause::none) ++miss_causes_[entry.cycle.cause];
      return;
    case SessionEntry::Kind::fault:
      if (faults_.size() < kMaxListedFaults) faults_.push_back({entry.time_ns, entry.fault});
      ++fault_counts_[entry.fault];
      return;
    case SessionEntry::Kind::dropped:
      dropped_entries_ += entry.dropped;
      return;
    case SessionEntry::Kind::marker:
      if (markers_.size() < kMaxListedMarkers) markers_.push_back({entry.time_ns, entry.marker.sample, std::string(entry.marker.text)});
      ++marker_count_;
      return;
    case SessionEntry::Kind::end:
      return;
  }
  if (datagram == nullptr || entry.kind == SessionEntry::Kind::sent) return;
  changes_.add(entry, datagram);
  if (const auto* force = std::get_if<ForceCommand>(&datagram->message)) add_force(datagram->header.sender, *force, entry.time_ns);
  if (const auto* setup = std::get_if<HapticsSetup>(&datagram->message)) setups_[{datagram->header.sender, setup->method_serial}] = *setup;
  if (const auto* state = std::get_if<MaterialState>(&datagram->message)) materials_[{datagram->header.sender, state->serial}] = *state;
  if (const auto* move = std::get_if<ObjectMove>(&datagram->message)) {
    moves_[{datagram->header.sender, move->serial, move->object}] = *move;
  }
  if (const auto* part = std::get_if<ObjectShape>(&datagram->message)) first_shapes_.add(datagram->header.sender, *part);
  if (const auto* start = std::get_if<ShapeStart>(&datagram->message)) {
    first_shapes_.add(datagram->header.sender, *start);
    if (start->serial > 0) shape_serials_.insert({datagram->header.sender, start->serial});
  }
}

void SessionSummary::add_force(std::uint64_t sender, const ForceCommand& force, std::int64_t time_ns) {
  first_shapes_.add(sender, force);
  contact_forces_ += force.contact ? 1 : 0;
  max_force_n_ = std::max(max_force_n_, force.force_n.norm());
  max_torque_nm_ = std::max(max_torque_nm_, force.torque_nm.norm());
  round_trip_.record(ns_between(force.echo_sample_time_ns, time_ns));
}

ReplayedCarves SessionSummary::carves() const {
  ReplayedCarves carves;
  for (const RecordedCarve& one : changes_.carves()) carves.add(one);
  return carves;
}

std::string SessionSummary::to_text(const SessionHeader& header) const {
  std::string text =
      fmt::format("{}, begun {}, {:.3f} s, {} entries\n", header.fault.empty() ? "session" : "flight record: " + header.fault,
                  date_of(header.start_unix_ns), seconds(), entries_);
  text += fmt::format("hub: {}\n", header.build);
  std::string settings;
  for (const auto& [name, value] : header.settings) settings += fmt::format("{}{} {}", settings.empty() ? "" : ", ", name, value);
  text += fmt::format("settings: {}\n", settings);
  for (const auto& [key, setup] : setups_) {
    const std::string loading = describe_loading(setup.scene_loading);
    text += fmt::format("haptics {:016x}: {}, scene {} ({:016x}{}{}), {}\n", key.first, setup.method.data(), setup.scene.data(),
                        setup.scene_hash, loading.empty() ? "" : "; ", loading, setup.build.data());
  }
  const auto changes = std::count_if(materials_.begin(), materials_.end(), [](const auto& one) { return one.first.second > 0; });
  if (changes > 0) text += fmt::format("materials changed while running: {}\n", changes);
  const auto moves = std::count_if(moves_.begin(), moves_.end(), [](const auto& one) { return one.second.serial > 0; });
  if (moves > 0) text += fmt::format("objects moved by programs: {} times\n", moves);
  if (!shape_serials_.empty()) text += fmt::format("shapes of objects from programs: {}\n", shape_serials_.size());
  const auto is_early = [](const RecordedCarve& one) { return std::isnan(one.t_s); };
  const auto early = std::count_if(changes_.carves().begin(), changes_.carves().end(), is_early);
  if (!changes_.carves().empty()) {
    text += fmt::format("carves: {}{}\n", changes_.carves().size(), early > 0 ? fmt::format(", {} of them made before", early) : "");
  }
  text += fmt::format("  {:<14} {:>10} {:>10} {:>9}\n", "datagrams", "received", "sent", "kB/s");
  for (const auto& [name, traffic] : traffic_) {
    const double rate = seconds() > 0.0 ? 1e-3 * static_cast<double>(traffic.bytes) / seconds() : 0.0;
    text += fmt::format("  {:<14} {:>10} {:>10} {:>9.1f}\n", name, traffic.received, traffic.sent, rate);
  }
  text += fmt::format("forces: {} in contact, maximum requested {:.3f} N, maximum written {:.3f} N\n", contact_forces_, max_force_n_,
                      max_written_n_);
  if (max_torque_nm_ > 0.0)
    text += fmt::format("torques: maximum requested {:.4f} Nm, maximum written {:.4f} Nm\n", max_torque_nm_, max_written_nm_);
  if (local_forces_ > 0) text += fmt::format("forces computed by io_node, from parts of the scene: {}\n", local_forces_);
  if (round_trip_.count() > 0) text += fmt::format("sample to force: {}\n", quantiles(round_trip_));
  if (lateness_.count() > 0) text += fmt::format("cycles: {}, late by {}\n", cycles_, quantiles(lateness_));
  if (missed_cycles_ + miss_causes_.size() > 0) {
    text += fmt::format("{} missed cycles", missed_cycles_);
    const char* before = "; times by cause:";
    for (const auto& [cause, count] : miss_causes_) text += fmt::format("{} {} {}", std::exchange(before, ","), to_string(cause), count);
    text += "\n";
  }
  for (const Fault& fault : faults_) {
    text += fmt::format("fault at {:.6f} s: {}\n", seconds_between(header.start_ns, fault.time_ns), to_string(fault.fault));
  }
  for (const auto& [fault, count] : fault_counts_) text += fmt::format("faults: {} {}\n", count, to_string(fault));
  for (const Marker& marker : markers_) {
    text +=
        fmt::format("marker at {:.6f} s, sample {}: {}\n", seconds_between(header.start_ns, marker.time_ns), marker.sample, marker.text);
  }
  if (marker_count_ > 0) text += fmt::format("markers: {}\n", marker_count_);
  if (lost_samples_ > 0) text += fmt::format("missing in the recording: {} samples in {} gaps\n", lost_samples_, gaps_);
  if (dropped_entries_ > 0) text += fmt::format("not recorded: {} entries (buffer full)\n", dropped_entries_);
  return text;
}

}  // namespace hapton
