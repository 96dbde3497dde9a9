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
  Quat q_WP = Quat::Identity();   // proxy; with a tool only, like the next
  Vec3 torque_nm = Vec3::Zero();  // about the grip point
  bool contact = false;
  bool is_blocked = false;   // a tool overlaps the scene since it was put there, and gives no force
  bool is_squeezed = false;  // a tool has no room where an object moves, which it feels where it still has
  std::int64_t step_ns = 0;  // least of all repetitions, less the cost of reading the clock
};

struct ReplaySettings {
  std::size_t reset_every = 0;  // 0: only before the first row
  std::size_t repeat = 1;
};

struct Replay {
  std::vector<ReplayRow> rows;
  bool has_tool = false;
  std::int64_t clock_cost_ns = 0;    // subtracted from every step
  std::size_t rows_that_differ = 0;  // rows in which a repetition differs from the first run; 0 for a method that a reset resets completely
};

// Runs the step along the trajectory, row by row, `repeat` times; every repetition begins with a reset. RT: set-up only. Pre: repeat >=
// 1.
Replay run_replay(TouchStep& touch, std::span<const TrajectoryRow> trajectory, const ReplaySettings& settings, const Clock& clock);
// The same for a rigid tool, whose grip frame follows positions and orientations. parts: of the scene that move, as the tool was made for;
// time begins with the first row.
Replay run_replay(ToolStep& tool, std::span<const TrajectoryRow> trajectory, const ReplaySettings& settings, const Clock& clock,
                  std::span<const ToolPart> parts = {});
Replay run_replay(VoxelTool& tool, std::span<const TrajectoryRow> trajectory, const ReplaySettings& settings, const Clock& clock);

// Adds the effects in free space of a scene to the forces of a rigid tool, which ran along this trajectory. Their time is not in step_ns.
void add_space_effects(const std::vector<SwitchedEffect>& effects, std::span<const TrajectoryRow> trajectory,
                       const ReplaySettings& settings, Replay& replay);

// By nearest rank: no step in `fraction` of them takes longer. Orders the times. Pre: there are some.
std::int64_t quantile_ns(std::vector<std::int64_t>& times, double fraction);

// How many steps, how many in contact, the largest force, and p50, p99, p99.9 and the worst step of all and of those in contact.
std::string describe_replay(const Replay& replay, const ReplaySettings& settings);

// Writes t_s,x_m,y_m,z_m,proxy_x_m,proxy_y_m,proxy_z_m,fx_n,fy_n,fz_n,contact,step_ns and, with a tool,
// proxy_qw,proxy_qx,proxy_qy,proxy_qz,tx_nm,ty_nm,tz_nm, with all digits of every number. Error: one line with the path.
Result<void> write_replay_csv(const std::filesystem::path& path, const Replay& replay);

}  // namespace hapton
