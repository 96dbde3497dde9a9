#include "tools/session/replay.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "core/force/space_step.h"
#include "runtime/part_file.h"

namespace hapton {
namespace {

constexpr double kFirstStepS = 1e-3;  // dt_s of the first row, which has no row before it

// The least time between two readings of the clock.
std::int64_t measure_clock_cost_ns(const Clock& clock) {
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < 1000; ++i) {
    const std::int64_t before = clock.now_ns();
    least = std::min(least, clock.now_ns() - before);
  }
  return least;
}

// Both structs make a step's input from a row of the trajectory, and fill a result's row from its output: for a probe, for a rigid tool.
struct TouchRows {
  using Input = TouchInput;
  using Output = TouchOutput;

  static Input input(std::span<const TrajectoryRow> trajectory, std::size_t i) {
    return {.p_WD = trajectory[i].p_WD,
            .dt_s = i == 0 ? kFirstStepS : trajectory[i].t_s - trajectory[i - 1].t_s,
            .buttons = trajectory[i].buttons,
            .time_s = trajectory[i].t_s - trajectory[0].t_s};
  }
  static void fill(ReplayRow& row, const Input& input, const Output& output) {
    row.p_WP = input.p_WD + output.visual_offset_m;
    row.force_n = output.force_n;
    row.contact = output.contact;
  }
};

struct ToolRows {
  using Input = ToolInput;
  using Output = ToolOutput;

  static Input input(std::span<const TrajectoryRow> trajectory, std::size_t i) {
    Input input;
    input.X_WD.translation() = trajectory[i].p_WD;
    input.X_WD.linear() = trajectory[i].q_WT.toRotationMatrix();
    input.dt_s = i == 0 ? kFirstStepS : trajectory[i].t_s - trajectory[i - 1].t_s;
    return input;
  }
  static void fill(ReplayRow& row, const Input&, const Output& output) {
    row.p_WP = output.X_WP.translation();
    row.q_WP = Quat(output.X_WP.linear());
    row.force_n = output.force_n;
    row.torque_nm = output.torque_nm;
    row.contact = output.contact;
    row.is_blocked = output.proxy.is_blocked;
    row.is_squeezed = output.proxy.is_squeezed;
  }
};

bool has_same_output(const ReplayRow& a, const ReplayRow& b) {
  return a.force_n == b.force_n && a.torque_nm == b.torque_nm && a.contact == b.contact && a.p_WP == b.p_WP &&
         a.q_WP.coeffs() == b.q_WP.coeffs();
}

bool begins_at(std::size_t row, const ReplaySettings& settings) {
  return row == 0 || (settings.reset_every > 0 && row % settings.reset_every == 0);
}

template <class Rows, class Step>
Replay run_rows(Step& touch, std::span<const TrajectoryRow> trajectory, const ReplaySettings& settings, const Clock& clock,
                const std::vector<typename Rows::Input>& inputs) {
  Replay replay;
  replay.clock_cost_ns = measure_clock_cost_ns(clock);
  replay.rows.resize(trajectory.size());
  for (std::size_t repetition = 0; repetition < settings.repeat; ++repetition) {
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      if (begins_at(i, settings)) touch.reset(inputs[i]);
      const std::int64_t before_ns = clock.now_ns();
      const typename Rows::Output output = touch.step(inputs[i]);
      const std::int64_t step_ns = std::max<std::int64_t>(0, clock.now_ns() - before_ns - replay.clock_cost_ns);
      ReplayRow row{.t_s = trajectory[i].t_s, .p_WD = trajectory[i].p_WD, .step_ns = step_ns};
      Rows::fill(row, inputs[i], output);
      if (repetition > 0) {
        replay.rows_that_differ += has_same_output(replay.rows[i], row) ? 0 : 1;
        row = replay.rows[i];
        row.step_ns = std::min(row.step_ns, step_ns);
      }
      replay.rows[i] = row;
    }
  }
  return replay;
}

template <class Rows>
std::vector<typename Rows::Input> inputs_of(std::span<const TrajectoryRow> trajectory) {
  std::vector<typename Rows::Input> inputs;
  for (std::size_t i = 0; i < trajectory.size(); ++i) inputs.push_back(Rows::input(trajectory, i));
  return inputs;
}

std::string describe_times(std::vector<std::int64_t> times) {
  if (times.empty()) return "none";
  return fmt::format("p50 {} / p99 {} / p99.9 {} / worst {} ns", quantile_ns(times, 0.5), quantile_ns(times, 0.99),
                     quantile_ns(times, 0.999), quantile_ns(times, 1.0));
}

}  // namespace

std::int64_t quantile_ns(std::vector<std::int64_t>& times, double fraction) {
  const auto rank = static_cast<std::ptrdiff_t>(std::ceil(fraction * static_cast<double>(times.size())));
  const auto nth = times.begin() + std::max<std::ptrdiff_t>(rank, 1) - 1;
  std::nth_element(times.begin(), nth, times.end());
  return *nth;
}

