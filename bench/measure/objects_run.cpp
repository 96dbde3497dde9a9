#include "bench/measure/objects_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/force/smooth/smooth_scene.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kRingRadiusM = 0.035;  // of each torus: from its axis to the middle of the tube
constexpr double kTubeRadiusM = 0.015;  // so each torus is 100 mm across
constexpr double kSpacingM = 0.14;      // leaves 40 mm between neighbours; the free trajectory goes 11 mm away from the torus

struct Scenes {
  TouchScene all, alone;
  std::shared_ptr<const TriangleMesh> touched;
};

// Quads are about square if there are twice as many of them round the axis as round the tube.
TriangleMesh make_object(std::size_t triangles) {
  const int around_tube = std::max(3, static_cast<int>(std::lround(std::sqrt(0.25 * static_cast<double>(triangles)))));
  const int around_axis = std::max(3, static_cast<int>(std::lround(0.5 * static_cast<double>(triangles) / around_tube)));
  return make_torus(kRingRadiusM, kTubeRadiusM, around_axis, around_tube);
}

Scenes make_scenes(std::size_t objects, std::size_t triangles) {
  Scenes scenes;
  const TriangleMesh one = make_object(triangles / objects);
  const auto side = static_cast<std::size_t>(std::ceil(std::cbrt(static_cast<double>(objects)) - 1e-9));
  const std::size_t middle = objects / 2;
  const auto place = [side](std::size_t i) {
    return Vec3(static_cast<double>(i % side), static_cast<double>(i / side % side), static_cast<double>(i / (side * side)));
  };
  for (std::size_t i = 0; i < objects; ++i) {
    scenes.all.objects.push_back(
        {std::make_shared<TriangleMesh>(scaled_and_moved(one, 1.0, kSpacingM * (place(i) - place(middle)))), Material{}});
  }
  scenes.touched = scenes.all.objects[middle].mesh;
  scenes.alone.objects.push_back({scenes.touched, Material{}});
  return scenes;
}

// Takes the measurements for one number of objects after the other; each adds its rows.
class Objects {
 public:
  Objects(const ObjectsSettings& settings, const Stopwatch& watch, const Progress& progress)
      : settings_(settings), watch_(watch), progress_(progress) {}

  Result<void> measure(std::size_t objects) {
    scenes_ = make_scenes(objects, settings_.triangles);
    const TrajectorySettings trajectory{.seed = settings_.seed, .rows = settings_.steps, .rate_hz = 1000.0};
    const auto slide = make_slide_trajectory(*scenes_.touched, trajectory);
    if (!slide) return tl::unexpected(slide.error());
    const auto free = make_free_trajectory(*scenes_.touched, trajectory);
    if (!free) return tl::unexpected(free.error());
    for (const double radius : {0.0, kSphereRadiusM}) {
      const std::string probe = radius == 0.0 ? "point" : "sphere of 0.5 mm";
      if (auto done = measure_steps("contact step, " + probe, radius, *slide, &MethodTiming::contact); !done) return done;
      if (auto done = measure_steps("free step, " + probe, radius, *free, &MethodTiming::free); !done) return done;
    }
    return measure_sets(*slide);
  }

  std::vector<ObjectsRow> rows;

 private:
  ObjectsRow begin_row(std::string what) const {
    ObjectsRow row;
    row.objects = scenes_.all.objects.size();
    row.triangles = row.objects * scenes_.touched->triangles.size();
    row.what = std::move(what);
    progress_(fmt::format("{} objects: {}", row.objects, row.what));
    return row;
  }

  Result<void> measure_steps(const std::string& what, double radius, const TouchTrajectory& trajectory, TimeSpread MethodTiming::*part) {
    ObjectsRow row = begin_row(what);
    MethodSettings method;
    method.probe_radius_m = radius;
    const auto all = time_method(watch_, settings_.budget, method, scenes_.all, trajectory);
    if (!all) return tl::unexpected(all.error());
    const auto alone = time_method(watch_, settings_.budget, method, scenes_.alone, trajectory);
    if (!alone) return tl::unexpected(alone.error());
    row.all = (*all).*part;
    row.alone = (*alone).*part;
    row.all_mean_ns = all->mean_ns;
    row.alone_mean_ns = alone->mean_ns;
    rows.push_back(std::move(row));
    return {};
  }

  Result<TimedSteps> time_sets(const TouchScene& scene, const TouchTrajectory& slide) {
    const auto smooth = SmoothScene::build(scene, {});
    if (!smooth) return tl::unexpected(smooth.error());
    const auto set = std::make_unique<LocalSet>();
    return time_steps(
        watch_, settings_.budget, slide.p_SD.size(), [](std::size_t) {},
        [&](std::size_t i) {
          smooth->select({slide.p_SD[i], slide.p_SD[i]}, kSetSize, *set);
        },
        [](std::size_t) {});
  }

