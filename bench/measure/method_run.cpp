#include "bench/measure/method_run.h"

#include <algorithm>
#include <utility>

#include "bench/measure/live_heap.h"
#include "core/force/reference/reference_method.h"
#include "core/force/touch_step.h"
#include "core/geometry/mesh_measures.h"

namespace hapton {
namespace {

bool starts_piece(const TouchTrajectory& trajectory, std::size_t i) {
  return i == 0 || (trajectory.reset_every > 0 && i % trajectory.reset_every == 0);
}

MethodSettings reference_of(double probe_radius_m) {
  MethodSettings settings;
  settings.name = "reference";
  settings.probe_radius_m = probe_radius_m;
  return settings;
}

template <class Note>
MethodTiming time_touch(const Stopwatch& watch, const TimingBudget& budget, TouchStep& touch, const TouchTrajectory& trajectory,
                        const Note& note) {
  MethodTiming timing;
  const std::size_t steps = trajectory.p_SD.size();
  timing.felt.resize(steps);
  std::vector<std::uint8_t> contact(steps, 0);
  TouchInput input;
  TouchOutput output;
  const TimedSteps timed = time_steps(
      watch, budget, steps,
      [&](std::size_t i) {
        input.p_WD = trajectory.p_SD[i];
        if (starts_piece(trajectory, i)) touch.reset(input);
      },
      [&](std::size_t) { output = touch.step(input); },
      [&](std::size_t i) {
        timing.felt[i] = {.device = input.p_WD, .proxy = input.p_WD + output.visual_offset_m, .force_n = output.force_n};
        note(timing.felt[i]);
        contact[i] = output.contact ? 1 : 0;
      });
  std::vector<std::uint8_t> free(steps);
  std::transform(contact.begin(), contact.end(), free.begin(), [](std::uint8_t c) { return c == 0 ? 1 : 0; });
  timing.all = spread_of_times(timed.least.ns());
  timing.contact_ns = timed.least.only(contact);
  timing.contact = spread_of_times(timing.contact_ns);
  timing.free = spread_of_times(timed.least.only(free));
  timing.mean_ns = timed.mean_ns;
  timing.repetitions = timed.repetitions;
  return timing;
}

}  // namespace

Result<MethodTiming> time_method(const Stopwatch& watch, const TimingBudget& budget, const MethodSettings& settings,
                                 const TouchScene& scene, const TouchTrajectory& trajectory) {
  const std::size_t heap = read_live_heap_bytes();
  const std::uint64_t start = Stopwatch::ticks();
  auto method = make_method(settings, scene);
  const double build_ns = watch.ns_between(start, Stopwatch::ticks());
  if (!method) return tl::unexpected(method.error());
  const std::size_t grown = read_live_heap_bytes();
  TouchStep touch(std::move(*method), scene);
  MethodTiming timing = time_touch(watch, budget, touch, trajectory, [](ForceSample&) {});
  timing.build_ms = 1e-6 * build_ns;
  timing.bytes = grown > heap ? grown - heap : 0;
  return timing;
}

Result<std::vector<ForceSample>> compute_forces(const MethodSettings& settings, const TouchScene& scene,
                                                const TouchTrajectory& trajectory) {
  auto method = make_method(settings, scene);
  if (!method) return tl::unexpected(method.error());
  TouchStep touch(std::move(*method), scene);
  std::vector<ForceSample> felt;
  felt.reserve(trajectory.p_SD.size());
  for (std::size_t i = 0; i < trajectory.p_SD.size(); ++i) {
    TouchInput input;
    input.p_WD = trajectory.p_SD[i];
    if (starts_piece(trajectory, i)) touch.reset(input);
    const TouchOutput output = touch.step(input);
    felt.push_back({.device = input.p_WD, .proxy = input.p_WD + output.visual_offset_m, .force_n = output.force_n});
  }
  return felt;
}

TouchTrajectory take_heads(const TouchTrajectory& trajectory, std::size_t rows) {
  const std::size_t piece = trajectory.reset_every == 0 ? trajectory.p_SD.size() : trajectory.reset_every;
  TouchTrajectory heads;
  heads.reset_every = std::min(rows, piece);
  for (std::size_t i = 0; i < trajectory.p_SD.size(); ++i) {
    if (i % std::max<std::size_t>(1, piece) < rows) heads.p_SD.push_back(trajectory.p_SD[i]);
  }
  return heads;
}

ForceError ReferenceRun::compare(const std::vector<ForceSample>& felt_by_method) const {
  return compare_forces(felt_by_method, felt, error_settings());
}

ForceErrorSettings ReferenceRun::error_settings() const {
  ForceErrorSettings settings;
  settings.stiffness_n_per_m = stiffness_n_per_m;
  settings.extent_m = extent_m;
  settings.reset_every = trajectory.reset_every;
  return settings;
}

Result<ReferenceRun> run_reference(const Stopwatch& watch, const TouchScene& scene, const TouchTrajectory& trajectory,
                                   double probe_radius_m) {
  ReferenceRun run;
  run.trajectory = trajectory;
  run.stiffness_n_per_m = scene.objects.front().material.stiffness_n_per_m;
  for (const TouchObject& object : scene.objects) run.extent_m = std::max(run.extent_m, compute_bounds(*object.mesh).extent());
  auto made = ReferenceMethod::make_reference(reference_of(probe_radius_m), scene);
  if (!made) return tl::unexpected(made.error());
  const std::shared_ptr<ReferenceMethod> method = std::move(*made);
  TouchStep touch(method, scene);
  MethodTiming timing = time_touch(watch, {.repetitions = 1, .seconds = 0.0}, touch, trajectory,
                                   [&](ForceSample& step) { step.settled = method->last_step().settled; });
  run.felt = std::move(timing.felt);
  run.time = timing.contact;
  run.description = method->describe();
  return run;
}

}  // namespace hapton
