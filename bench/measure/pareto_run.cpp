#include "bench/measure/pareto_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/force/smooth/smooth_force.h"
#include "core/geometry/mesh_measures.h"

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kSphereShare = 0.005;  // radius of the sphere probe as a share of the mesh's extent: 0.5 mm for 100 mm

struct Candidate {
  std::string family, structure;
  MethodSettings settings;
};

std::vector<Candidate> make_candidates(double extent_m) {
  std::vector<Candidate> candidates;
  const auto add = [&](std::string family, std::string structure, auto&& set) {
    MethodSettings settings;
    set(settings);
    candidates.push_back({std::move(family), std::move(structure), settings});
  };
  add("proxy point", "adjacency + wide", [](MethodSettings& s) { s.name = "proxy"; });
  add("proxy sphere", "near triangles + wide", [&](MethodSettings& s) {
    s.name = "proxy";
    s.probe_radius_m = kSphereShare * extent_m;
  });
  for (const int n : {8, 16, 32, 64, 128}) {
    add("sweep", fmt::format("grid {}", n), [n](MethodSettings& s) {
      s.name = "sweep";
      s.grid_division = {n, n, n};
    });
  }
  for (const int n : {16, 32, 64, 128, 256}) {
    add("smooth", fmt::format("fdh 14, set {}", n), [n](MethodSettings& s) {
      s.name = "smooth";
      s.set_size = n;
    });
  }
  // The force layer of the FDH paper with its full weight: the force begins at the distance RADIUS (paper's name) outside the surface.
  for (const int n : {16, 32, 64, 128, 256}) {
    add("smooth layer", fmt::format("fdh 14, set {}, layer 1", n), [n](MethodSettings& s) {
      s.name = "smooth";
      s.set_size = n;
      s.smooth_layer = kFdhPaperLayer;
    });
  }
  for (const int n : {6, 18, 26}) {
    add("smooth", fmt::format("fdh {}, set 64", n), [n](MethodSettings& s) {
      s.name = "smooth";
      s.hull_directions = n;
      s.set_size = 64;
    });
  }
  return candidates;
}

MethodRow row_of_reference(const MethodRow& pattern, const ReferenceRun& run, double probe_radius_m) {
  MethodRow row = pattern;
  row.family = probe_radius_m > 0.0 ? "reference sphere" : "reference";
  row.structure = "none, sub-steps to the limit";
  row.settings.name = "reference";
  row.settings.probe_radius_m = probe_radius_m;
  row.steps = run.trajectory.p_SD.size();
  row.timing.contact = run.time;
  row.timing.all = run.time;
  row.timing.repetitions = 1;
  row.error = run.compare(run.felt);
  return row;
}

Json spread_json(const TimeSpread& s) {
  return {{"n", s.count},       {"p50_ns", s.p50_ns},     {"p90_ns", s.p90_ns},
          {"p99_ns", s.p99_ns}, {"p99_9_ns", s.p99_9_ns}, {"worst_ns", s.worst_ns}};
}
Json spread_json(const ErrorSpread& s) { return {{"n", s.count}, {"rms", s.rms}, {"p50", s.p50}, {"p99", s.p99}, {"max", s.most}}; }

Json query_json(const QueryTiming& q) {
  Json json = spread_json(q.time);
  json["mean_ns"] = q.mean_ns;
  json["repetitions"] = q.repetitions;
  json["found"] = q.found;
  json["compared_with_brute_force"] = q.compared;
  json["agree"] = q.agree;
  return json;
}

