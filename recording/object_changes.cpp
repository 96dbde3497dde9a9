#include "recording/object_changes.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "core/base/ns_between.h"

namespace hapton {
namespace {

constexpr ChangeColumn<RecordedMove> kMoveColumns[] = {
    {"t_s", "s", [](const RecordedMove& r) { return r.t_s; }},
    {"process", "1", [](const RecordedMove& r) { return static_cast<double>(r.process); }},
    {"serial", "1", [](const RecordedMove& r) { return static_cast<double>(r.move.serial); }},
    {"object", "1", [](const RecordedMove& r) { return static_cast<double>(r.move.object); }},
    {"start_scene_time_s", "s", [](const RecordedMove& r) { return 1e-9 * static_cast<double>(r.move.start_ns); }},
    {"end_scene_time_s", "s", [](const RecordedMove& r) { return 1e-9 * static_cast<double>(r.move.end_ns); }},
    {"from_x_m", "m", [](const RecordedMove& r) { return r.move.from_p_m.x(); }},
    {"from_y_m", "m", [](const RecordedMove& r) { return r.move.from_p_m.y(); }},
    {"from_z_m", "m", [](const RecordedMove& r) { return r.move.from_p_m.z(); }},
    {"from_qw", "1", [](const RecordedMove& r) { return r.move.from_q.w(); }},
    {"from_qx", "1", [](const RecordedMove& r) { return r.move.from_q.x(); }},
    {"from_qy", "1", [](const RecordedMove& r) { return r.move.from_q.y(); }},
    {"from_qz", "1", [](const RecordedMove& r) { return r.move.from_q.z(); }},
    {"to_x_m", "m", [](const RecordedMove& r) { return r.move.to_p_m.x(); }},
    {"to_y_m", "m", [](const RecordedMove& r) { return r.move.to_p_m.y(); }},
    {"to_z_m", "m", [](const RecordedMove& r) { return r.move.to_p_m.z(); }},
    {"to_qw", "1", [](const RecordedMove& r) { return r.move.to_q.w(); }},
    {"to_qx", "1", [](const RecordedMove& r) { return r.move.to_q.x(); }},
    {"to_qy", "1", [](const RecordedMove& r) { return r.move.to_q.y(); }},
    {"to_qz", "1", [](const RecordedMove& r) { return r.move.to_q.z(); }},
};

constexpr ChangeColumn<RecordedCarve> kCarveColumns[] = {
    {"t_s", "s", [](const RecordedCarve& r) { return r.t_s; }},
    {"process", "1", [](const RecordedCarve& r) { return static_cast<double>(r.process); }},
    {"serial", "1", [](const RecordedCarve& r) { return static_cast<double>(r.serial); }},
    {"object", "1", [](const RecordedCarve& r) { return static_cast<double>(r.carve.object); }},
    {"from_x_m", "m", [](const RecordedCarve& r) { return static_cast<double>(r.carve.from_m[0]); }},
    {"from_y_m", "m", [](const RecordedCarve& r) { return static_cast<double>(r.carve.from_m[1]); }},
    {"from_z_m", "m", [](const RecordedCarve& r) { return static_cast<double>(r.carve.from_m[2]); }},
    {"to_x_m", "m", [](const RecordedCarve& r) { return static_cast<double>(r.carve.to_m[0]); }},
    {"to_y_m", "m", [](const RecordedCarve& r) { return static_cast<double>(r.carve.to_m[1]); }},
    {"to_z_m", "m", [](const RecordedCarve& r) { return static_cast<double>(r.carve.to_m[2]); }},
    {"radius_m", "m", [](const RecordedCarve& r) { return static_cast<double>(r.carve.radius_m); }},
    {"begins", "1", [](const RecordedCarve& r) { return r.carve.begins ? 1.0 : 0.0; }},
    {"undone_first", "1", [](const RecordedCarve& r) { return static_cast<double>(r.carve.undone_first); }},
    {"undone_last", "1", [](const RecordedCarve& r) { return static_cast<double>(r.carve.undone_last); }},
};

}  // namespace

std::span<const ChangeColumn<RecordedMove>> move_columns() noexcept { return kMoveColumns; }
std::span<const ChangeColumn<RecordedCarve>> carve_columns() noexcept { return kCarveColumns; }

void ObjectChanges::add(const SessionEntry& entry, const Datagram* datagram) {
  if (datagram == nullptr || entry.kind != SessionEntry::Kind::received) return;
  processes_.add(datagram->message);
  earlier_.add(*datagram);
  const double t_s = seconds_between(start_ns_, entry.time_ns);
  if (const auto* setup = std::get_if<HapticsSetup>(&datagram->message)) add_setup(*setup, datagram->header.sender, t_s);
  if (const auto* move = std::get_if<ObjectMove>(&datagram->message)) add_move(*move, datagram->header.sender, t_s);
  if (const auto* carves = std::get_if<Carves>(&datagram->message)) add_carves(*carves, datagram->header.sender, t_s);
}

// The haptics node repeats its setup once a second; only a change is added.
void ObjectChanges::add_setup(const HapticsSetup& setup, std::uint64_t sender, double t_s) {
  const auto is_same = [&](const HapticsSetup& other) {
    return other.method == setup.method && other.scene == setup.scene && other.scene_hash == setup.scene_hash &&
           other.scene_loading == setup.scene_loading && other.build == setup.build;
  };
  if (setups_.empty() || setups_.back().sender != sender || !is_same(setups_.back().setup))
    setups_.push_back({.t_s = t_s, .sender = sender, .setup = setup});
}

// The haptics node repeats the newest move of each object; a repetition is not added.
void ObjectChanges::add_move(const ObjectMove& move, std::uint64_t sender, double t_s) {
  if (move_process_ != processes_.number()) {
    move_process_ = processes_.number();
    move_serials_.clear();
  }
  std::uint32_t& newest = move_serials_[move.object];
  if (move.serial <= newest) return;
  newest = move.serial;
  moves_.push_back({.t_s = t_s, .sender = sender, .process = move_process_, .move = move});
}

void ObjectChanges::add_carves(const Carves& carves, std::uint64_t sender, double t_s) {
  if (carve_process_ != processes_.number()) {
    carve_process_ = processes_.number();
    has_carve_.clear();
  }
  const std::uint32_t last_earlier = carve_process_ == 0 ? earlier_.last() : 0;
  for (std::uint32_t n = 0; n < carves.count; ++n) {
    const std::uint32_t serial = carves.first + n;
    if (serial >= kMaxSerial) return;
    if (serial >= has_carve_.size()) has_carve_.resize(serial + 1);
    if (has_carve_[serial]) continue;
    has_carve_[serial] = true;
    carves_.push_back({.t_s = serial <= last_earlier ? std::numeric_limits<double>::quiet_NaN() : t_s,
                       .sender = sender,
                       .process = *carve_process_,
                       .serial = serial,
                       .carve = carves.carves[n]});
  }
}

void ObjectChanges::finish() {
  std::stable_sort(carves_.begin(), carves_.end(), [](const RecordedCarve& a, const RecordedCarve& b) {
    return std::tie(a.process, a.serial) < std::tie(b.process, b.serial);
  });
}

}  // namespace hapton
