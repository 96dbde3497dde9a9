#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/force/touch_step.h"
#include "core/tool/tool_step.h"
#include "core/tool/voxel_tool.h"
#include "runtime/clock.h"
#include "runtime/trajectory_csv.h"
#include "scene/tool_obstacles.h"

namespace hapton {

// One step of a replay. Frame W, SI.
struct ReplayRow {
  double t_s = 0.0;
  Vec3 p_WD = Vec3::Zero();
  Vec3 p_WP = Vec3::Zero();  // proxy
  Vec3 force_n = Vec3::Zero();
  Quat q_WP = Quat::Identity();   // proxy; only with a tool, as is torque_nm
  Vec3 torque_nm = Vec3::Zero();  // about the grip point
  bool contact = false;
  bool is_blocked = false;   // the tool overlaps the scene since it was put there, and gives no force
  bool is_squeezed = false;  // the tool has no room where an object should be: the force is that of the object where there still was room
  std::int64_t step_ns = 0;  // least of all repetitions, less clock_cost_ns
};

struct ReplaySettings {
  std::size_t reset_every = 0;  // rows from one reset to the next; 0: a reset before the first row only
  std::size_t repeat = 1;
};

struct Replay {
  std::vector<ReplayRow> rows;
  bool has_tool = false;
  std::int64_t clock_cost_ns = 0;    // subtracted from every step
  std::size_t rows_that_differ = 0;  // rows that differ from the first run, summed over the repetitions; 0 if a reset restores all state
};

// Runs the step along the trajectory, row by row, `repeat` times; every repetition begins with a reset. Times come from the clock. RT:
// set-up only. Pre: repeat >= 1.
Replay run_replay(TouchStep& touch, std::span<const TrajectoryRow> trajectory, const ReplaySettings& settings, const Clock& clock);
// The same for a rigid tool, whose grip frame follows positions and orientations. parts: the parts of the scene that move, with which the
// tool was made; their time begins with the first row.
Replay run_replay(ToolStep& tool, std::span<const TrajectoryRow> trajectory, const ReplaySettings& settings, const Clock& clock,
                  std::span<const ToolPart> parts = {});
Replay run_replay(VoxelTool& tool, std::span<const TrajectoryRow> trajectory, const ReplaySettings& settings, const Clock& clock);

// Adds a scene's effects in free space to force and contact of a rigid tool that ran along this trajectory; step_ns does not change.
void add_space_effects(const std::vector<SwitchedEffect>& effects, std::span<const TrajectoryRow> trajectory,
                       const ReplaySettings& settings, Replay& replay);

// The quantile by nearest rank: at least the share `fraction` of the times is not longer. Reorders the times. Pre: there are some.
std::int64_t quantile_ns(std::vector<std::int64_t>& times, double fraction);

// Text: the number of steps and of those in contact, the largest force, and p50, p99, p99.9 and the longest time of both kinds of steps.
std::string describe_replay(const Replay& replay, const ReplaySettings& settings);

// Writes t_s,x_m,y_m,z_m,proxy_x_m,proxy_y_m,proxy_z_m,fx_n,fy_n,fz_n,contact,step_ns and, with a tool,
// proxy_qw,proxy_qx,proxy_qy,proxy_qz,tx_nm,ty_nm,tz_nm, with all digits of every number. Error: one line with the path.
Result<void> write_replay_csv(const std::filesystem::path& path, const Replay& replay);

}  // namespace hapton
