#include "bench/papers/hull_directions.h"

#include <algorithm>
#include <memory>

#include "bench/measure/method_run.h"
#include "bench/measure/own_structures.h"
#include "core/force/smooth/smooth_scene.h"
#include "core/geometry/mesh_measures.h"

namespace hapton {
namespace {

Result<void> measure_local_sets(const HullDirectionsSettings& settings, const Stopwatch& watch, const TouchScene& scene,
                                const TouchTrajectory& trajectory, HullDirections& hulls) {
  SmoothSceneSettings own;
  own.directions = hulls.directions;
  const auto smooth = SmoothScene::build(scene, own);
  if (!smooth) return tl::unexpected(smooth.error());
  const auto set = std::make_unique<LocalSet>();
  FdhVisits visits;
  std::size_t queries = 0;
  const TimedSteps timed = time_steps(
      watch, settings.budget, trajectory.p_SD.size(), [&](std::size_t) { set->version = 0; },  // no earlier set bounds the search
      [&](std::size_t i) {
        visits += smooth->select({trajectory.p_SD[i], trajectory.p_SD[i]}, kSetSize, *set);
        ++queries;
      },
      [](std::size_t) {});
  hulls.local_set = spread_of_times(timed.least.ns());
  hulls.nodes = static_cast<double>(visits.nodes) / static_cast<double>(std::max<std::size_t>(1, queries));
  hulls.triangles = static_cast<double>(visits.items) / static_cast<double>(std::max<std::size_t>(1, queries));
  return {};
}

}  // namespace

Result<std::vector<HullDirections>> compare_hull_directions(const HullDirectionsSettings& settings, const Stopwatch& watch,
                                                            const TriangleMesh& mesh) {
  TouchScene scene;
  scene.objects.push_back({std::make_shared<TriangleMesh>(mesh), Material{}});
  const auto trajectory = make_slide_trajectory(mesh, {.seed = settings.seed, .rows = settings.steps, .rate_hz = 1000.0});
  if (!trajectory) return tl::unexpected(trajectory.error());
  MethodSettings proxy;
  const auto felt = compute_forces(proxy, scene, *trajectory);
  if (!felt) return tl::unexpected(felt.error());
  const double extent_m = compute_bounds(mesh).extent();
  const TouchQueries queries = make_queries(*felt, trajectory->reset_every, extent_m);
  const BruteResults truth = query_by_brute_force(mesh, queries);
  std::vector<HullDirections> all;
  for (const QueryStructureKind& kind : own_structures()) {
    if (kind.name != "fdh") continue;
    HullDirections hulls;
    hulls.directions = kind.parameter;
    auto timing = time_structure(watch, settings.budget, kind, mesh, queries, truth, extent_m);
    if (!timing) return tl::unexpected(timing.error());
    hulls.structure = *timing;
    if (auto done = measure_local_sets(settings, watch, scene, *trajectory, hulls); !done) return tl::unexpected(done.error());
    all.push_back(hulls);
  }
  std::sort(all.begin(), all.end(), [](const HullDirections& a, const HullDirections& b) { return a.directions < b.directions; });
  return all;
}

}  // namespace hapton
