#include "bench/measure/effects_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;

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
  const std::vector<EffectCase> on_plane = make_effect_cases(effect_plane());
  for (const EffectCase& one : make_effect_cases(*mesh)) {
    progress(one.name);
    const TouchScene scene = {.objects = {{mesh, {}, one.surface}}, .effects = one.space};
    const auto timing = time_method(watch, settings.budget, {}, scene, *slide);
    if (!timing) return tl::unexpected(timing.error());
    const double alone_ns = report.rows.empty() ? timing->contact.p50_ns : report.rows.front().contact.p50_ns;
    const auto error = measure_effect_error(on_plane[report.rows.size()], {.steps = settings.steps, .seed = settings.seed});
    if (!error) return tl::unexpected(error.error());
    report.rows.push_back({.effect = one.name,
                           .contact = timing->contact,
                           .mean_ns = timing->mean_ns,
                           .added_ns = timing->contact.p50_ns - alone_ns,
                           .error = *error});
  }
  end_conditions(report.conditions, start, watch);
  return report;
}

std::string to_csv(const EffectsReport& report) {
  std::string text = "effect,contact_steps,p50_ns,p99_ns,worst_ns,mean_ns,added_ns,error_rms,error_worst_n\n";
  for (const EffectsRow& row : report.rows) {
    fmt::format_to(std::back_inserter(text), "\"{}\",{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},", row.effect, row.contact.count,
                   row.contact.p50_ns, row.contact.p99_ns, row.contact.worst_ns, row.mean_ns, row.added_ns);
    text += row.error ? fmt::format("{:.3g},{:.3g}\n", row.error->rms, row.error->worst_n) : ",\n";
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
                                {"added_ns", row.added_ns},
                                {"error_rms", row.error ? Json(row.error->rms) : Json(nullptr)},
                                {"error_worst_n", row.error ? Json(row.error->worst_n) : Json(nullptr)}});
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_text(const EffectsReport& report) {
  std::string text = fmt::format("{:<24} {:>8} {:>8} {:>8} {:>8}   {:>8}   {:>9} {:>9}\n", "ns, contact step", "p50", "added", "p99",
                                 "worst", "mean", "error rms", "worst N");
  for (const EffectsRow& row : report.rows) {
    fmt::format_to(std::back_inserter(text), "{:<24} {:>8.0f} {:>8.0f} {:>8.0f} {:>8.0f}   {:>8.1f}   ", row.effect, row.contact.p50_ns,
                   row.added_ns, row.contact.p99_ns, row.contact.worst_ns, row.mean_ns);
    text += row.error ? fmt::format("{:>7.2g} % {:>9.2g}\n", 100.0 * row.error->rms, row.error->worst_n)
                      : fmt::format("{:>9} {:>9}\n", "-", "-");
  }
  return text + report.conditions.to_text() + ".\n";
}

}  // namespace hapton