  Result<void> measure_sets(const TouchTrajectory& slide) {
    ObjectsRow row = begin_row(fmt::format("local set of {}", kSetSize));
    const auto all = time_sets(scenes_.all, slide);
    if (!all) return tl::unexpected(all.error());
    const auto alone = time_sets(scenes_.alone, slide);
    if (!alone) return tl::unexpected(alone.error());
    row.all = spread_of_times(all->least.ns());
    row.alone = spread_of_times(alone->least.ns());
    row.all_mean_ns = all->mean_ns;
    row.alone_mean_ns = alone->mean_ns;
    rows.push_back(std::move(row));
    return {};
  }

  const ObjectsSettings& settings_;
  const Stopwatch& watch_;
  const Progress& progress_;
  Scenes scenes_;
};

double ratio(double all, double alone) { return alone > 0.0 ? all / alone : 0.0; }

}  // namespace

Result<ObjectsReport> measure_objects(const ObjectsSettings& settings, const Stopwatch& watch, const Progress& progress) {
  const std::uint64_t start = Stopwatch::ticks();
  ObjectsReport report;
  report.conditions = begin_conditions(watch, settings.seed);
  Objects objects(settings, watch, progress);
  for (const std::size_t count : settings.counts) {
    if (count == 0 || count > settings.triangles / 18) {
      return fail("{} objects of {} triangles in all: give 1 to {} objects, so that each has 18 triangles", count, settings.triangles,
                  settings.triangles / 18);
    }
    if (auto done = objects.measure(count); !done) return tl::unexpected(done.error());
  }
  report.rows = std::move(objects.rows);
  end_conditions(report.conditions, start, watch);
  return report;
}

std::string to_csv(const ObjectsReport& report) {
  std::string text =
      "objects,triangles,what,steps,p50_ns,p99_ns,worst_ns,mean_ns,alone_p50_ns,alone_p99_ns,alone_worst_ns,alone_mean_ns,"
      "ratio_p50,ratio_p99,ratio_worst,ratio_mean\n";
  for (const ObjectsRow& row : report.rows) {
    fmt::format_to(
        std::back_inserter(text), "{},{},\"{}\",{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.3f},{:.3f},{:.3f},{:.3f}\n",
        row.objects, row.triangles, row.what, row.all.count, row.all.p50_ns, row.all.p99_ns, row.all.worst_ns, row.all_mean_ns,
        row.alone.p50_ns, row.alone.p99_ns, row.alone.worst_ns, row.alone_mean_ns, ratio(row.all.p50_ns, row.alone.p50_ns),
        ratio(row.all.p99_ns, row.alone.p99_ns), ratio(row.all.worst_ns, row.alone.worst_ns), ratio(row.all_mean_ns, row.alone_mean_ns));
  }
  return text;
}

std::string to_json(const ObjectsReport& report) {
  Json json = to_json(report.conditions, "hapton bench objects");
  const auto spread = [](const TimeSpread& s, double mean_ns) {
    return Json{{"count", s.count},       {"p50_ns", s.p50_ns},     {"p90_ns", s.p90_ns}, {"p99_ns", s.p99_ns},
                {"p99_9_ns", s.p99_9_ns}, {"worst_ns", s.worst_ns}, {"mean_ns", mean_ns}};
  };
  json["rows"] = Json::array();
  for (const ObjectsRow& row : report.rows) {
    json["rows"].push_back(Json{{"objects", row.objects},
                                {"triangles", row.triangles},
                                {"what", row.what},
                                {"all", spread(row.all, row.all_mean_ns)},
                                {"nearest_alone", spread(row.alone, row.alone_mean_ns)}});
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_text(const ObjectsReport& report) {
  std::string text = fmt::format("{:>7} {:>10}  {:<30} {:>27}   {:>27}   {}\n", "", "", "ns", "all: p50    p99  worst", "nearest alone",
                                 "ratio: p50   p99 worst  mean");
  for (const ObjectsRow& row : report.rows) {
    fmt::format_to(
        std::back_inserter(text),
        "{:>7} {:>10}  {:<30} {:>9.0f} {:>8.0f} {:>8.0f}   {:>9.0f} {:>8.0f} {:>8.0f}        {:>5.2f} {:>5.2f} {:>5.2f} {:>5.2f}\n",
        row.objects, row.triangles, row.what, row.all.p50_ns, row.all.p99_ns, row.all.worst_ns, row.alone.p50_ns, row.alone.p99_ns,
        row.alone.worst_ns, ratio(row.all.p50_ns, row.alone.p50_ns), ratio(row.all.p99_ns, row.alone.p99_ns),
        ratio(row.all.worst_ns, row.alone.worst_ns), ratio(row.all_mean_ns, row.alone_mean_ns));
  }
  return text + report.conditions.to_text() + ".\n";
}

}  // namespace hapton
