#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bench/measure/step_times.h"
#include "core/base/result.h"
#include "core/force/smooth/smooth_force.h"
#include "core/force/touch_scene.h"

namespace hapton {

// Method `smooth` as the FDH paper runs it: a fast task at a fixed rate on a set of triangles, a slow task that selects the sets.
struct SmoothTasksSettings {
  std::uint32_t set_size = 64;    // as in the paper
  double layer = kFdhPaperLayer;  // Algorithm 1 at full strength
  int directions = 14;            // directions of the hulls, as in the paper
  double seconds = 12.0;          // duration of the touch; a fast task at 10 kHz takes ten times the steps of one at 1 kHz
  double slow_period_s = 0.01;    // period at which the slow task polls for a request, as in haptics_node
  std::uint64_t seed = 1;
  int repetitions = 5;
};

// Times of the two tasks when the fast one runs at one rate: the least of the repetitions, nanoseconds.
struct SmoothTasks {
  double rate_hz = 0.0;
  TimeSpread busy;  // fast task: all steps
  double busy_mean_ns = 0.0;
  TimeSpread at_work;  // fast task: the steps with triangles in range, which are not skipped
  double at_work_mean_ns = 0.0;
  TimeSpread slow;  // slow task: one selection and its publication
  TimeSpread swap;  // the fast task takes a set over
  TimeSpread age;   // age of the set in use, at every step; nanoseconds of the simulated touch, not of the clock
  std::size_t steps = 0;
  std::size_t contact_steps = 0;
  std::size_t offered = 0;      // sets of the slow task that the fast task took over
  std::size_t without_set = 0;  // steps whose set did not cover enough: they selected one themselves or queried the tree
  std::size_t beyond_set = 0;   // those steps for which even a fresh set did not cover enough: they queried the tree
  int repetitions = 0;

  // Share of a period of the fast task, 0..1, that is left after its mean step, its mean step with triangles in range, and its worst step.
  // Below 0: the task is late.
  double idle_share() const { return 1.0 - 1e-9 * busy_mean_ns * rate_hz; }
  double idle_share_at_work() const { return 1.0 - 1e-9 * at_work_mean_ns * rate_hz; }
  double idle_share_worst() const { return 1.0 - 1e-9 * busy.worst_ns * rate_hz; }
  double share_without_set() const { return steps == 0 ? 0.0 : static_cast<double>(without_set) / static_cast<double>(steps); }
};

// Runs both tasks along a slide over the scene's first object, in one thread: once every slow period the slow task runs between two steps,
// so that each task is timed alone and every repetition does the same. Error: that of SmoothMethod::make; a mesh without area; the slow
// task never gave a set; repetitions that disagree. RT: set-up only.
Result<SmoothTasks> measure_smooth_tasks(const SmoothTasksSettings& settings, const Stopwatch& watch, const TouchScene& scene,
                                         double rate_hz);

}  // namespace hapton
