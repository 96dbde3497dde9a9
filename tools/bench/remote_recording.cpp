#include "tools/bench/remote_recording.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "recording/recording_entries.h"
#include "remote_touch/packet_size.h"
#include "remote_touch/whole_scene.h"
#include "safety/vector_limit.h"

namespace hapton {
namespace {

class RecordedTouchReader {
 public:
  RecordedTouchReader(std::shared_ptr<ForceMethod> method, const RecordedRun& run) : whole_scene_(std::move(method)), run_(run) {}

  void add(const SessionEntry& entry, const Datagram* datagram) {
    if (entry.kind == SessionEntry::Kind::cycle) add_cycle(entry.cycle);
    if (datagram != nullptr) add_packet(entry, datagram->message);
  }

  Result<RecordedTouch> finish() {
    if (rows_.empty()) return fail("the recording has no samples of the device");
    touch_.force = compare_forces(rows_, run_.period_s, run_.most_late_s);
    const double seconds = run_.to_s - run_.from_s;
    for (double* rate : {&touch_.rates.packets_up, &touch_.rates.packets_down, &touch_.rates.bytes_up, &touch_.rates.bytes_down})
      *rate /= seconds;
    touch_.local_share = contact_cycles_ > 0 ? static_cast<double>(local_contact_cycles_) / static_cast<double>(contact_cycles_) : 0.0;
    touch_.local_error_rms = local_zero_delay_squared_ > 0.0 ? std::sqrt(local_error_squared_ / local_zero_delay_squared_) : 0.0;
    return touch_;
  }

 private:
  void add_cycle(const CycleNote& cycle) {
    if (!cycle.device) return;
    if (rows_.empty()) start_ns_ = cycle.device->time_ns;
    now_s_ = 1e-9 * static_cast<double>(cycle.device->time_ns - start_ns_);
    (void)whole_scene_.step(cycle.device->p_WD, cycle.device->time_ns);
    const TouchOutput& zero_delay = whole_scene_.last();
    const Vec3 zero_delay_n = shortened(zero_delay.force_n, run_.max_force_n);
    rows_.push_back({cycle.device->p_WD, cycle.written_n, zero_delay_n, zero_delay.visual_offset_m.norm()});
    if (cycle.local) compare_local(cycle.local->force_n, zero_delay.force_n);
    contact_cycles_ += zero_delay.contact ? 1 : 0;
    local_contact_cycles_ += zero_delay.contact && cycle.local ? 1 : 0;
    ++touch_.cycles;
    touch_.missed += cycle.missed;
  }

  void compare_local(const Vec3& force_n, const Vec3& zero_delay_n) {
    const double error_n = (force_n - zero_delay_n).norm();
    touch_.local_error_max_n = std::max(touch_.local_error_max_n, error_n);
    local_error_squared_ += error_n * error_n;
    local_zero_delay_squared_ += zero_delay_n.squaredNorm();
  }

  void add_packet(const SessionEntry& entry, const Message& message) {
    const auto bytes = static_cast<double>(packet_bytes_of(message));
    const bool is_up = entry.kind == SessionEntry::Kind::sent;
    if (is_scene_part(message)) {
      touch_.scene_kb += 1e-3 * bytes;
      touch_.ready_s = now_s_;
    }
    if (rows_.empty() || now_s_ < run_.from_s || now_s_ >= run_.to_s) return;
    (is_up ? touch_.rates.packets_up : touch_.rates.packets_down) += 1.0;
    (is_up ? touch_.rates.bytes_up : touch_.rates.bytes_down) += bytes;
  }

  WholeScene whole_scene_;
  RecordedRun run_;
  RecordedTouch touch_;
  std::vector<ForceRow> rows_;
  std::int64_t start_ns_ = 0;
  double now_s_ = 0.0;
  std::uint64_t contact_cycles_ = 0;
  std::uint64_t local_contact_cycles_ = 0;
  double local_error_squared_ = 0.0;
  double local_zero_delay_squared_ = 0.0;
};

}  // namespace

Result<RecordedTouch> evaluate_recording(const std::filesystem::path& recording, std::shared_ptr<ForceMethod> method,
                                         const RecordedRun& run) {
  auto reader = SessionReader::open(recording);
  if (!reader) return tl::unexpected(reader.error());
  RecordedTouchReader touch(std::move(method), run);
  (void)for_each_entry(*reader, [&](const SessionEntry& entry, const Datagram* datagram) -> Result<void> {
    touch.add(entry, datagram);
    return {};
  });
  if (auto ended = check_end(*reader); !ended) return tl::unexpected(ended.error());
  auto found = touch.finish();
  return found ? found : fail("{}: {}", recording.string(), found.error().what);
}

}  // namespace hapton
