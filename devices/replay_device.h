#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "devices/device.h"
#include "runtime/trajectory_csv.h"

namespace hapton {

// A recording in place of a hand: plays a trajectory from its first row on, starting at the first read, straight lines
// between rows (and the shortest turn). Forces are discarded. At the end it stays at the last row and reports `ended`,
// or with loop starts again, as if the first row came one mean time between rows after the last. If the first row is
// elsewhere than the last, the point jumps, and the device reports `away` for that one read, so that the jump is not
// taken for a hand's motion. The limits are a PHANToM Model A's, without a limit of speed, since a recording cannot be
// slowed down. The workspace is the recording's own box, with kMarginM around it. RT: all but making one; the time of a
// read grows with the number of rows since the last read.
class ReplayDevice final : public Device {
 public:
  struct Options {
    bool loop = false;
  };

  // Twice WorkspaceStop::kMarginM: no part of the recording is where the governor fades forces.
  static constexpr double kMarginM = 0.02;
  static constexpr double kSeamM = 0.001;  // a larger step from the last row to the first is a jump; a choice

  // Pre: rows as read_trajectory_csv gives them (at least one, times rising).
  ReplayDevice(std::vector<TrajectoryRow> rows, const Options& options);

  std::string_view name() const noexcept override { return "replay"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceSample read(std::int64_t now_ns) noexcept override;
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept override;
  void use_heartbeat_page(HeartbeatPage& page) noexcept override { page.set_means(CutMeans::no_motors); }
  DeviceStatus status() const noexcept override { return status_; }
  bool set_hand_target(const std::optional<Vec3>& p_WH) noexcept override;

  double length_s() const noexcept { return rows_.back().t_s - rows_.front().t_s; }

 private:
  double trajectory_time_s(std::int64_t now_ns) noexcept;

  std::vector<TrajectoryRow> rows_;
  Options options_;
  DeviceLimits limits_;
  DeviceStatus status_ = DeviceStatus::ready;
  bool jumps_at_seam_ = false;  // it is repeated, and jumps from its last row to its first
  double loop_s_ = 0.0;         // length of one round of a loop
  std::size_t row_ = 0;         // the last row that the last read had reached
  double played_to_s_ = 0.0;    // time of the trajectory at the last read
  std::int64_t zero_ns_ = -1;   // time of the first read; below 0: not read yet
};

}  // namespace hapton
