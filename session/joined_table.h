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

// One cycle of a recorded session with all that belongs to its sample. Frame W, SI units; times from the beginning of the recording.
// NaN: not known (no force came for that sample).
struct JoinedRow {
  double sample_t_s = 0.0;  // when the device was read
  std::uint64_t sample = 0;
  Vec3 p_WD = Vec3::Zero();
  Quat q_WT = Quat::Identity();
  Vec3 v_WD = Vec3::Zero();  // difference to the sample before
  std::uint32_t buttons = 0;
  Vec3 p_WP;      // probe
  Vec3 wanted_n;  // of the haptics node or of parts of the scene, before the governor
  Vec3 written_n = Vec3::Zero();
  Quat q_WP;       // tool as it is drawn; the stylus' own where a probe is felt
  Vec3 wanted_nm;  // torque of a rigid tool, before the governor
  Vec3 written_nm = Vec3::Zero();
  bool is_contact = false;
  std::int32_t object = -1;  // touched, of the scene's; -1: none, or not recorded
  bool is_local = false;     // computed on parts of the scene, beside the device
  double round_trip_s = 0.0;
  double late_s = 0.0;  // the cycle began so long after its tick
  std::uint32_t missed = 0;
  std::optional<std::uint32_t> view_revision = {};  // of the pose of the static scene that the force was computed with; none: not known
  std::int64_t scene_time_ns = 0;                   // as in ForceCommand
  std::uint64_t lost = 0;                           // samples right before this one that the recording lacks
  std::string event;                                // faults since the row before, with spaces between
  std::vector<std::string> markers;                 // set while this sample was the newest
};

// What happened at a row, as its events table has it: its faults together, each marker alone.
struct JoinedEvent {
  std::string_view kind;  // "fault" or "marker"
  const std::string& name;
};
template <class Visit>
void for_each_event(const JoinedRow& row, Visit&& visit) {
  if (!row.event.empty()) visit(JoinedEvent{"fault", row.event});
  for (const std::string& marker : row.markers) visit(JoinedEvent{"marker", marker});
}

// A column of numbers, for every writer.
struct JoinedColumn {
  std::string_view name;
  std::string_view unit;
  double (*of)(const JoinedRow&);
};
std::span<const JoinedColumn> joined_columns() noexcept;

// Joins the entries of a recording into rows, in the order of their samples. A row is given out once its force has come, or latest_s after
// its cycle (later forces were never used), and another row follows. Cycles without the device's sample (older recordings) give no row. RT:
// no.
class JoinedTable {
 public:
  static constexpr double kLatestS = 5.0;
  using Take = std::function<void(const JoinedRow&)>;

  JoinedTable(std::int64_t start_ns, Take take, double latest_s = kLatestS)
      : start_ns_(start_ns), take_(std::move(take)), latest_s_(latest_s) {}

  void add(const SessionEntry& entry, const Datagram* datagram);
  // At the end: what is still waiting.
  void finish();
  // Both, for all that can be read.
  void add_all(SessionReader& reader);

  std::uint64_t rows() const noexcept { return rows_; }
  std::uint64_t without_sample() const noexcept { return without_sample_; }
  // Samples of the device that the recording lacks, and in how many places.
  std::uint64_t lost() const noexcept { return lost_; }
  std::uint64_t gaps() const noexcept { return gaps_; }

 private:
  struct Waiting {
    JoinedRow row;
    std::int64_t time_ns = 0;
    bool is_complete = false;
  };

  void add_cycle(const SessionEntry& entry);
  void add_force(const ForceCommand& force, std::int64_t time_ns);
  void add_marker(const MarkerNote& marker);
  void give_out(std::int64_t now_ns);
  void give_out_front();

  std::int64_t start_ns_;
  Take take_;
  double latest_s_;
  std::deque<Waiting> waiting_;
  // Forces whose cycle is not written yet: it is recorded when all its work is done.
  std::deque<std::pair<ForceCommand, std::int64_t>> early_;
  std::optional<CycleSample> before_;
  std::uint64_t sample_before_ = 0;
  std::string events_;
  std::deque<std::pair<std::uint64_t, std::string>> markers_;  // whose row is still to come
  std::uint64_t rows_ = 0;
  std::uint64_t without_sample_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t gaps_ = 0;
};

}  // namespace hapton
