#include "bench/papers/smooth_tasks.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

#include "core/force/smooth/smooth_method.h"
#include "core/geometry/touch_trajectory.h"

namespace hapton {
namespace {

double mean_of(const std::vector<double>& ns) {
  return ns.empty() ? 0.0 : std::accumulate(ns.begin(), ns.end(), 0.0) / static_cast<double>(ns.size());
}

Result<std::unique_ptr<ForceMethod>> make_smooth(const SmoothTasksSettings& settings, const TouchScene& scene) {
  return SmoothMethod::make(
      {.set_size = static_cast<int>(settings.set_size), .smooth_layer = settings.layer, .hull_directions = settings.directions}, scene);
}

// What the steps of a run report besides forces; the same in every repetition.
struct StepFacts {
  std::vector<std::uint8_t> at_work;
  std::vector<double> age_steps;
  std::size_t contact = 0, offered = 0, without_set = 0, beyond_set = 0;

  bool operator==(const StepFacts&) const = default;
};

// Notes, in one repetition, before which step the slow task last selected a set, and how old the set in use is.
class SetWatch {
 public:
  void note_selection(std::size_t step) { selected_step_ = step; }

  void note_step(std::size_t step, const SmoothCounters& now, StepFacts& facts) {
    const bool took = now.offered != previous_counters_.offered;
    const bool selected = now.selections != previous_counters_.selections;
    const bool queried_tree = now.overflows != previous_counters_.overflows;
    if (took) made_step_ = selected_step_;
    if (selected) made_step_ = step;
    facts.offered += took ? 1 : 0;
    facts.without_set += selected || queried_tree ? 1 : 0;
    facts.beyond_set += queried_tree ? 1 : 0;
    facts.at_work.push_back(now.skipped == previous_counters_.skipped ? 1 : 0);
    facts.age_steps.push_back(static_cast<double>(step - made_step_));
    previous_counters_ = now;
  }

 private:
  SmoothCounters previous_counters_;
  std::size_t selected_step_ = 0;
  std::size_t made_step_ = 0;
};

// Keeps the least time of each call over all repetitions; every repetition makes the same calls in the same order.
class LeastOfCalls {
 public:
  void begin() { next_ = 0; }
  void add(double ns) {
    if (next_ == ns_.size()) ns_.push_back(ns);
    ns_[next_] = std::min(ns_[next_], ns);
    ++next_;
  }
  std::vector<double> take() { return std::move(ns_); }

