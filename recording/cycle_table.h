#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "link/codec.h"
#include "link/session_entry.h"
#include "link/session_reader.h"

namespace hapton {

// One servo cycle of a recorded session with all that belongs to its sample of the device. Frame W (world), SI units; D: device point, T:
// stylus, P: proxy. Times since the beginning of the recording. NaN: not known, because no force came for that sample.
struct CycleRow {
  double sample_t_s = 0.0;  // time when the device was read
  std::uint64_t sample = 0;
  Vec3 p_WD = Vec3::Zero();
  Quat q_WT = Quat::Identity();
  Vec3 v_WD = Vec3::Zero();  // velocity, from the difference to the sample before
  std::uint32_t buttons = 0;
  Vec3 p_WP;                      // proxy
  Vec3 wanted_n;                  // force of the haptics node, or of a patch in io_node, before the governor
  Vec3 written_n = Vec3::Zero();  // force on the motors
  Quat q_WP;                      // orientation of the drawn rigid tool; with a probe, that of the stylus
  Vec3 wanted_nm;                 // torque of a rigid tool, before the governor
  Vec3 written_nm = Vec3::Zero();
  bool is_contact = false;                          // not known where wanted_n is not
  std::int32_t object = -1;                         // touched object, its number in the scene; -1: none, or not recorded
  bool is_local = false;                            // the force was computed in io_node, on a patch of the scene
  double round_trip_s = 0.0;                        // from the sample until its force arrived
  double late_s = 0.0;                              // how late the cycle began
  std::uint32_t missed = 0;                         // cycles left out before this one
  std::optional<std::uint32_t> view_revision = {};  // revision of the scene's pose that the force was computed with; none: not known
  std::int64_t scene_time_ns = 0;                   // as in ForceCommand; not known where view_revision is not
  std::uint32_t carve_serial = 0;                   // likewise
  std::uint64_t lost = 0;                           // samples directly before this one that are not in the recording
  std::string event;                                // faults since the row before, separated by spaces
  std::vector<std::string> markers;                 // markers set while this sample was the newest
};

// A line of the table of events that `hapton session export` writes: one for all faults of a row, and one for each of its markers.
struct CycleEvent {
  std::string_view kind;  // "fault" or "marker"
  const std::string& name;
};
// Calls visit(CycleEvent) for each event of the row.
template <class Visit>
void for_each_event(const CycleRow& row, Visit&& visit) {
  if (!row.event.empty()) visit(CycleEvent{"fault", row.event});
  for (const std::string& marker : row.markers) visit(CycleEvent{"marker", marker});
}

// A column of numbers, the same in every format that is exported (CSV, HDF5, MCAP).
struct CycleColumn {
  std::string_view name;
  std::string_view unit;
  double (*of)(const CycleRow&);
};
std::span<const CycleColumn> cycle_columns() noexcept;

// Joins the entries of a recording into rows, and passes them to `take` in the order of their samples: a row once its force has come, or
// latest_s after its cycle, and another row follows. Cycles without the device's sample (older recordings) give no row.
// RT: no. Threads: one.
class CycleTable {
 public:
  static constexpr double kLatestS = 5.0;  // far more than any round trip; the hub does not use forces as late as this
  using Take = std::function<void(const CycleRow&)>;

  CycleTable(std::int64_t start_ns, Take take, double latest_s = kLatestS)
      : start_ns_(start_ns), take_(std::move(take)), latest_s_(latest_s) {}

  // datagram: the decoded one of the entry; null: the entry has none, or one that is not to be used (for_each_entry).
  void add(const SessionEntry& entry, const Datagram* datagram);
  // Call it after the last entry: passes on the rows that still wait.
  void finish();
  // Adds all entries that can be read, and finishes.
  void add_all(SessionReader& reader);

  std::uint64_t rows() const noexcept { return rows_; }
  std::uint64_t without_sample() const noexcept { return without_sample_; }  // cycles that gave no row
  // Samples of the device that are not in the recording, and the number of gaps that they make.
  std::uint64_t lost() const noexcept { return lost_; }
  std::uint64_t gaps() const noexcept { return gaps_; }

 private:
  struct Waiting {
    CycleRow row;
    std::int64_t time_ns = 0;
    bool is_complete = false;
  };

  void add_cycle(const SessionEntry& entry);
  void add_force(const ForceCommand& force, std::int64_t time_ns);
  void add_marker(const MarkerNote& marker);
  void pass_complete(std::int64_t now_ns);
  void pass_front();

  std::int64_t start_ns_;
  Take take_;
  double latest_s_;
  std::deque<Waiting> waiting_;
  // Forces whose cycle is still to come (a cycle is recorded at its end), with the times at which they came.
  std::deque<std::pair<ForceCommand, std::int64_t>> early_forces_;
  std::optional<CycleSample> previous_sample_;
  std::uint64_t previous_number_ = 0;
  std::string events_;                                         // faults for the next row
  std::deque<std::pair<std::uint64_t, std::string>> markers_;  // sample and text of those whose row is still to come
  std::uint64_t rows_ = 0;
  std::uint64_t without_sample_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t gaps_ = 0;
};

}  // namespace hapton