std::string describe_replay(const Replay& replay, const ReplaySettings& settings) {
  std::vector<std::int64_t> all;
  std::vector<std::int64_t> contact;
  double max_force_n = 0.0;
  double max_torque_nm = 0.0;
  std::size_t blocked = 0;
  std::size_t squeezed = 0;
  for (const ReplayRow& row : replay.rows) {
    all.push_back(row.step_ns);
    if (row.contact) contact.push_back(row.step_ns);
    blocked += row.is_blocked ? 1 : 0;
    squeezed += row.is_squeezed ? 1 : 0;
    max_force_n = std::max(max_force_n, row.force_n.norm());
    max_torque_nm = std::max(max_torque_nm, row.torque_nm.norm());
  }
  std::string text = fmt::format("replay: {} steps, {} in contact, force max {:.6g} N", all.size(), contact.size(), max_force_n);
  text += replay.has_tool ? fmt::format(", torque max {:.6g} Nm\n", max_torque_nm) : std::string("\n");
  text += fmt::format("step time, minimum of {} (less {} ns for the clock): all {}; contact {}\n", settings.repeat, replay.clock_cost_ns,
                      describe_times(std::move(all)), describe_times(std::move(contact)));
  if (blocked > 0) text += fmt::format("note: {} steps without force: the tool overlapped the scene where it started\n", blocked);
  if (squeezed > 0)
    text += fmt::format("note: in {} steps the tool had no room where an object moves, and felt it where there was room\n", squeezed);
  if (replay.rows_that_differ > 0) {
    text += fmt::format("note: {} steps differed between repetitions\n", replay.rows_that_differ);
  }
  return text;
}

Replay run_replay(TouchStep& touch, std::span<const TrajectoryRow> trajectory, const ReplaySettings& settings, const Clock& clock) {
  return run_rows<TouchRows>(touch, trajectory, settings, clock, inputs_of<TouchRows>(trajectory));
}

Replay run_replay(ToolStep& tool, std::span<const TrajectoryRow> trajectory, const ReplaySettings& settings, const Clock& clock,
                  std::span<const ToolPart> parts) {
  std::vector<ToolInput> inputs = inputs_of<ToolRows>(trajectory);
  std::vector<Pose> poses;  // poses of the moving parts of the scene, row by row
  for (const TrajectoryRow& row : trajectory) {
    for (const ToolPart& part : parts) poses.push_back(part.pose_at(row.t_s - trajectory[0].t_s));
  }
  for (std::size_t i = 0; i < inputs.size(); ++i) inputs[i].X_SO = std::span(poses).subspan(i * parts.size(), parts.size());
  Replay replay = run_rows<ToolRows>(tool, trajectory, settings, clock, inputs);
  replay.has_tool = true;
  return replay;
}

Replay run_replay(VoxelTool& tool, std::span<const TrajectoryRow> trajectory, const ReplaySettings& settings, const Clock& clock) {
  Replay replay = run_rows<ToolRows>(tool, trajectory, settings, clock, inputs_of<ToolRows>(trajectory));
  replay.has_tool = true;
  return replay;
}

void add_space_effects(const std::vector<SwitchedEffect>& effects, std::span<const TrajectoryRow> trajectory,
                       const ReplaySettings& settings, Replay& replay) {
  if (effects.empty()) return;
  SpaceStep step(effects);
  for (std::size_t i = 0; i < replay.rows.size(); ++i) {
    if (begins_at(i, settings)) step.reset();
    const Vec3 force_n = step.step(TouchRows::input(trajectory, i));
    replay.rows[i].force_n += force_n;
    replay.rows[i].contact = replay.rows[i].contact || !force_n.isZero(0.0);
  }
}

Result<void> write_replay_csv(const std::filesystem::path& path, const Replay& replay) {
  auto opened = PartFile::open(path);
  if (!opened) return tl::unexpected(opened.error());
  PartFile& file = *opened;
  const auto print = [&](const char* format, auto... numbers) { return std::fprintf(file.get(), format, numbers...) > 0; };
  bool is_written = print("t_s,x_m,y_m,z_m,proxy_x_m,proxy_y_m,proxy_z_m,fx_n,fy_n,fz_n,contact,step_ns%s\n",
                          replay.has_tool ? ",proxy_qw,proxy_qx,proxy_qy,proxy_qz,tx_nm,ty_nm,tz_nm" : "");
  for (const ReplayRow& row : replay.rows) {
    is_written = is_written && print("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%d,%lld", row.t_s, row.p_WD.x(),
                                     row.p_WD.y(), row.p_WD.z(), row.p_WP.x(), row.p_WP.y(), row.p_WP.z(), row.force_n.x(), row.force_n.y(),
                                     row.force_n.z(), row.contact ? 1 : 0, static_cast<long long>(row.step_ns));
    if (replay.has_tool) {
      is_written = is_written && print(",%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g", row.q_WP.w(), row.q_WP.x(), row.q_WP.y(), row.q_WP.z(),
                                       row.torque_nm.x(), row.torque_nm.y(), row.torque_nm.z());
    }
    is_written = is_written && std::fputc('\n', file.get()) != EOF;
  }
  file.check(is_written);
  if (auto closed = file.close(); !closed) return closed;
  return file.keep();
}

}  // namespace hapton