 private:
  std::size_t next_ = 0;
  std::vector<double> ns_;
};

struct Runs {
  LeastTimes busy{0};
  LeastOfCalls slow;
};

// Makes a new method for each repetition, so that it inherits no state.
Result<StepFacts> run_once(const SmoothTasksSettings& settings, const Stopwatch& watch, const TouchScene& scene,
                           const TouchTrajectory& trajectory, double rate_hz, Runs& runs) {
  auto made = make_smooth(settings, scene);
  if (!made) return tl::unexpected(made.error());
  auto& method = static_cast<SmoothMethod&>(**made);
  const auto period = std::max<std::size_t>(1, static_cast<std::size_t>(std::llround(settings.slow_period_s * rate_hz)));
  const CpuPin pin;
  StepFacts facts;
  SetWatch set;
  runs.slow.begin();
  for (std::size_t i = 0; i < trajectory.p_SD.size(); ++i) {
    const MethodInput input{.p_SD = trajectory.p_SD[i], .dt_s = 1.0 / rate_hz};
    if (i == 0 || (trajectory.reset_every > 0 && i % trajectory.reset_every == 0)) method.reset(input.p_SD);
    if (i % period == 0) {
      const std::uint64_t from = Stopwatch::ticks();
      const bool selected = method.prepare();
      const double ns = watch.ns_between(from, Stopwatch::ticks());
      if (selected) {
        runs.slow.add(ns);
        set.note_selection(i);
      }
    }
    const std::uint64_t from = Stopwatch::ticks();
    const MethodOutput felt = method.step(input);
    runs.busy.add(i, watch.ns_between(from, Stopwatch::ticks()));
    facts.contact += felt.contact ? 1 : 0;
    set.note_step(i, method.counters(), facts);
  }
  return facts;
}

// Offers sets for distant positions, one after the other, to a method that never steps. Each reaches farther about its own position than
// the set before, so the method takes it.
Result<std::vector<double>> time_swaps(const SmoothTasksSettings& settings, const Stopwatch& watch, const TouchScene& scene,
                                       const TouchTrajectory& trajectory) {
  auto made = make_smooth(settings, scene);
  if (!made) return tl::unexpected(made.error());
  auto& method = static_cast<SmoothMethod&>(**made);
  const auto set = std::make_unique<LocalSet>();
  const std::size_t stride = std::max<std::size_t>(1, trajectory.p_SD.size() / 1000);
  const CpuPin pin;
  LeastOfCalls swaps;
  for (int repetition = 0; repetition < settings.repetitions; ++repetition) {
    swaps.begin();
    for (std::size_t i = 0; i < trajectory.p_SD.size(); i += stride) {
      const Vec3& p = trajectory.p_SD[i];
      method.reset(p);
      method.scene().select({p, p}, settings.set_size, *set);
      const std::uint64_t before = method.counters().offered;
      const std::uint64_t from = Stopwatch::ticks();
      method.offer(*set);
      const double ns = watch.ns_between(from, Stopwatch::ticks());
      if (method.counters().offered > before) swaps.add(ns);
    }
  }
  return swaps.take();
}

}  // namespace

Result<SmoothTasks> measure_smooth_tasks(const SmoothTasksSettings& settings, const Stopwatch& watch, const TouchScene& scene,
                                         double rate_hz) {
  const auto rows = static_cast<std::size_t>(std::max(2.0, std::round(settings.seconds * rate_hz)));
  const auto trajectory = make_slide_trajectory(*scene.objects.front().mesh, {.seed = settings.seed, .rows = rows, .rate_hz = rate_hz});
  if (!trajectory) return tl::unexpected(trajectory.error());
  SmoothTasks tasks;
  tasks.rate_hz = rate_hz;
  tasks.steps = trajectory->p_SD.size();
  Runs runs;
  runs.busy = LeastTimes(tasks.steps);
  StepFacts facts;
  for (; tasks.repetitions < std::max(1, settings.repetitions); ++tasks.repetitions) {
    auto run = run_once(settings, watch, scene, *trajectory, rate_hz, runs);
    if (!run) return tl::unexpected(run.error());
    if (tasks.repetitions > 0 && !(*run == facts))
      return fail("smooth at {:g} Hz: two repetitions differ in their sets or counts", rate_hz);
    facts = std::move(*run);
  }
  if (facts.offered == 0) return fail("smooth at {:g} Hz: the slow task never gave the fast one a set", rate_hz);
  auto swaps = time_swaps(settings, watch, scene, *trajectory);
  if (!swaps) return tl::unexpected(swaps.error());
  const std::vector<double> at_work = runs.busy.only(facts.at_work);
  tasks.busy = spread_of_times(runs.busy.ns());
  tasks.busy_mean_ns = mean_of(runs.busy.ns());
  tasks.at_work = spread_of_times(at_work);
  tasks.at_work_mean_ns = mean_of(at_work);
  tasks.slow = spread_of_times(runs.slow.take());
  tasks.swap = spread_of_times(std::move(*swaps));
  for (double& age : facts.age_steps) age *= 1e9 / rate_hz;
  tasks.age = spread_of_times(std::move(facts.age_steps));
  tasks.contact_steps = facts.contact;
  tasks.offered = facts.offered;
  tasks.without_set = facts.without_set;
  tasks.beyond_set = facts.beyond_set;
  return tasks;
}

}  // namespace hapton