Json row_json(const MethodRow& row) {
  const ForceError& e = row.error;
  return {{"mesh", row.mesh},
          {"triangles", row.triangles},
          {"method", row.settings.name},
          {"family", row.family},
          {"structure", row.structure},
          {"smooth_layer", row.settings.smooth_layer},
          {"precision", "double"},
          {"probe_radius_m", row.settings.probe_radius_m},
          {"steps", row.steps},
          {"repetitions", row.timing.repetitions},
          {"mean_ns", row.timing.mean_ns},
          {"contact", spread_json(row.timing.contact)},
          {"free", spread_json(row.timing.free)},
          {"build_ms", row.timing.build_ms},
          {"bytes", row.timing.bytes},
          {"compared_steps", e.steps},
          {"contact_steps", e.contact_steps},
          {"unsettled_steps", e.unsettled_steps},
          {"force_error", spread_json(e.error)},
          {"branch_switches", e.branch_switches},
          {"switched_steps", e.switched_steps},
          {"fall_throughs", e.fall_throughs},
          {"false_contacts", e.false_contacts},
          {"stuck_steps", e.stuck_steps},
          {"force_discontinuities", e.discontinuities},
          {"not_finite", e.not_finite}};
}

std::string label_of(const MethodRow& row) {
  const MethodSettings& s = row.settings;
  if (row.family == "sweep") return fmt::format("{}", s.grid_division[0]);
  if (s.name != "smooth") return {};
  return s.hull_directions == MethodSettings{}.hull_directions ? fmt::format("{}", s.set_size) : fmt::format("d{}", s.hull_directions);
}

std::string bytes_text(std::size_t bytes) { return bytes == 0 ? "-" : fmt::format("{:.3g} MB", 1e-6 * static_cast<double>(bytes)); }

}  // namespace

Result<void> measure_pareto(const ParetoSettings& settings, const Stopwatch& watch, const std::string& name,
                            const std::shared_ptr<const TriangleMesh>& mesh, const std::vector<QueryStructureKind>& structures,
                            const Progress& progress, ParetoReport& report) {
  const double extent_m = compute_bounds(*mesh).extent();
  TouchScene scene;
  scene.objects.push_back({mesh, Material{}});
  const auto trajectory = make_slide_trajectory(*mesh, {.seed = settings.seed, .rows = settings.steps, .rate_hz = 1000.0});
  if (!trajectory) return tl::unexpected(trajectory.error());
  const std::size_t pieces = (trajectory->p_SD.size() + trajectory->reset_every - 1) / trajectory->reset_every;
  const TouchTrajectory compared = take_heads(*trajectory, std::max<std::size_t>(2, settings.compared_steps / pieces));
  MethodRow pattern;
  pattern.mesh = name;
  pattern.triangles = mesh->triangles.size();
  pattern.steps = trajectory->p_SD.size();

  std::vector<std::pair<double, ReferenceRun>> references;
  for (const double radius : {0.0, kSphereShare * extent_m}) {
    progress(fmt::format("{}: reference, probe of {:g} mm, {} steps", name, 1e3 * radius, compared.p_SD.size()));
    auto run = run_reference(watch, scene, compared, radius);
    if (!run) return tl::unexpected(run.error());
    report.methods.push_back(row_of_reference(pattern, *run, radius));
    references.emplace_back(radius, std::move(*run));
  }
  TouchQueries queries;
  for (const Candidate& candidate : make_candidates(extent_m)) {
    progress(fmt::format("{}: {}, {}", name, candidate.family, candidate.structure));
    MethodRow row = pattern;
    row.family = candidate.family;
    row.structure = candidate.structure;
    row.settings = candidate.settings;
    auto timing = time_method(watch, settings.budget, candidate.settings, scene, *trajectory);
    if (!timing) return tl::unexpected(timing.error());
    if (queries.empty()) queries = make_queries(timing->felt, trajectory->reset_every, extent_m);
    const auto felt = compute_forces(candidate.settings, scene, compared);
    if (!felt) return tl::unexpected(felt.error());
    const ReferenceRun& reference = candidate.settings.probe_radius_m > 0.0 ? references[1].second : references[0].second;
    row.error = reference.compare(*felt);
    timing->felt.clear();
    timing->contact_ns.clear();
    row.timing = std::move(*timing);
    report.methods.push_back(std::move(row));
  }
  const BruteResults truth = query_by_brute_force(*mesh, queries);
  for (const QueryStructureKind& kind : structures) {
    progress(fmt::format("{}: queries, {} ({})", name, kind.full_name(), kind.precision));
    auto timing = time_structure(watch, settings.budget, kind, *mesh, queries, truth, extent_m);
    if (!timing) return tl::unexpected(timing.error());
    QueryRow row{name, mesh->triangles.size(), kind, std::move(*timing)};
    row.kind.make = nullptr;
    report.queries.push_back(std::move(row));
  }
  return {};
}

