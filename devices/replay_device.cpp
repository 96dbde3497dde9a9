#include "devices/replay_device.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "devices/model_a.h"

namespace hapton {
namespace {

// Faster than any recording, so the governor never brakes; finite, as limits have to be.
constexpr double kNoLimitMPerS = 1e6;

}  // namespace

ReplayDevice::ReplayDevice(std::vector<TrajectoryRow> rows, const Options& options)
    : rows_(std::move(rows)), options_(options), limits_(model_a::limits()) {
  const std::size_t steps = rows_.size() - 1;
  loop_s_ = steps > 0 ? length_s() * static_cast<double>(steps + 1) / static_cast<double>(steps) : 0.0;
  jumps_at_seam_ = options_.loop && (rows_.back().p_WD - rows_.front().p_WD).norm() > kSeamM;
  limits_.max_speed_m_per_s = kNoLimitMPerS;
  limits_.workspace_min_m = limits_.workspace_max_m = rows_.front().p_WD;
  played_to_s_ = rows_.front().t_s;
  for (const TrajectoryRow& row : rows_) {
    limits_.workspace_min_m = limits_.workspace_min_m.cwiseMin(row.p_WD);
    limits_.workspace_max_m = limits_.workspace_max_m.cwiseMax(row.p_WD);
  }
  limits_.workspace_min_m -= Vec3::Constant(kMarginM);
  limits_.workspace_max_m += Vec3::Constant(kMarginM);
}

double ReplayDevice::trajectory_time_s(std::int64_t now_ns) noexcept {
  if (zero_ns_ < 0) zero_ns_ = now_ns;
  double played_s = 1e-9 * static_cast<double>(now_ns - zero_ns_);
  if (options_.loop && loop_s_ > 0.0) {
    played_s = std::fmod(played_s, loop_s_);
  } else if (!options_.loop && played_s >= length_s()) {
    status_ = DeviceStatus::ended;
  }
  return rows_.front().t_s + played_s;
}

DeviceSample ReplayDevice::read(std::int64_t now_ns) noexcept {
  const double t_s = trajectory_time_s(now_ns);
  const bool begins_again = t_s < std::exchange(played_to_s_, t_s);
  if (begins_again) row_ = 0;
  if (jumps_at_seam_) status_ = begins_again ? DeviceStatus::away : DeviceStatus::ready;
  while (row_ + 1 < rows_.size() && rows_[row_ + 1].t_s <= t_s) ++row_;
  const TrajectoryRow& from = rows_[row_];
  DeviceSample sample;
  sample.time_ns = now_ns;
  sample.p_WD = from.p_WD;
  sample.q_WT = from.q_WT;
  sample.buttons = from.buttons;
  if (row_ + 1 == rows_.size()) return sample;
  const TrajectoryRow& to = rows_[row_ + 1];
  const double share = std::clamp((t_s - from.t_s) / (to.t_s - from.t_s), 0.0, 1.0);
  sample.p_WD += share * (to.p_WD - from.p_WD);
  sample.q_WT = from.q_WT.slerp(share, to.q_WT);
  return sample;
}

void ReplayDevice::write(const Wrench&, std::int64_t) noexcept {}

bool ReplayDevice::set_hand_target(const std::optional<Vec3>&) noexcept { return false; }

}  // namespace hapton
