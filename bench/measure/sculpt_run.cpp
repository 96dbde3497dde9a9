#include "bench/measure/sculpt_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <set>
#include <string_view>
#include <utility>

#include "core/force/force_method.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "core/sculpt/surface_nets.h"

namespace hapton {
namespace {

using SculptJson = nlohmann::ordered_json;

constexpr double kHandSpeedMPerS = 0.2;       // m/s, the speed of a hand at work
constexpr std::size_t kStepsPerSurface = 33;  // steps of 1 ms after which vision_node computes the carved surface anew (CarvedObjects)

struct SculptShape {
  std::string name;
  TriangleMesh mesh;
};

// About 100 mm wide, like a lump of clay between two hands.
std::vector<SculptShape> sculpt_shapes() {
  return {{"ball", make_icosphere(0.05, 5)}, {"box", make_box(Vec3(0.1, 0.08, 0.06))}, {"torus", make_torus(0.035, 0.015, 96, 48)}};
}

struct SculptMotion {
  std::vector<Vec3> hand;
  std::vector<std::uint32_t> buttons;
};

SculptMotion make_motion(const MeshBounds& bounds, std::size_t steps, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> share(-0.6, 0.6);
  const auto point = [&] {
    return Vec3(bounds.centre() + (bounds.high - bounds.low).cwiseProduct(Vec3(share(random), share(random), share(random))));
  };
  SculptMotion motion;
  Vec3 at = bounds.centre() + 0.8 * (bounds.high - bounds.low);  // outside at the beginning
  Vec3 goal = point();
  bool is_down = false;
  std::size_t until = 0;
  for (std::size_t i = 0; i < steps; ++i) {
    if (i >= until) {
      is_down = random() % 3 != 0;
      until = i + 200 + random() % 400;
    }
    const Vec3 to_goal = goal - at;
    const double step_m = 1e-3 * kHandSpeedMPerS;
    if (to_goal.norm() <= step_m) {
      at = goal;
      goal = point();
    } else {
      at += to_goal * (step_m / to_goal.norm());
    }
    motion.hand.push_back(at);
    motion.buttons.push_back(is_down ? 1U : 0U);
  }
  return motion;
}

struct MadeAt {
  std::size_t step = 0;
  MadeCarve made;
};

double ms_since(const Stopwatch& watch, std::uint64_t start) { return 1e-6 * watch.ns_between(start, Stopwatch::ticks()); }

// The shortest of this many repetitions counts, as for the steps, because other programs have delayed it least. A free choice.
constexpr int kRepetitions = 4;

// For each 33 ms of carving: the time of the work that the thread of CarvedObjects then does, without preparing the surface for drawing.
std::vector<double> time_surfaces_once(const Stopwatch& watch, const CarvedField& uncarved, const std::vector<MadeAt>& carves) {
  CarvedField field = uncarved;
  SurfaceNets nets;
  SurfaceNet net;
  std::vector<double> ns;
  for (std::size_t i = 0; i < carves.size();) {
    const std::size_t surface = carves[i].step / kStepsPerSurface;
    const std::uint64_t start = Stopwatch::ticks();
    std::set<SurfaceNets::Index> blocks;
    for (; i < carves.size() && carves[i].step / kStepsPerSurface == surface; ++i) {
      const CarvedFieldBox box = field.carve(carves[i].made.carve);
      const SurfaceNets::Blocks changed = SurfaceNets::find_changed(field.nodes(), box.low, box.high);
      for (int z = changed.first[2]; z < changed.end[2]; ++z) {
        for (int y = changed.first[1]; y < changed.end[1]; ++y) {
          for (int x = changed.first[0]; x < changed.end[0]; ++x) blocks.insert({x, y, z});
        }
      }
    }
    for (const SurfaceNets::Index& block : blocks) {
      for (const int stride : {1, 2, 4}) nets.compute({field.values(), field.nodes()}, block, stride, net);
    }
    ns.push_back(watch.ns_between(start, Stopwatch::ticks()));
  }
  return ns;
}

TimeSpread time_surfaces(const Stopwatch& watch, const CarvedField& uncarved, const std::vector<MadeAt>& carves) {
  std::vector<double> least = time_surfaces_once(watch, uncarved, carves);
  for (int again = 1; again < kRepetitions; ++again) {
    const std::vector<double> ns = time_surfaces_once(watch, uncarved, carves);
    for (std::size_t i = 0; i < least.size(); ++i) least[i] = std::min(least[i], ns[i]);
  }
  return spread_of_times(std::move(least));
}

template <class Once>
double find_least_ms(Once&& once) {
  double least_ms = once();
  for (int again = 1; again < kRepetitions; ++again) least_ms = std::min(least_ms, once());
  return least_ms;
}

double time_whole_surface(const Stopwatch& watch, const CarvedField& field) {
  SurfaceNets nets;
  SurfaceNet net;
  const std::uint64_t start = Stopwatch::ticks();
  const SurfaceNets::Index count = SurfaceNets::count_blocks(field.nodes());
  for (int z = 0; z < count[2]; ++z) {
    for (int y = 0; y < count[1]; ++y) {
      for (int x = 0; x < count[0]; ++x) {
        for (const int stride : {1, 2, 4}) nets.compute({field.values(), field.nodes()}, {x, y, z}, stride, net);
      }
    }
  }
  return ms_since(watch, start);
}

double time_undo(const Stopwatch& watch, const CarvedField& uncarved, const std::vector<MadeAt>& carves) {
  CarveList list;
  CarvedField field = uncarved;
  for (const MadeAt& one : carves) {
    list.add(one.made);
    field.carve(one.made.carve);
  }
  if (list.newest() == 0) return 0.0;
  const CarveRange press = list.find_press(list.newest());
  const std::uint64_t start = Stopwatch::ticks();
  list.undo(press);
  restore_undone(list, 0, press, uncarved, field);
  return ms_since(watch, start);
}

Result<SculptRunRow> measure_body(const SculptShape& shape, int grid, double radius_voxels, std::uint64_t seed,
                                  const SculptRunSettings& settings, const Stopwatch& watch,
                                  const std::function<void(std::string_view)>& report_part) {
  report_part("steps");
  const MeshBounds bounds = compute_bounds(shape.mesh);
  const double voxel_m = (bounds.high - bounds.low).maxCoeff() / grid;
  const TouchScene scene{
      .objects = {{.mesh = std::make_shared<const TriangleMesh>(shape.mesh),
                   .material = {.stiffness_n_per_m = 500.0},
                   .sculpt = SculptSettings{.voxel_m = voxel_m, .tool_radius_m = radius_voxels * voxel_m, .button = 1}}}};
  SculptRunRow row{.shape = shape.name, .grid = grid, .radius_voxels = radius_voxels, .seed = seed};
  const std::uint64_t start = Stopwatch::ticks();
  auto made = make_method({.name = "proxy"}, scene);
  if (!made) return tl::unexpected(made.error());
  row.make_ms = ms_since(watch, start);
  ForceMethod& method = **made;
  const Sculpture uncarved = *method.sculpture();
  const CarvedField& field = uncarved.bodies()[0].field;
  row.nodes = field.grid().size();
  const SculptMotion motion = make_motion(bounds, settings.steps, seed);
  MethodOutput output;
  const auto before = [&](std::size_t i) {
    if (i != 0) return;
    Sculpture again = uncarved;
    method.restore_sculpture(again, 0);
    method.reset(motion.hand[0]);
  };
  const auto step = [&](std::size_t i) { output = method.step({.p_SD = motion.hand[i], .dt_s = 1e-3, .buttons = motion.buttons[i]}); };
  const TimedSteps timed = time_steps(watch, settings.budget, settings.steps, before, step, [](std::size_t) {});
  // Runs once more, untimed, to find out which steps carved and which touched.
  std::vector<std::uint8_t> is_carving(settings.steps), is_touching(settings.steps);
  std::vector<MadeAt> carves;
  for (std::size_t i = 0; i < settings.steps; ++i) {
    before(i);
    step(i);
    const std::optional<MadeCarve>& carved = method.sculpture()->made();
    if (carved) carves.push_back({i, *carved});
    is_carving[i] = carved ? 1 : 0;
    is_touching[i] = !carved && output.contact ? 1 : 0;
  }
  row.carves = carves.size();
  row.presses = static_cast<std::size_t>(std::count_if(carves.begin(), carves.end(), [](const MadeAt& one) { return one.made.begins; }));
  row.all = spread_of_times(timed.least.ns());
  row.carving = spread_of_times(timed.least.only(is_carving));
  row.touching = spread_of_times(timed.least.only(is_touching));
  report_part("surfaces");
  row.surface = time_surfaces(watch, field, carves);
  row.whole_ms = find_least_ms([&] { return time_whole_surface(watch, method.sculpture()->bodies()[0].field); });
  row.undo_ms = find_least_ms([&] { return time_undo(watch, field, carves); });
  return row;
}

SculptJson sculpt_spread_json(const TimeSpread& spread) {
  return {{"count", spread.count}, {"p50_ns", spread.p50_ns}, {"p99_ns", spread.p99_ns}, {"worst_ns", spread.worst_ns}};
}

}  // namespace

double SculptRunReport::worst_step_ns() const {
  double worst_ns = 0.0;
  for (const SculptRunRow& row : rows) worst_ns = std::max(worst_ns, row.all.worst_ns);
  return worst_ns;
}

double SculptRunReport::least_surface_hz() const {
  double worst_ns = 0.0;
  for (const SculptRunRow& row : rows) worst_ns = std::max(worst_ns, row.surface.worst_ns);
  return worst_ns > 0.0 ? 1e9 / worst_ns : 0.0;
}

Result<SculptRunReport> measure_sculpting(const SculptRunSettings& settings, const Stopwatch& watch, const Progress& progress) {
  const std::uint64_t start = Stopwatch::ticks();
  SculptRunReport report;
  report.conditions = begin_conditions(watch, settings.seeds.empty() ? 0 : settings.seeds.front());
  report.steps = settings.steps;
  const std::vector<SculptShape> shapes = sculpt_shapes();
  const std::size_t rows = shapes.size() * settings.grids.size() * settings.radii_voxels.size() * settings.seeds.size();
  for (const SculptShape& shape : shapes) {
    for (const int grid : settings.grids) {
      for (const double radius : settings.radii_voxels) {
        for (const std::uint64_t seed : settings.seeds) {
          const auto report_part = [&](std::string_view what) {
            progress(fmt::format("{} of {}: {}, {} voxels, ball of {:g}, seed {}: {}", report.rows.size() + 1, rows, shape.name, grid,
                                 radius, seed, what));
          };
          auto row = measure_body(shape, grid, radius, seed, settings, watch, report_part);
          if (!row) return tl::unexpected(row.error());
          report.rows.push_back(std::move(*row));
        }
      }
    }
  }
  end_conditions(report.conditions, start, watch);
  return report;
}

std::string to_csv(const SculptRunReport& report) {
  std::string text =
      "shape,grid,radius_voxels,seed,nodes,carves,presses,make_ms,p50_ns,p99_ns,worst_ns,carving_p50_ns,carving_p99_ns,carving_worst_ns,"
      "touching_p50_ns,touching_p99_ns,touching_worst_ns,surface_p50_ns,surface_p99_ns,surface_worst_ns,whole_surface_ms,undo_ms\n";
  const auto add = [&](const TimeSpread& spread) {
    fmt::format_to(std::back_inserter(text), ",{:.6g},{:.6g},{:.6g}", spread.p50_ns, spread.p99_ns, spread.worst_ns);
  };
  for (const SculptRunRow& row : report.rows) {
    fmt::format_to(std::back_inserter(text), "{},{},{:g},{},{},{},{},{:.4g}", row.shape, row.grid, row.radius_voxels, row.seed, row.nodes,
                   row.carves, row.presses, row.make_ms);
    for (const TimeSpread* spread : {&row.all, &row.carving, &row.touching, &row.surface}) add(*spread);
    fmt::format_to(std::back_inserter(text), ",{:.4g},{:.4g}\n", row.whole_ms, row.undo_ms);
  }
  return text;
}

std::string to_json(const SculptRunReport& report) {
  SculptJson json = to_json(report.conditions, "hapton bench sculpt");
  json["steps"] = report.steps;
  json["worst_step_ns"] = report.worst_step_ns();
  json["least_surface_hz"] = report.least_surface_hz();
  json["rows"] = SculptJson::array();
  for (const SculptRunRow& row : report.rows) {
    json["rows"].push_back(SculptJson{{"shape", row.shape},
                                      {"grid", row.grid},
                                      {"radius_voxels", row.radius_voxels},
                                      {"seed", row.seed},
                                      {"nodes", row.nodes},
                                      {"carves", row.carves},
                                      {"presses", row.presses},
                                      {"make_ms", row.make_ms},
                                      {"all", sculpt_spread_json(row.all)},
                                      {"carving", sculpt_spread_json(row.carving)},
                                      {"touching", sculpt_spread_json(row.touching)},
                                      {"surface", sculpt_spread_json(row.surface)},
                                      {"whole_surface_ms", row.whole_ms},
                                      {"undo_ms", row.undo_ms}});
  }
  return json.dump(1, ' ', false, SculptJson::error_handler_t::replace) + "\n";
}

std::string to_text(const SculptRunReport& report) {
  std::string text = fmt::format(
      "{:<6} {:>5} {:>5} {:>4} {:>7} | {:>6} {:>6} {:>6} | {:>6} {:>6} {:>6} | {:>6} {:>6} {:>6} | {:>6} {:>6} {:>6}\n", "", "grid", "ball",
      "seed", "carves", "step", "p99", "worst", "carve", "p99", "worst", "touch", "p99", "worst", "mesh", "whole", "undo");
  text +=
      fmt::format("{:<6} {:>5} {:>5} {:>4} {:>7} | {:>20} | {:>20} | {:>20} | {:>20}\n", "", "", "voxel", "", "", "us", "us", "us", "ms");
  for (const SculptRunRow& row : report.rows) {
    fmt::format_to(std::back_inserter(text), "{:<6} {:>5} {:>5g} {:>4} {:>7}", row.shape, row.grid, row.radius_voxels, row.seed,
                   row.carves);
    for (const TimeSpread* spread : {&row.all, &row.carving, &row.touching}) {
      fmt::format_to(std::back_inserter(text), " | {:>6.1f} {:>6.1f} {:>6.1f}", 1e-3 * spread->p50_ns, 1e-3 * spread->p99_ns,
                     1e-3 * spread->worst_ns);
    }
    fmt::format_to(std::back_inserter(text), " | {:>6.2f} {:>6.1f} {:>6.2f}\n", 1e-6 * row.surface.worst_ns, row.whole_ms, row.undo_ms);
  }
  const double worst_us = 1e-3 * report.worst_step_ns();
  fmt::format_to(std::back_inserter(text), "worst step {:.0f} us (goal {:.0f}: {}); slowest surface {:.0f} a second (goal {:.0f}: {})\n",
                 worst_us, 1e-3 * SculptRunReport::kMaxStepNs, report.worst_step_ns() <= SculptRunReport::kMaxStepNs ? "met" : "missed",
                 report.least_surface_hz(), SculptRunReport::kMinSurfaceHz,
                 report.least_surface_hz() >= SculptRunReport::kMinSurfaceHz ? "met" : "missed");
  return text + report.conditions.to_text() + ".\n";
}

}  // namespace hapton