std::string to_csv(const ParetoReport& report) {
  std::string text =
      "mesh,triangles,kind,library,name,structure,precision,n,repetitions,p50_ns,p90_ns,p99_ns,p99_9_ns,worst_ns,free_p50_ns,build_ms,"
      "bytes,compared_steps,"
      "contact_steps,unsettled_steps,error_rms,error_p99,error_max,branch_switches,switched_steps,fall_throughs,false_contacts,stuck_steps,"
      "force_discontinuities,worst_discontinuity_n,not_"
      "finite,"
      "found,compared,agree\n";
  const auto out = std::back_inserter(text);
  for (const MethodRow& r : report.methods) {
    const TimeSpread& t = r.timing.contact;
    const ForceError& e = r.error;
    fmt::format_to(out,
                   "{},{},method,hapton,{},\"{}\",double,{},{},{:.1f},{:.1f},{:.1f},{:.1f},{:.1f},{:.1f},{:.3f},{},{},{},{},{:.6g},{:.6g},{"
                   ":.6g},{},{},{},{},{},{},{:.6g},{},,,\n",
                   r.mesh, r.triangles, r.family, r.structure, t.count, r.timing.repetitions, t.p50_ns, t.p90_ns, t.p99_ns, t.p99_9_ns,
                   t.worst_ns, r.timing.free.p50_ns, r.timing.build_ms, r.timing.bytes, e.steps, e.contact_steps, e.unsettled_steps,
                   e.error.rms, e.error.p99, e.error.most, e.branch_switches, e.switched_steps, e.fall_throughs, e.false_contacts,
                   e.stuck_steps, e.discontinuities, e.worst_discontinuity_n, e.not_finite);
  }
  for (const QueryRow& r : report.queries) {
    const auto line = [&](const char* query, const QueryTiming& q) {
      const TimeSpread& t = q.time;
      fmt::format_to(out, "{},{},{},{},{},,{},{},{},{:.1f},{:.1f},{:.1f},{:.1f},{:.1f},,{:.3f},{},,,,,,,,,,,,,,,{},{},{}\n", r.mesh,
                     r.triangles, query, r.kind.library, r.kind.full_name(), r.kind.precision, t.count, q.repetitions, t.p50_ns, t.p90_ns,
                     t.p99_ns, t.p99_9_ns, t.worst_ns, r.timing.build_ms, r.timing.bytes, q.found, q.compared, q.agree);
    };
    if (r.kind.segments) line("segment", r.timing.segments);
    if (r.kind.nearests) line("nearest", r.timing.nearests);
  }
  return text;
}

