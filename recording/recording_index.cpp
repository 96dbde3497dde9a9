#include "recording/recording_index.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/ns_between.h"
#include "core/math/rigid_pose.h"
#include "recording/recording_entries.h"

namespace hapton {
namespace {

// Spacing of the positions at which reading can begin: a seek reads at most this much before what it looks for. Closer ones make the index
// larger.
constexpr double kSeekPointEveryS = 0.25;
constexpr std::uint64_t kSeekPointEveryBytes = 1 << 20;
// Times from a file are limited to this, so that the numbers of spans fit into 64 bits.
constexpr double kMaxSeconds = 1e9;

double seconds_from(std::int64_t start_ns, std::int64_t time_ns) {
  return std::clamp(seconds_between(start_ns, time_ns), -kMaxSeconds, kMaxSeconds);
}

// The first element later than t_s.
template <class Vector>
auto find_after(const Vector& all, double t_s) {
  return std::upper_bound(all.begin(), all.end(), t_s, [](double t, const auto& one) { return t < one.t_s; });
}

template <class Vector>
auto newest_or_first(const Vector& all, double t_s) -> decltype(&all.front().message) {
  if (all.empty()) return nullptr;
  const auto after = find_after(all, t_s);
  return after == all.begin() ? &all.front().message : &std::prev(after)->message;
}

// Keeps the times in ascending order, whatever the file says.
template <class Message>
void add_later(std::vector<Timed<Message>>& to, double t_s, const Message& message) {
  to.push_back({to.empty() ? t_s : std::max(t_s, to.back().t_s), message});
}

bool is_same(const HapticsSetup& a, const HapticsSetup& b) {
  return a.method == b.method && a.scene == b.scene && a.scene_hash == b.scene_hash && a.scene_loading == b.scene_loading;
}

}  // namespace

bool RecordingIndex::is_haptics(std::uint64_t sender) const {
  return std::ranges::find(haptics_senders_, sender) != haptics_senders_.end();
}

bool RecordingIndex::note_message(std::map<std::int32_t, MessageId>& last, std::int32_t object, const MessageId& id) {
  const auto [at, is_first] = last.try_emplace(object, id);
  return is_first || std::exchange(at->second, id) != id;
}

void RecordingIndex::add_row(const CycleRow& row) {
  const double t_s = std::clamp(row.sample_t_s, spans_.empty() ? -kMaxSeconds : end_s_, kMaxSeconds);
  if (spans_.empty()) begin_s_ = t_s;
  end_s_ = t_s;
  const auto number = static_cast<std::int64_t>(std::floor(t_s / kSpanS));
  if (spans_.empty() || spans_.back().number != number) spans_.push_back({.number = number});
  RecordingSpan& span = spans_.back();
  ++span.samples;
  const double written_n = row.written_n.norm();
  if (std::isfinite(written_n)) span.written_n = std::max(span.written_n, static_cast<float>(written_n));
  if (row.round_trip_s >= 0.0) span.round_trip_s = std::max(span.round_trip_s, static_cast<float>(row.round_trip_s));
  span.is_contact = span.is_contact || row.is_contact;
  for_each_event(row, [&](const CycleEvent& event) { marks_.push_back({t_s, event.name, event.kind == "fault"}); });
}

void RecordingIndex::add_view(const View& view, double t_s) {
  if (!views_.empty() && views_.back().message == view) return;
  add_later(views_, t_s, view);
}

void RecordingIndex::add_carves(const Carves& carves, double t_s) {
  const KnownCarves::News news = known_carves_.take(carves, Arrival::newest);
  if (!news.starts_anew && news.carves.empty()) return;
  const bool is_first = carves_.empty();
  if (news.starts_anew) is_first_carver_ = is_first;
  const std::uint32_t last_earlier = is_first_carver_ ? earlier_.last() : 0;
  // Carves that were made before the recording are received during it, on the hub's request. They belong to its beginning.
  std::vector<NumberedCarve> new_carves;
  for (std::uint32_t n = 0; n < news.carves.size(); ++n) new_carves.push_back({news.first + n, news.carves[n]});
  if (!is_first && !news.starts_anew) {
    const auto later = std::ranges::find_if(new_carves, [&](const NumberedCarve& one) { return one.serial > last_earlier; });
    std::vector<NumberedCarve>& begin = carves_.front().message.carves;
    begin.insert(begin.end(), new_carves.begin(), later);
    new_carves.erase(new_carves.begin(), later);
    if (new_carves.empty()) return;
  }
  add_later(carves_, t_s, CarveNews{news.starts_anew, std::move(new_carves)});
}

void RecordingIndex::add_received(const Datagram& datagram, double t_s, std::uint64_t position) {
  const Message& message = datagram.message;
  const std::uint64_t sender = datagram.header.sender;
  earlier_.add(datagram);
  const auto* setup = std::get_if<HapticsSetup>(&message);
  const bool is_of_haptics = setup != nullptr || std::holds_alternative<ForceCommand>(message);
  if (is_of_haptics && !is_haptics(sender)) haptics_senders_.push_back(sender);
  if (setup != nullptr) {
    add_view({setup->view_revision, setup->X_WS}, t_s);
    if (setups_.empty() || !is_same(setups_.back().message, *setup)) add_later(setups_, t_s, *setup);
  }
  // If the hub rejects this view, it sends back the one in use, which follows at once.
  if (const auto* view = std::get_if<ViewTransform>(&message)) add_view({view->revision, view->X_WS}, t_s);
  if (const auto* move = std::get_if<ObjectMove>(&message)) {
    if (note_message(last_moves_, move->object, {move->source, move->serial})) add_later(moves_, t_s, IndexedMove::of(*move));
  }
  if (const auto* carves = std::get_if<Carves>(&message)) add_carves(*carves, t_s);
  if (const auto* part = std::get_if<ObjectShape>(&message)) shapes_.add(*part, position);
  if (const auto* start = std::get_if<ShapeStart>(&message)) shapes_.add(*start, t_s);
  if (const auto* force = std::get_if<ForceCommand>(&message)) shapes_.add(*force);
  if (!is_haptics(sender)) return;
  const auto* pose = std::get_if<ObjectPose>(&message);
  if (pose != nullptr && note_message(last_poses_, pose->object, {sender, pose->serial})) add_later(poses_, t_s, *pose);
  const auto* scene = std::get_if<SceneFacts>(&message);
  if (scene != nullptr && (scene_hashes_.empty() || scene_hashes_.back().message != scene->given_hash)) {
    add_later(scene_hashes_, t_s, scene->given_hash);
  }
}

Result<RecordingIndex> RecordingIndex::read(SessionReader& reader) {
  RecordingIndex index;
  const std::int64_t start_ns = reader.header().start_ns;
  CycleTable table(start_ns, [&](const CycleRow& row) { index.add_row(row); });
  std::uint64_t position = reader.position();
  (void)for_each_entry(reader, [&](const SessionEntry& entry, const Datagram* datagram) -> Result<void> {
    const double t_s = seconds_from(start_ns, entry.time_ns);
    const SeekPoint* last = index.seek_points_.empty() ? nullptr : &index.seek_points_.back();
    if (last == nullptr || t_s >= last->t_s + kSeekPointEveryS || (t_s >= last->t_s && position >= last->position + kSeekPointEveryBytes)) {
      index.seek_points_.push_back({t_s, position});
    }
    const std::uint64_t entry_position = std::exchange(position, reader.position());
    table.add(entry, datagram);
    if (datagram == nullptr) return {};
    if (entry.kind == SessionEntry::Kind::received) index.add_received(*datagram, t_s, entry_position);
    const auto* view = std::get_if<ViewTransform>(&datagram->message);
    if (view != nullptr && entry.kind == SessionEntry::Kind::sent) index.add_view({view->revision, view->X_WS}, t_s);
    const auto* probe = std::get_if<ProbeState>(&datagram->message);
    if (probe != nullptr && entry.kind == SessionEntry::Kind::sent) {
      const DeviceNotice notice{probe->status, probe->energy_percent, probe->force_limit_n};
      if (index.notices_.empty() || index.notices_.back().message != notice) add_later(index.notices_, t_s, notice);
    }
    return {};
  });
  table.finish();
  if (index.spans_.empty() && table.without_sample() > 0) {
    return fail("an older recording, whose cycles lack the device's samples; hapton session export --format tables writes what it has");
  }
  if (index.spans_.empty()) return fail("holds no sample of the device");
  return index;
}

std::span<const RecordingSpan> RecordingIndex::spans_between(double from_s, double to_s) const {
  const auto number = [](double t_s) { return static_cast<std::int64_t>(std::floor(std::clamp(t_s, -kMaxSeconds, kMaxSeconds) / kSpanS)); };
  const auto from = std::ranges::lower_bound(spans_, number(from_s), {}, &RecordingSpan::number);
  const auto to = std::ranges::upper_bound(spans_, number(to_s), {}, &RecordingSpan::number);
  return from < to ? std::span(from, to) : std::span<const RecordingSpan>();
}

std::uint64_t RecordingIndex::find_position(double t_s) const {
  const auto after = find_after(seek_points_, t_s);
  return after == seek_points_.begin() ? seek_points_.front().position : std::prev(after)->position;
}

Pose RecordingIndex::find_view(std::optional<std::uint32_t> revision, double t_s) const {
  if (views_.empty()) return Pose::Identity();
  auto found = find_after(views_, t_s);
  if (found != views_.begin()) --found;
  // Search backwards for the revision: revisions of several vision nodes follow on from each other.
  for (auto one = found; revision && one->message.revision != *revision && one != views_.begin();) {
    --one;
    if (one->message.revision == *revision) found = one;
  }
  return find_rigid_pose(found->message.X_WS).value_or(Pose::Identity());
}

const HapticsSetup* RecordingIndex::find_setup(double t_s) const { return newest_or_first(setups_, t_s); }

const DeviceNotice* RecordingIndex::find_notice(double t_s) const {
  const auto after = find_after(notices_, t_s);
  return after == notices_.begin() ? nullptr : &std::prev(after)->message;
}

std::uint64_t RecordingIndex::find_scene_hash(double t_s) const {
  const std::uint64_t* hash = newest_or_first(scene_hashes_, t_s);
  return hash != nullptr ? *hash : 0;
}

}  // namespace hapton
