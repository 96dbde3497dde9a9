#include "tools/check/step_cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/force/force_method.h"
#include "core/geometry/touch_trajectory.h"
#include "tools/session/replay.h"

namespace hapton {
namespace {

// The objects with the most triangles, the largest first.
std::vector<std::size_t> choose_objects(const Scene& scene) {
  std::vector<std::size_t> order(scene.objects.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto triangles = [&](std::size_t i) { return scene.objects[i].mesh->triangles.size(); };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return triangles(i) > triangles(j); });
  order.resize(std::min(order.size(), kMaxSlideObjects));
  return order;
}

std::vector<TrajectoryRow> make_rows(const TouchTrajectory& path, double rate_hz) {
  std::vector<TrajectoryRow> rows;
  rows.reserve(path.p_SD.size());
  for (const Vec3& p : path.p_SD) rows.push_back({.t_s = static_cast<double>(rows.size()) / rate_hz, .p_WD = p});
  return rows;
}

}  // namespace

Result<StepCost> measure_step_cost(const Scene& scene, const StepCostSettings& settings) {
  MethodSettings method_settings;
  method_settings.probe_radius_m = settings.probe_radius_m;
  auto method = make_method(method_settings, scene.touch_scene());
  if (!method) return tl::unexpected(method.error());
  TouchStep touch(std::move(*method), scene.touch_scene());
  const SteadyClock clock;
  const std::vector<std::size_t> chosen = choose_objects(scene);
  const double rate_hz = std::min(settings.rate_hz, kMaxSlideHz);
  const std::size_t steps =
      std::max(static_cast<std::size_t>(kMinSlideS * rate_hz), settings.steps / std::max<std::size_t>(1, chosen.size()));
  StepCost cost;
  std::vector<std::int64_t> times;
  for (const std::size_t i : chosen) {
    const SceneObject& object = scene.objects[i];
    const auto path = make_slide_trajectory(*object.mesh, {.seed = settings.seed + i, .rows = steps, .rate_hz = rate_hz});
    if (!path) return tl::unexpected(Error{fmt::format("object '{}': {}", object.name, path.error().what)});
    const ReplaySettings replay_settings{.reset_every = path->reset_every, .repeat = settings.repeat};
    const Replay replay = run_replay(touch, make_rows(*path, rate_hz), replay_settings, clock);
    for (const ReplayRow& row : replay.rows) {
      times.push_back(row.step_ns);
      if (row.step_ns <= cost.worst_ns) continue;
      cost.worst_ns = row.step_ns;
      cost.worst_object = object.name;
      cost.worst_at_m = row.p_WD;
    }
  }
  cost.steps = times.size();
  if (!times.empty()) cost.p99_ns = quantile_ns(times, 0.99);
  return cost;
}

CheckFindings check_cost(const StepCost& cost, double rate_hz) {
  const double cycle_ns = 1e9 / rate_hz;
  const bool is_slow = static_cast<double>(cost.worst_ns) > cycle_ns || static_cast<double>(cost.p99_ns) > kStepShare * cycle_ns;
  if (!is_slow) return {};
  return {{SceneFault::too_slow, cost.worst_object, cost.worst_at_m,
           fmt::format("a step of the force takes {:.3g} us at p99 and {:.3g} us at worst on this machine; a cycle at {:g} Hz is {:g} us",
                       1e-3 * static_cast<double>(cost.p99_ns), 1e-3 * static_cast<double>(cost.worst_ns), rate_hz, 1e-3 * cycle_ns),
           "simplify the mesh there, or lower the rate"}};
}

}  // namespace hapton
