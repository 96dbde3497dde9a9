#include "io_node/session_recorder.h"

#include <fmt/chrono.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <type_traits>
#include <utility>

#include "runtime/atomic_file.h"
#include "runtime/earlier_file.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"
#include "runtime/writable_path.h"

namespace hapton {
namespace {

constexpr auto kCollectEvery = std::chrono::milliseconds(10);  // the ring holds 0.5 s or more
constexpr std::size_t kWriteBytes = std::size_t{1} << 16;      // in one write: 16 pages of memory

// Begins each record in the ring. A datagram, cycle or marker follows; nothing follows for a fault.
struct Note {
  SessionEntry::Kind kind = SessionEntry::Kind::received;
  SessionFault fault = SessionFault::none;
  NodeRole source = NodeRole::io;  // role of the node that sent the marker
  std::uint16_t port = 0;
  std::int64_t time_ns = 0;
  std::array<std::uint8_t, 16> ip = {};
};

// The contents of a CycleNote without Eigen's types: trivially copyable.
struct PlainCycle {
  std::uint64_t sample = 0;
  std::int64_t late_ns = 0;
  std::array<double, 3> written_n = {};
  std::array<double, 3> written_nm = {};
  std::uint32_t missed = 0;
  MissCause cause = MissCause::none;
  bool has_device = false;
  bool is_local = false;
  std::uint32_t buttons = 0;
  std::int64_t sample_time_ns = 0;
  std::array<double, 3> p_WD_m = {};
  std::array<double, 4> q_WT = {};  // w, x, y, z
  std::array<double, 3> local_n = {};
  std::array<double, 3> local_offset_m = {};
  std::int32_t local_object = -1;
};

std::array<double, 3> plain(const Vec3& v) noexcept { return {v.x(), v.y(), v.z()}; }

PlainCycle plain(const CycleNote& n) noexcept {
  PlainCycle to{.sample = n.sample,
                .late_ns = n.late_ns,
                .written_n = plain(n.written_n),
                .written_nm = plain(n.written_nm),
                .missed = n.missed,
                .cause = n.cause};
  if (n.device) {
    to.has_device = true;
    to.buttons = n.device->buttons;
    to.sample_time_ns = n.device->time_ns;
    to.p_WD_m = plain(n.device->p_WD);
    const Quat& q = n.device->q_WT;
    to.q_WT = {q.w(), q.x(), q.y(), q.z()};
  }
  to.is_local = n.local.has_value();
  if (n.local) {
    to.local_n = plain(n.local->force_n);
    to.local_offset_m = plain(n.local->visual_offset_m);
    to.local_object = n.local->object;
  }
  return to;
}

CycleNote note_of(const PlainCycle& from) {
  CycleNote to{.sample = from.sample,
               .late_ns = from.late_ns,
               .written_n = Vec3(from.written_n.data()),
               .written_nm = Vec3(from.written_nm.data()),
               .missed = from.missed,
               .cause = from.cause};
  const auto& q = from.q_WT;
  if (from.has_device) to.device = CycleSample{from.sample_time_ns, Vec3(from.p_WD_m.data()), Quat(q[0], q[1], q[2], q[3]), from.buttons};
  if (from.is_local) to.local = CycleLocal{Vec3(from.local_n.data()), Vec3(from.local_offset_m.data()), from.local_object};
  return to;
}

template <class T>
std::span<const std::byte> bytes_of(const T& value) noexcept {
  static_assert(std::is_trivially_copyable_v<T>);
  return std::as_bytes(std::span(&value, 1));
}

SessionEntry entry_of(std::span<const std::byte> record) {
  Note note;
  std::memcpy(&note, record.data(), sizeof note);
  const auto body = record.subspan(sizeof note);
  SessionEntry entry;
  entry.kind = note.kind;
  entry.time_ns = note.time_ns;
  entry.fault = note.fault;
  entry.peer = {note.ip, note.port};
  if (note.kind == SessionEntry::Kind::marker) {
    entry.marker.source = note.source;
    std::memcpy(&entry.marker.sample, body.data(), sizeof entry.marker.sample);
    const auto text = body.subspan(sizeof entry.marker.sample);
    entry.marker.text = {reinterpret_cast<const char*>(text.data()), text.size()};
  } else if (note.kind == SessionEntry::Kind::cycle) {
    PlainCycle cycle;
    std::memcpy(&cycle, body.data(), sizeof cycle);
    entry.cycle = note_of(cycle);
  } else {
    entry.datagram = body;
  }
  return entry;
}

// Appends a record to a block, with its length in front.
void append_record(std::vector<std::byte>& to, std::span<const std::byte> record) {
  const auto size = static_cast<std::uint32_t>(record.size());
  const auto prefix = bytes_of(size);
  to.insert(to.end(), prefix.begin(), prefix.end());
  to.insert(to.end(), record.begin(), record.end());
}

template <class Visit>
void for_each_record(std::span<const std::byte> block, Visit&& visit) {
  while (!block.empty()) {
    std::uint32_t size = 0;
    std::memcpy(&size, block.data(), sizeof size);
    visit(block.subspan(sizeof size, size));
    block = block.subspan(sizeof size + size);
  }
}

// "20261120T071500.123Z"
std::string time_text(std::int64_t unix_ns) {
  const std::time_t seconds = unix_ns / kNanosecondsPerSecond;
  return fmt::format("{:%Y%m%dT%H%M%S}.{:03}Z", fmt::gmtime(seconds), unix_ns / kNanosecondsPerMillisecond % 1000);
}

}  // namespace

SessionRecorder::SessionRecorder(Options options, SessionHeader header, const Clock& clock)
    : options_(std::move(options)),
      records_all_(!options_.record.empty()),
      header_(std::move(header)),
      clock_(clock),
      ring_(options_.ring_bytes),
      file_(nullptr, &std::fclose) {
  header_.has_end = true;
}

SessionRecorder::~SessionRecorder() { (void)stop(); }

Result<void> SessionRecorder::start() {
  if (!options_.flight_folder.empty() && options_.makes_flight_folder) {
    std::error_code error;
    std::filesystem::create_directories(options_.flight_folder, error);
    if (error) {
      return fail("{}: the folder for flight records cannot be made: {}; choose another with --flight, or --flight off",
                  options_.flight_folder.string(), error.message());
    }
    // Checked now: otherwise the error would not show before the first fault, and the record of that fault would be lost.
    if (const auto writable = check_writable_folder(options_.flight_folder); !writable) {
      return fail("flight records: {}, or --flight off", writable.error().what);
    }
  }
  if (!options_.record.empty()) {
    // A recording cannot be repeated, so a second start with the same flags must not replace the first one.
    const auto kept = keep_earlier_file(options_.record);
    if (!kept) return tl::unexpected(kept.error());
    if (!kept->empty()) log_warning("{}: an earlier file of this name is kept as {}", options_.record.string(), kept->string());
    // If this fails, opening the file fails, and that error is reported.
    std::error_code ignored;
    if (options_.record.has_parent_path()) std::filesystem::create_directories(options_.record.parent_path(), ignored);
    file_.reset(open_file_for(options_.record, FileReaders::owner));
    if (!file_) {
      return fail("{}: the session cannot be recorded there: {}; give another file with --record", options_.record.string(),
                  std::strerror(errno));
    }
    unwritten_ = kSessionMagic;
    codec_.append(header_, unwritten_);
    write_entries(true);
    if (!write_result_) return write_result_;
  }
  thread_ = start_thread([this] { run(); });
  return {};
}

Result<void> SessionRecorder::stop() {
  if (!thread_.joinable()) return write_result_;
  ends_.store(true, std::memory_order_release);
  thread_.join();
  if (file_ && std::fclose(file_.release()) != 0 && write_result_) {
    write_result_ = fail("{}: the recording is incomplete: {}", options_.record.string(), std::strerror(errno));
  }
  return write_result_;
}

void SessionRecorder::run() {
  while (!ends_.load(std::memory_order_acquire)) {
    collect();
    if (flight_ && clock_.now_ns() >= flight_->fault_ns + kAfterFaultNs) write_flight();
    std::this_thread::sleep_for(kCollectEvery);
  }
  collect();
  if (flight_) write_flight();
  if (file_) append_end(unwritten_);
  write_entries(true);
}

void SessionRecorder::collect() {
  while (!recent_.empty() && recent_.front().newest_ns < newest_ns_ - kFlightNs - kAfterFaultNs) recent_.pop_front();
  drained_.clear();
  ring_.drain([&](std::span<const std::byte> record) {
    append_record(drained_, record);
    take(entry_of(record));
  });
  // A copy, which takes exactly the size of its records: if the reused buffer were moved in, every block would take the capacity of the
  // largest one.
  if (!drained_.empty()) recent_.push_back({drained_, newest_ns_});
  if (const std::uint64_t dropped = ring_.dropped(); dropped != dropped_reported_) {
    SessionEntry entry;
    entry.kind = SessionEntry::Kind::dropped;
    entry.time_ns = newest_ns_;
    entry.dropped = dropped - dropped_reported_;
    append(entry);
    counts_.dropped = dropped_reported_ = dropped;
  }
  write_entries(false);
}

void SessionRecorder::take(const SessionEntry& entry) {
  newest_ns_ = std::max(newest_ns_, entry.time_ns);
  ++counts_.entries;
  if (entry.kind == SessionEntry::Kind::cycle) {
    const std::uint64_t sample = entry.cycle.sample;
    if (sample > newest_sample_ + 1) counts_.lost_samples += sample - newest_sample_ - 1;
    newest_sample_ = std::max(newest_sample_, sample);
  }
  append(entry);
  if (unwritten_.size() >= kWriteBytes) write_entries(false);
  if (entry.kind == SessionEntry::Kind::fault && !options_.flight_folder.empty()) plan_flight(entry);
}

void SessionRecorder::append(const SessionEntry& entry) {
  if (!file_) return;
  codec_.append(entry, unwritten_);
  ++unwritten_entries_;
}

void SessionRecorder::append_end(std::string& to) {
  SessionEntry end;
  end.kind = SessionEntry::Kind::end;
  end.time_ns = newest_ns_;
  codec_.append(end, to);
}

// If a recording cannot be written, it is ended, and the session continues without it.
void SessionRecorder::write_entries(bool all) {
  if (!file_ || (!all && unwritten_.size() < kWriteBytes)) return;
  // Flushed, so that the counted bytes are in the file and not in a buffer.
  const bool good = std::fwrite(unwritten_.data(), 1, unwritten_.size(), file_.get()) == unwritten_.size() && std::fflush(file_.get()) == 0;
  counts_.file_bytes += good ? unwritten_.size() : 0;
  counts_.file_entries += good ? unwritten_entries_ : 0;
  unwritten_entries_ = 0;
  unwritten_.clear();
  if (good) return;
  write_result_ = fail("{}: recording stopped: {}", options_.record.string(), std::strerror(errno));
  log_error("{}; the session continues", write_result_.error().what);
  file_.reset();
}

void SessionRecorder::plan_flight(const SessionEntry& fault) {
  if (flight_) return;  // the record that is planned will contain this fault, too
  std::int64_t& last_ns = last_flight_ns_[static_cast<std::size_t>(fault.fault)];
  if ((last_ns != 0 && fault.time_ns - last_ns < kFlightEveryNs) || counts_.flights >= kMaxFlights) {
    ++counts_.flights_left_out;
    return;
  }
  last_ns = fault.time_ns;
  flight_ = Flight{fault.fault, fault.time_ns};
}

void SessionRecorder::write_flight() {
  const Flight flight = *std::exchange(flight_, std::nullopt);
  SessionHeader header = header_;
  header.fault = to_string(flight.fault);
  std::string bytes(kSessionMagic);
  codec_.append(header, bytes);
  for (const Block& block : recent_) {
    for_each_record(block.bytes, [&](std::span<const std::byte> record) {
      const SessionEntry entry = entry_of(record);
      if (entry.time_ns >= flight.fault_ns - kFlightNs) codec_.append(entry, bytes);
    });
  }
  append_end(bytes);
  const std::int64_t unix_ns = header_.start_unix_ns + (flight.fault_ns - header_.start_ns);
  const auto path = options_.flight_folder / fmt::format("flight-{}-{}.hapton", time_text(unix_ns), header.fault);
  if (const auto written = write_file_atomically(path, bytes, FileReaders::owner); !written) {
    ++counts_.flights_left_out;
    log_error("{}: no flight record: {}", header.fault, written.error().what);
    return;
  }
  ++counts_.flights;
  log_warning("fault: {}; its last 2 s are in {}", header.fault, path.string());
  forget_old_flights();
}

// The names begin with the time, so sorting by name is sorting by age.
void SessionRecorder::forget_old_flights() const {
  std::error_code ignored;
  std::vector<std::filesystem::path> records;
  for (const auto& entry : std::filesystem::directory_iterator(options_.flight_folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("flight-") && name.ends_with(".hapton")) records.push_back(entry.path());
  }
  std::sort(records.begin(), records.end());
  for (std::size_t n = 0; n + kMaxKeptFlights < records.size(); ++n) std::filesystem::remove(records[n], ignored);
}

void SessionRecorder::on_received(const Address& from, std::span<const std::byte> datagram, std::int64_t time_ns) noexcept {
  const Note note{.kind = SessionEntry::Kind::received, .port = from.port, .time_ns = time_ns, .ip = from.ip};
  ring_.push(bytes_of(note), datagram);
}

void SessionRecorder::on_sent(const Address& to, std::span<const std::byte> datagram, std::int64_t time_ns) noexcept {
  const Note note{.kind = SessionEntry::Kind::sent, .port = to.port, .time_ns = time_ns, .ip = to.ip};
  ring_.push(bytes_of(note), datagram);
}

void SessionRecorder::on_cycle(const CycleNote& n, std::int64_t time_ns) noexcept {
  const Note note{.kind = SessionEntry::Kind::cycle, .time_ns = time_ns};
  const PlainCycle cycle = plain(n);
  ring_.push(bytes_of(note), bytes_of(cycle));
}

void SessionRecorder::on_fault(SessionFault fault, std::int64_t time_ns) noexcept {
  const Note note{.kind = SessionEntry::Kind::fault, .fault = fault, .time_ns = time_ns};
  ring_.push(bytes_of(note), {});
}

MarkerStatus SessionRecorder::on_marker(const MarkerNote& n, std::int64_t time_ns) noexcept {
  const Note note{.kind = SessionEntry::Kind::marker, .source = n.source, .time_ns = time_ns};
  std::array<std::byte, sizeof n.sample + MarkerText::kMaxBytes> body;
  std::memcpy(body.data(), &n.sample, sizeof n.sample);
  const std::size_t size = std::min(n.text.size(), MarkerText::kMaxBytes);
  std::memcpy(body.data() + sizeof n.sample, n.text.data(), size);
  const bool is_recorded = ring_.push(bytes_of(note), std::span(body).first(sizeof n.sample + size));
  return !records_all_ ? MarkerStatus::no_recording : is_recorded ? MarkerStatus::recorded : MarkerStatus::no_room;
}

}  // namespace hapton