std::string to_json(const ParetoReport& report) {
  Json json = to_json(report.conditions, "hapton bench pareto");
  json["terms"] =
      "times: the minimum over the repetitions of each step, on one CPU, less the cost of reading the clock; worst: the maximum of these "
      "over all steps. Methods are timed as whole haptic steps in contact. force_error: difference to the force of the reference (with "
      "ever finer sub-steps, until its force no longer changes), as a share of it, over all contact steps. branch_switches: episodes in "
      "which it exceeds 1 %; they end when contact does, or the next piece of the trajectory begins. switched_steps: the steps of these "
      "episodes, which are in force_error too. unsettled_steps: contact steps in which the reference still changed with its finest "
      "sub-steps.";
  json["methods"] = Json::array();
  for (const MethodRow& row : report.methods) json["methods"].push_back(row_json(row));
  json["queries"] = Json::array();
  for (const QueryRow& row : report.queries) {
    Json one{{"mesh", row.mesh},
             {"triangles", row.triangles},
             {"library", row.kind.library},
             {"structure", row.kind.full_name()},
             {"precision", row.kind.precision},
             {"note", row.kind.note},
             {"build_ms", row.timing.build_ms},
             {"bytes", row.timing.bytes}};
    if (row.kind.segments) one["segment"] = query_json(row.timing.segments);
    if (row.kind.nearests) one["nearest"] = query_json(row.timing.nearests);
    json["queries"].push_back(std::move(one));
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_text(const ParetoReport& report, const std::string& mesh) {
  std::string text =
      fmt::format("{:<18} {:<14} {:<22} {:>9} {:>9} {:>10} {:>9} {:>9} {:>9} {:>9} {:>10} {:>6} {:>8}\n", "mesh", "method", "structure",
                  "p50 ns", "p99 ns", "worst ns", "build ms", "memory", "RMS %", "max %", "fall-thr.", "stuck", "discont.");
  const auto out = std::back_inserter(text);
  for (const MethodRow& r : report.methods) {
    if (!mesh.empty() && r.mesh != mesh) continue;
    fmt::format_to(out, "{:<18} {:<14} {:<22} {:>9.0f} {:>9.0f} {:>10.0f} {:>9.1f} {:>9} {:>9.3g} {:>9.3g} {:>10} {:>6} {:>8}\n", r.mesh,
                   r.family, r.structure, r.timing.contact.p50_ns, r.timing.contact.p99_ns, r.timing.contact.worst_ns, r.timing.build_ms,
                   bytes_text(r.timing.bytes), 100.0 * r.error.error.rms, 100.0 * r.error.error.most, r.error.fall_throughs,
                   r.error.stuck_steps, r.error.discontinuities);
  }
  fmt::format_to(out, "{:<18} {:<26} {:<7} {:>9} {:>9} {:>10} {:>9} {:>9} {:>10} {:>9} {:>9} {:>7}\n", "mesh", "structure", "", "segm. p50",
                 "p99", "worst", "near p50", "p99", "worst ns", "build ms", "memory", "agree");
  for (const QueryRow& r : report.queries) {
    if (!mesh.empty() && r.mesh != mesh) continue;
    const TimeSpread& s = r.timing.segments.time;
    const TimeSpread& n = r.timing.nearests.time;
    const std::size_t compared = r.timing.segments.compared + r.timing.nearests.compared;
    const std::size_t agree = r.timing.segments.agree + r.timing.nearests.agree;
    fmt::format_to(out, "{:<18} {:<26} {:<7} {:>9.0f} {:>9.0f} {:>10.0f} {:>9.0f} {:>9.0f} {:>10.0f} {:>9.1f} {:>9} {:>6.1f}%\n", r.mesh,
                   r.kind.full_name(), r.kind.precision, s.p50_ns, s.p99_ns, s.worst_ns, n.p50_ns, n.p99_ns, n.worst_ns, r.timing.build_ms,
                   bytes_text(r.timing.bytes),
                   100.0 * static_cast<double>(agree) / static_cast<double>(std::max<std::size_t>(1, compared)));
  }
  return text;
}

std::vector<ParetoMark> pareto_marks(const ParetoReport& report) {
  std::vector<ParetoMark> marks;
  for (const MethodRow& r : report.methods) {
    if (r.timing.contact.count == 0) continue;
    marks.push_back({r.mesh, r.family, label_of(r), r.settings.probe_radius_m == 0.0, 1e-3 * r.timing.contact.p99_ns,
                     std::max(kMinShownError, r.error.error.rms)});
  }
  return marks;
}

}  // namespace hapton
