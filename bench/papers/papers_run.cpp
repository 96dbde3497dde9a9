#include "bench/papers/papers_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "bench/haptons/hapton_run.h"
#include "bench/measure/method_run.h"
#include "core/collision/uniform_grid.h"

namespace hapton {
namespace {

constexpr int kMemoDivision = 32;  // cells along each axis, as in the memo
constexpr std::array kRatesHz = {1000.0, 3000.0, 10000.0};

void fill_in(PapersReport& report, std::string_view key, double ours, std::string how) {
  PaperRow& row = report.row(key);
  row.ours = ours;
  row.how = std::move(how);
}

TouchScene scene_of(const PapersMesh& mesh) {
  TouchScene scene;
  scene.objects.push_back({mesh.mesh, Material{}});
  return scene;
}

Result<void> measure_grid(const PapersMesh& car, PapersReport& report) {
  std::vector<std::array<Vec3, 3>> triangles(car.mesh->triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i)
    triangles[i] = {car.mesh->corner(i, 0), car.mesh->corner(i, 1), car.mesh->corner(i, 2)};
  const auto grid = UniformGrid::make(triangles, {kMemoDivision, kMemoDivision, kMemoDivision});
  if (!grid) return tl::unexpected(grid.error());
  const GridOccupancy& full = grid->occupancy();
  const std::string how =
      fmt::format("{}, {} triangles; not the memo's own car; a triangle is in every cell it touches", car.name, triangles.size());
  fill_in(report, "memo.grid_occupied", 100.0 * full.occupied_share(), how);
  fill_in(report, "memo.grid_mean", full.mean_triangles_a_cell(), "the same");
  fill_in(report, "memo.grid_max", static_cast<double>(full.max_triangles_a_cell), "the same");
  return {};
}

// Measures the memo's method. With division 1 the grid has one cell, so every step tests every triangle.
Result<void> measure_force_rate(const PapersSettings& settings, const Stopwatch& watch, const PapersMesh& car, int division,
                                std::string_view key, PapersReport& report) {
  const TouchScene scene = scene_of(car);
  const auto slide = make_slide_trajectory(*car.mesh, {.seed = settings.seed, .rows = settings.steps, .rate_hz = 1000.0});
  if (!slide) return tl::unexpected(slide.error());
  MethodSettings sweep;
  sweep.name = "sweep";
  sweep.grid_division = {division, division, division};
  const auto timing = time_method(watch, settings.budget, sweep, scene, *slide);
  if (!timing) return tl::unexpected(timing.error());
  fill_in(report, key, 1e9 / timing->all.worst_ns,
          fmt::format("one over the worst of {} steps of method sweep, grid {}^3 ({:.3g} us; p50 {:.3g} us), one core, least of {}",
                      timing->all.count, division, 1e-3 * timing->all.worst_ns, 1e-3 * timing->all.p50_ns, timing->repetitions));
  return {};
}

void measure_hapton_rows(const PapersSettings& settings, PapersReport& report) {
  HaptonRunSettings own;
  own.pairs.seed = settings.seed;
  own.seconds = settings.hapton_seconds;
  const HaptonRun run = measure_haptons(own);
  for (const HaptonResult& result : run.results) {
    if (result.is_peer || !result.holds()) continue;
    if (result.p50_haptons <= report.row("memo.haptons").ours.value_or(0.0)) continue;
    fill_in(report, "memo.haptons", result.p50_haptons,
            fmt::format("{}; p50 of batches, all {} pairs located to 0.1 % in this run", result.name, result.checked));
    fill_in(report, "memo.haptons_capable", result.p50_haptons, "the same");
  }
  if (!report.row("memo.haptons").ours) {
    report.row("memo.haptons").how = "no collider located every pair to 0.1 %; hapton bench haptons tells more";
    report.row("memo.haptons_capable").how = "the same";
  }
}

Result<void> measure_tasks(const PapersSettings& settings, const Stopwatch& watch, const PapersMesh& mesh, PapersReport& report) {
  const TouchScene scene = scene_of(mesh);
  SmoothTasksSettings own;
  own.seed = settings.seed;
  own.seconds = settings.touch_seconds;
  own.repetitions = settings.budget.repetitions;
  for (const double rate_hz : kRatesHz) {
    const auto tasks = measure_smooth_tasks(own, watch, scene, rate_hz);
    if (!tasks) return tl::unexpected(tasks.error());
    report.tasks.push_back(*tasks);
  }
  report.tasks_mesh = fmt::format("{} ({} triangles)", mesh.name, mesh.mesh->triangles.size());
  const SmoothTasks& at_1khz = report.tasks[0];
  const SmoothTasks& at_3khz = report.tasks[1];
  const SmoothTasks& at_10khz = report.tasks[2];
  const std::string query = fmt::format("slow task of method smooth on {}: selection of 64 triangles and hand-over, {} sets, least of {}",
                                        report.tasks_mesh, at_1khz.slow.count, at_1khz.repetitions);
  fill_in(report, "fdh.query_typical", 1e-6 * at_1khz.slow.p50_ns, "p50: " + query);
  fill_in(report, "fdh.query_most", 1e-6 * at_1khz.slow.worst_ns, "worst: " + query);
  const auto idle = [](const SmoothTasks& t) {
    return fmt::format("1 - mean step with triangles in reach ({:.3g} us) / period, --layer 1, {} steps; after the worst step {:.1f} %",
                       1e-3 * t.at_work_mean_ns, t.at_work.count, 100.0 * t.idle_share_worst());
  };
  fill_in(report, "fdh.idle_1khz", 100.0 * at_1khz.idle_share_at_work(), idle(at_1khz));
  fill_in(report, "fdh.idle_3khz", 100.0 * at_3khz.idle_share_at_work(), idle(at_3khz));
  fill_in(report, "fdh.idle_10khz", 100.0 * at_10khz.idle_share_at_work(), idle(at_10khz));
  const SmoothTasks& slowest =
      *std::max_element(report.tasks.begin(), report.tasks.end(),
                        [](const SmoothTasks& one, const SmoothTasks& other) { return one.busy.worst_ns < other.busy.worst_ns; });
  fill_in(report, "fdh.rate", 1e9 / slowest.busy.worst_ns,
          fmt::format("one over the worst step of all three runs ({:.3g} us, of {} at {:g} kHz), device and link left out",
                      1e-3 * slowest.busy.worst_ns, slowest.steps, 1e-3 * slowest.rate_hz));
  fill_in(report, "fdh.swap", 1e-3 * at_1khz.swap.p50_ns, fmt::format("p50 of {} sets taken over by copying", at_1khz.swap.count));
  fill_in(report, "fdh.without_set", 100.0 * at_1khz.share_without_set(),
          fmt::format("{} of {} steps, slow task every 10 ms; {} sets handed over; age of the set p50 {:.1f} ms", at_1khz.without_set,
                      at_1khz.steps, at_1khz.offered, 1e-6 * at_1khz.age.p50_ns));
  return {};
}

Result<void> measure_hulls(const PapersSettings& settings, const Stopwatch& watch, const PapersMesh& mesh, PapersReport& report) {
  auto hulls = compare_hull_directions(
      {.seed = settings.seed, .steps = std::min<std::size_t>(settings.steps, 6000), .budget = settings.budget}, watch, *mesh.mesh);
  if (!hulls) return tl::unexpected(hulls.error());
  report.hulls = std::move(*hulls);
  report.hulls_mesh = fmt::format("{} ({} triangles)", mesh.name, mesh.mesh->triangles.size());
  const HullDirections& boxes = report.hulls[0];
  const HullDirections& fdh14 = report.hulls[1];
  fill_in(report, "fdh.boxes_time", fdh14.local_set.p50_ns / boxes.local_set.p50_ns,
          fmt::format("p50 {:.3g} us over {:.3g} us, both trees by one template", 1e-3 * fdh14.local_set.p50_ns,
                      1e-3 * boxes.local_set.p50_ns));
  fill_in(report, "fdh.boxes_triangles", fdh14.triangles / boxes.triangles,
          fmt::format("{:.1f} over {:.1f} a query; nodes {:.1f} over {:.1f}", fdh14.triangles, boxes.triangles, fdh14.nodes, boxes.nodes));
  return {};
}

}  // namespace

Result<void> measure_papers(const PapersSettings& settings, const Stopwatch& watch, const PapersMesh& car, const PapersMesh& paper_mesh,
                            const std::function<void(const std::string&)>& progress, PapersReport& report) {
  progress("grid and force rates on " + car.name);
  if (auto done = measure_grid(car, report); !done) return done;
  if (auto done = measure_force_rate(settings, watch, car, kMemoDivision, "memo.force_rate_grid", report); !done) return done;
  if (auto done = measure_force_rate(settings, watch, car, 1, "memo.force_rate_all", report); !done) return done;
  progress("haptons");
  measure_hapton_rows(settings, report);
  progress("the FDH paper's two tasks on " + paper_mesh.name);
  if (auto done = measure_tasks(settings, watch, paper_mesh, report); !done) return done;
  progress("hulls of 6, 14, 18 and 26 directions");
  return measure_hulls(settings, watch, paper_mesh, report);
}

}  // namespace hapton
