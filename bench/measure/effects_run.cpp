#include "bench/measure/effects_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;

struct EffectCase {
  std::string name;
  SurfaceEffects surface;
  std::vector<SpaceEffect> space;
};

SurfaceEffects made_layers() {
  SurfaceEffects effects;
  for (int i = 0; i < 8; ++i) {
    effects.layers.add({.depth_m = 1e-3 * i, .stiffness_n_per_m = 1000.0, .pop_force_n = 0.5, .drag_ns_per_m = 1.0});
  }
  return effects;
}

SurfaceEffects all_of_a_surface() {
  return {.progressive = {.n_per_m2 = 1e5},
          .layers = {},
          .bumps = {.height_m = 2e-4, .length_m = 2e-3},
          .viscosity = {.damping_ns_per_m = 3.0},
          .snap = {.range_m = 2e-3},
          .tap = {.ns_per_m = 5.0}};
}

std::vector<SpaceEffect> all_of_space() {
  const auto everywhere = EffectVolume::ball(Vec3::Zero(), 1.0);
  return {SpringEffect{},
          ConstantEffect{.force_n = {0, -0.2, 0}, .volume = everywhere},
          SnapEffect{.range_m = 0.2},
          SnapEffect{.target = SnapEffect::Target::line, .range_m = 0.2},
          SnapEffect{.target = SnapEffect::Target::plane, .range_m = 0.2},
          GravityWellEffect{},
          ViscousEffect{.volume = everywhere},
          WaveEffect{.volume = everywhere},
          BurstEffect{.decay_s = 50.0, .duration_s = 60.0, .volume = EffectVolume::box({-1, -1, 0}, {1, 1, 1})}};
}

std::vector<EffectCase> make_cases() {
  std::vector<EffectCase> cases = {
      {"none", {}, {}},
      {"progressive stiffness", {.progressive = {.n_per_m2 = 1e5}}, {}},
      {"8 layers", made_layers(), {}},
      {"bumps, ridges", {.bumps = {.pattern = SurfaceBumps::Pattern::ridges, .height_m = 2e-4, .length_m = 2e-3}}, {}},
      {"bumps, grid", {.bumps = {.height_m = 2e-4, .length_m = 2e-3}}, {}},
      {"viscosity", {.viscosity = {.damping_ns_per_m = 3.0}}, {}},
      {"snap", {.snap = {.range_m = 2e-3}}, {}},
      {"vibration on tap", {.tap = {.ns_per_m = 5.0, .decay_s = 60.0}}, {}},
      {"all of a surface", all_of_a_surface(), {}},
  };
  const std::vector<std::string> names = {"spring",       "constant", "magnet", "line snap", "plane snap",
                                          "gravity well", "viscous",  "wave",   "burst"};
  const std::vector<SpaceEffect> space = all_of_space();
  for (std::size_t i = 0; i < space.size(); ++i) cases.push_back({names[i], {}, {space[i]}});
  cases.push_back({"all of space", {}, space});
  cases.push_back({"all of both", all_of_a_surface(), space});
  return cases;
}

std::shared_ptr<const TriangleMesh> make_mesh(std::size_t triangles) {
  const int around_tube = std::max(3, static_cast<int>(std::lround(std::sqrt(0.25 * static_cast<double>(triangles)))));
  const int around_axis = std::max(3, static_cast<int>(std::lround(0.5 * static_cast<double>(triangles) / around_tube)));
  return std::make_shared<const TriangleMesh>(make_torus(0.035, 0.015, around_axis, around_tube));
}

}  // namespace

Result<EffectsReport> measure_effects(const EffectsSettings& settings, const Stopwatch& watch, const Progress& progress) {
  const std::uint64_t start = Stopwatch::ticks();
  EffectsReport report;
  report.conditions = begin_conditions(watch, settings.seed);
  const auto mesh = make_mesh(settings.triangles);
  const auto slide = make_slide_trajectory(*mesh, {.seed = settings.seed, .rows = settings.steps, .rate_hz = 1000.0});
  if (!slide) return tl::unexpected(slide.error());
  for (const EffectCase& one : make_cases()) {
    progress(one.name);
    const TouchScene scene = {.objects = {{mesh, {}, one.surface}}, .effects = one.space};
    const auto timing = time_method(watch, settings.budget, {}, scene, *slide);
    if (!timing) return tl::unexpected(timing.error());
    const double alone_ns = report.rows.empty() ? timing->contact.p50_ns : report.rows.front().contact.p50_ns;
    report.rows.push_back(
        {.effect = one.name, .contact = timing->contact, .mean_ns = timing->mean_ns, .added_ns = timing->contact.p50_ns - alone_ns});
  }
  end_conditions(report.conditions, start, watch);
  return report;
}

std::string to_csv(const EffectsReport& report) {
  std::string text = "effect,contact_steps,p50_ns,p99_ns,worst_ns,mean_ns,added_ns\n";
  for (const EffectsRow& row : report.rows) {
    fmt::format_to(std::back_inserter(text), "\"{}\",{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", row.effect, row.contact.count,
                   row.contact.p50_ns, row.contact.p99_ns, row.contact.worst_ns, row.mean_ns, row.added_ns);
  }
  return text;
}

std::string to_json(const EffectsReport& report) {
  Json json = to_json(report.conditions, "hapton bench effects");
  json["rows"] = Json::array();
  for (const EffectsRow& row : report.rows) {
    json["rows"].push_back(Json{{"effect", row.effect},
                                {"contact_steps", row.contact.count},
                                {"p50_ns", row.contact.p50_ns},
                                {"p99_ns", row.contact.p99_ns},
                                {"worst_ns", row.contact.worst_ns},
                                {"mean_ns", row.mean_ns},
                                {"added_ns", row.added_ns}});
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_text(const EffectsReport& report) {
  std::string text = fmt::format("{:<24} {:>8} {:>8} {:>8} {:>8}   {:>8}\n", "ns, contact step", "p50", "added", "p99", "worst", "mean");
  for (const EffectsRow& row : report.rows) {
    fmt::format_to(std::back_inserter(text), "{:<24} {:>8.0f} {:>8.0f} {:>8.0f} {:>8.0f}   {:>8.1f}\n", row.effect, row.contact.p50_ns,
                   row.added_ns, row.contact.p99_ns, row.contact.worst_ns, row.mean_ns);
  }
  return text + report.conditions.to_text() + ".\n";
}

}  // namespace hapton
