#include "bench/measure/numbers_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "bench/measure/mesh_rows.h"
#include "core/force/smooth/smooth_scene.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;
using Peers = std::vector<std::pair<std::string, double>>;

constexpr double kExtentM = 0.1;  // every mesh is scaled to 100 mm

std::shared_ptr<const TriangleMesh> make_bumpy(std::size_t triangles, std::uint64_t seed) {
  TriangleMesh mesh = make_bumpy_sphere(0.045, 0.25, triangles, seed);
  const double extent = compute_bounds(mesh).extent();
  return std::make_shared<TriangleMesh>(scaled_and_moved(std::move(mesh), kExtentM / extent, Vec3::Zero()));
}

// Root mean square curvature 1 / (0.7 mm); the slides press 1 to 2 mm deep. At 1.31 M triangles a wave of 2.5 mm spans ten facets.
std::shared_ptr<const TriangleMesh> make_rough(std::size_t triangles, std::uint64_t seed) {
  TriangleMesh mesh = make_rough_sphere(0.049, 0.0007, 0.0025, triangles, seed);
  const double extent = compute_bounds(mesh).extent();
  return std::make_shared<TriangleMesh>(scaled_and_moved(std::move(mesh), kExtentM / extent, Vec3::Zero()));
}

TouchScene scene_of(std::shared_ptr<const TriangleMesh> mesh) {
  TouchScene scene;
  scene.objects.push_back({std::move(mesh), Material{}});
  return scene;
}

MethodSettings proxy_of(double probe_radius_m) {
  MethodSettings settings;
  settings.name = "proxy";
  settings.probe_radius_m = probe_radius_m;
  return settings;
}

std::string count_text(std::size_t n) {
  return n >= 1000000 ? fmt::format("{:.2f} M", 1e-6 * static_cast<double>(n)) : fmt::format("{:.3g} k", 1e-3 * static_cast<double>(n));
}

// Takes one measurement after the other; each adds its rows.
class Numbers {
 public:
  Numbers(const NumbersSettings& settings, const Stopwatch& watch, const std::vector<QueryStructureKind>& peers, const Progress& progress)
      : settings_(settings), watch_(watch), peers_(peers), progress_(progress) {}

  Result<void> measure_all(const std::vector<NamedMesh>& meshes) {
    progress_("making the meshes and trajectories");
    mesh_ = make_bumpy(settings_.ladder.back(), settings_.seed);
    size_ = count_text(mesh_->triangles.size()) + " triangles";
    auto slide = make_slide_trajectory(*mesh_, {.seed = settings_.seed, .rows = settings_.steps, .rate_hz = 1000.0});
    if (!slide) return tl::unexpected(slide.error());
    slide_ = std::move(*slide);
    for (const auto step : {&Numbers::measure_contact, &Numbers::measure_free, &Numbers::measure_sphere, &Numbers::measure_growth,
                            &Numbers::measure_scales}) {
      if (auto done = (this->*step)(); !done) return done;
    }
    if (auto done = measure_local_set(); !done) return done;
    if (auto done = measure_meshes(meshes); !done) return done;
    name_what_others_measure();
    return {};
  }

  std::vector<NumberRow> rows;
  std::vector<MeshFigures> figures;

 private:
  void add(NumberRow row) { rows.push_back(std::move(row)); }

  // One figure of each peer that has this kind of query.
  template <class Figure>
  Peers figures_of(const std::vector<StructureTiming>& timings, bool QueryStructureKind::*has, Figure&& figure) const {
    Peers all;
    for (std::size_t i = 0; i < timings.size(); ++i) {
      if (peers_[i].*has) all.emplace_back(peers_[i].full_name(), figure(timings[i]));
    }
    return all;
  }

  Result<std::vector<StructureTiming>> time_peers(const TriangleMesh& mesh, const TouchQueries& queries) {
    std::vector<StructureTiming> timings;
    for (const QueryStructureKind& kind : peers_) {
      progress_(fmt::format("peer: {} over {} triangles", kind.full_name(), count_text(mesh.triangles.size())));
      auto timing = time_structure(watch_, settings_.budget, kind, mesh, queries, {}, kExtentM);
      if (!timing) return tl::unexpected(timing.error());
      timings.push_back(std::move(*timing));
    }
    return timings;
  }

  std::string means_of(const std::vector<StructureTiming>& timings) const {
    std::string text;
    for (std::size_t i = 0; i < timings.size(); ++i) {
      if (peers_[i].segments)
        text += fmt::format("{}{} {:.1f}", text.empty() ? "" : ", ", peers_[i].full_name(), timings[i].segments.mean_ns);
    }
    return text;
  }

  // Each measurement builds its structures anew, so a run builds each of them several times; the shortest build counts.
  void note_build(const MethodTiming& ours, const std::vector<StructureTiming>& peers) {
    build_ms_ = std::min(build_ms_, ours.build_ms);
    for (std::size_t i = 0; i < peers.size(); ++i) contact_peers_[i].build_ms = std::min(contact_peers_[i].build_ms, peers[i].build_ms);
  }

  Result<void> measure_contact() {
    progress_("contact steps, point probe");
    const auto timing = time_method(watch_, settings_.budget, proxy_of(0.0), scene_of(mesh_), slide_);
    if (!timing) return tl::unexpected(timing.error());
    const auto peers = time_peers(*mesh_, make_queries(timing->felt, slide_.reset_every, kExtentM));
    if (!peers) return tl::unexpected(peers.error());
    contact_peers_ = *peers;
    contact_p50_ns_ = timing->contact.p50_ns;
    const std::string what = "contact step, point probe, " + size_;
    const std::string note =
        fmt::format("{} contact steps, least of {}; peers: the segment query alone", timing->contact.count, timing->repetitions);
    const auto segment = [&](double TimeSpread::*part) {
      return figures_of(*peers, &QueryStructureKind::segments, [part](const StructureTiming& t) { return t.segments.time.*part; });
    };
    add({what, "p50", "ns", 250, false, "1252", segment(&TimeSpread::p50_ns), timing->contact.p50_ns, note});
    add({what, "p99", "ns", 1000, false, "7721 .. 23896", segment(&TimeSpread::p99_ns), timing->contact.p99_ns, note});
    add({what, "worst", "ns", 5000, false, "81773", segment(&TimeSpread::worst_ns), timing->contact.worst_ns, note});
    note_build(*timing, *peers);
    build_mb_ = 1e-6 * static_cast<double>(timing->bytes);
    return {};
  }

  Result<void> measure_free() {
    progress_("free steps");
    const auto free = make_free_trajectory(*mesh_, {.seed = settings_.seed, .rows = settings_.steps, .rate_hz = 1000.0});
    if (!free) return tl::unexpected(free.error());
    const auto timing = time_method(watch_, settings_.budget, proxy_of(0.0), scene_of(mesh_), *free);
    if (!timing) return tl::unexpected(timing.error());
    const auto peers = time_peers(*mesh_, make_queries(timing->felt, free->reset_every, kExtentM));
    if (!peers) return tl::unexpected(peers.error());
    add({"free-space step, " + size_, "p50", "ns", 10, false, "110",
         figures_of(*peers, &QueryStructureKind::segments, [](const StructureTiming& t) { return t.segments.time.p50_ns; }),
         timing->free.p50_ns,
         fmt::format("{} free steps, mean {:.1f}, p99 {:.0f}, worst {:.0f} ns; peers: the segment query alone, mean {}", timing->free.count,
                     timing->mean_ns, timing->free.p99_ns, timing->free.worst_ns, means_of(*peers))});
    note_build(*timing, *peers);
    return {};
  }

  Result<void> measure_sphere() {
    progress_("contact steps, sphere probe");
    const auto timing = time_method(watch_, settings_.budget, proxy_of(kSphereRadiusM), scene_of(mesh_), slide_);
    if (!timing) return tl::unexpected(timing.error());
    const std::string what = "contact step, sphere of 0.5 mm, " + size_;
    note_build(*timing, {});
    const std::string note =
        fmt::format("{} contact steps, p99 {:.0f} ns; peers: the nearest triangle alone", timing->contact.count, timing->contact.p99_ns);
    const auto nearest = [&](double TimeSpread::*part) {
      return figures_of(contact_peers_, &QueryStructureKind::nearests, [part](const StructureTiming& t) { return t.nearests.time.*part; });
    };
    add({what, "p50", "ns", 500, false, "51948", nearest(&TimeSpread::p50_ns), timing->contact.p50_ns, note});
    add({what, "worst", "ns", 20000, false, "746579", nearest(&TimeSpread::worst_ns), timing->contact.worst_ns, note});
    return {};
  }

  // Measures growth twice: with the same slide, whose steps cross more facets on finer meshes, and with equally many facets in each step.
  Result<void> measure_growth() {
    if (auto done = measure_growth("growth of contact p50, the same slide", 1.3, false); !done) return done;
    return measure_growth("growth of contact p50, equal facets a step", 1.5, true);
  }

  // Compares the coarsest mesh with the finest, which measure_contact has already measured.
  Result<void> measure_growth(const std::string& what, double target, bool has_equal_facets) {
    double first = contact_p50_ns_;
    std::vector<StructureTiming> first_peers = contact_peers_;
    std::string note = "p50 in ns:";
    std::string span = size_;
    for (std::size_t i = 0; i + 1 < settings_.ladder.size(); ++i) {
      const auto mesh = make_bumpy(settings_.ladder[i], settings_.seed);
      const std::string size = count_text(mesh->triangles.size());
      progress_(fmt::format("{}: {} triangles", what, size));
      const double coarser = std::sqrt(static_cast<double>(mesh_->triangles.size()) / static_cast<double>(mesh->triangles.size()));
      const auto slide = make_slide_trajectory(
          *mesh, {.seed = settings_.seed, .rows = settings_.steps, .rate_hz = 1000.0 / (has_equal_facets ? coarser : 1.0)});
      if (!slide) return tl::unexpected(slide.error());
      const auto timing = time_method(watch_, settings_.budget, proxy_of(0.0), scene_of(mesh), *slide);
      if (!timing) return tl::unexpected(timing.error());
      note += fmt::format(" {:.0f} ({})", timing->contact.p50_ns, size);
      if (i > 0) continue;
      auto peers = time_peers(*mesh, make_queries(timing->felt, slide->reset_every, kExtentM));
      if (!peers) return tl::unexpected(peers.error());
      first = timing->contact.p50_ns;
      first_peers = std::move(*peers);
      span = size;
    }
    note += fmt::format(" {:.0f} ({})", contact_p50_ns_, count_text(mesh_->triangles.size()));
    Peers ratios;
    for (std::size_t i = 0; i < peers_.size(); ++i) {
      if (peers_[i].segments)
        ratios.emplace_back(peers_[i].full_name(),
                            contact_peers_[i].segments.time.p50_ns / std::max(1.0, first_peers[i].segments.time.p50_ns));
    }
    add({fmt::format("{}, {} -> {}", what, span, size_), "ratio", "x", target, false, "3.5 (3.7 k -> 1.31 M)", ratios,
         contact_p50_ns_ / std::max(1.0, first), note});
    return {};
  }

  // Computes the same slide at every scale, converts the forces back to scale 1 and compares them with those of the reference.
  Result<void> measure_scales() {
    const std::size_t pieces = (slide_.p_SD.size() + slide_.reset_every - 1) / slide_.reset_every;
    const TouchTrajectory heads = take_heads(slide_, std::max<std::size_t>(2, settings_.compared_steps / pieces));
    std::size_t fall_throughs = 0, stuck_steps = 0, bad = 0, contact = 0;
    double most_n = 0.0;
    for (const double radius : {0.0, kSphereRadiusM}) {
      progress_(fmt::format("reference over {} steps, probe of {:g} mm", heads.p_SD.size(), 1e3 * radius));
      const auto reference = run_reference(watch_, scene_of(mesh_), heads, radius);
      if (!reference) return tl::unexpected(reference.error());
      for (const int exponent : settings_.scale_exponents) {
        progress_(fmt::format("fall-throughs at scale 1e{}, probe of {:g} mm", exponent, 1e3 * radius));
        const auto felt = feel_at_scale(std::pow(10.0, exponent), radius, heads);
        if (!felt) return tl::unexpected(felt.error());
        const ForceError error = reference->compare(*felt);
        fall_throughs += error.fall_throughs;
        stuck_steps += error.stuck_steps;
        bad += error.not_finite;
        contact += error.contact_steps;
        for (const ForceSample& step : *felt) most_n = std::max(most_n, step.force_n.norm());
      }
    }
    const std::string what =
        fmt::format("over all scales 1e{} .. 1e{}, {}", settings_.scale_exponents.front(), settings_.scale_exponents.back(), size_);
    const std::string note = fmt::format("of {} contact steps, point and sphere; {} forces not finite", contact, bad);
    add({"fall-through in metres " + what,
         "steps",
         "",
         0,
         false,
         "76 .. 100 % of contact steps (1 unit a metre)",
         {},
         static_cast<double>(fall_throughs + bad),
         note});
    add({"stuck, frictionless slide " + what,
         "steps",
         "",
         0,
         false,
         "3963 of 18500, 95 N",
         {},
         static_cast<double>(stuck_steps),
         fmt::format("of {} contact steps; largest force {:.3g} N at 1000 N/m and 100 mm", contact, most_n)});
    return {};
  }

  Result<std::vector<ForceSample>> feel_at_scale(double scale, double radius, const TouchTrajectory& heads) const {
    TouchTrajectory scaled = heads;
    for (Vec3& p : scaled.p_SD) p *= scale;
    auto felt = compute_forces(proxy_of(radius * scale),
                               scene_of(std::make_shared<TriangleMesh>(scaled_and_moved(*mesh_, scale, Vec3::Zero()))), scaled);
    if (!felt) return felt;
    for (ForceSample& step : *felt) step = {step.device / scale, step.proxy / scale, step.force_n / scale};
    return felt;
  }

  // Measures every mesh with both probes, without and with friction, each time with many seeds.
  Result<void> measure_meshes(std::vector<NamedMesh> meshes) {
    meshes.push_back({"bumpy " + count_text(mesh_->triangles.size()), mesh_});
    progress_("making the rough sphere");
    const auto rough = make_rough(settings_.rough_triangles, settings_.seed);
    meshes.push_back({"rough " + count_text(rough->triangles.size()), rough});
    for (const NamedMesh& mesh : meshes) {
      auto measured = measure_mesh(settings_.meshes, watch_, mesh, progress_);
      if (!measured) return tl::unexpected(measured.error());
      figures.insert(figures.end(), std::make_move_iterator(measured->begin()), std::make_move_iterator(measured->end()));
    }
    for (const double radius : settings_.meshes.probe_radii_m) {
      for (const bool friction : {false, true}) {
        std::vector<MeshFigures> alike;
        std::copy_if(figures.begin(), figures.end(), std::back_inserter(alike),
                     [&](const MeshFigures& f) { return f.probe_radius_m == radius && f.friction == friction; });
        for (NumberRow& row : rows_of_mesh(alike.back(), settings_.meshes)) add(std::move(row));
        for (NumberRow& row : rows_over_meshes(alike, settings_.meshes)) add(std::move(row));
      }
    }
    return {};
  }

  Result<void> measure_local_set() {
    const auto build = [](const StructureTiming& t) { return t.build_ms; };
    const auto memory = [](const StructureTiming& t) { return 1e-6 * static_cast<double>(t.bytes); };
    const auto always = [&](auto&& figure) {
      Peers all;
      for (std::size_t i = 0; i < contact_peers_.size(); ++i) all.emplace_back(peers_[i].full_name(), figure(contact_peers_[i]));
      return all;
    };
    add({"build, " + size_, "time", "ms", 400, false, "547 .. 758", always(build), build_ms_,
         "least of several builds; ours: method proxy, all it needs, one thread"});
    add({"build, " + size_, "memory", "MB", 130, false, "320", always(memory), build_mb_,
         "ours: heap grown by the method; embree: its own count; others: heap grown"});
    progress_("local sets of 64 triangles");
    const auto scene = SmoothScene::build(scene_of(mesh_), {});
    if (!scene) return tl::unexpected(scene.error());
    const auto set = std::make_unique<LocalSet>();
    const TimedSteps timed = time_steps(
        watch_, settings_.budget, slide_.p_SD.size(), [](std::size_t) {},
        [&](std::size_t i) {
          scene->select({slide_.p_SD[i], slide_.p_SD[i]}, kSetSize, *set);
        },
        [](std::size_t) {});
    const TimeSpread spread = spread_of_times(timed.least.ns());
    add({"local set query, 64 of " + size_,
         "p50",
         "ns",
         5000,
         false,
         "FDH paper: 3e6 (20 k triangles)",
         {},
         spread.p50_ns,
         fmt::format("along the slide; p99 {:.0f}, worst {:.0f} ns", spread.p99_ns, spread.worst_ns)});
    return {};
  }

  void name_what_others_measure() {
    add({kRoundTripRow, "over the bare echo", "x", 1.3, false, "memo: 0.7 ms", {}, std::nullopt, "hapton latency"});
    add({kHaptonsRow, "a core", "", 100000, true, "memo: 1, capable of 5", {}, std::nullopt, "hapton bench haptons"});
  }

  const NumbersSettings& settings_;
  const Stopwatch& watch_;
  const std::vector<QueryStructureKind>& peers_;
  const Progress& progress_;
  std::shared_ptr<const TriangleMesh> mesh_;
  std::string size_;
  TouchTrajectory slide_;
  double contact_p50_ns_ = 0.0;  // on the finest mesh, as contact_peers_
  std::vector<StructureTiming> contact_peers_;
  double build_ms_ = kNothingFound;
  double build_mb_ = 0.0;
};

std::string figure(double x) { return std::fabs(x) >= 1000.0 || x == std::floor(x) ? fmt::format("{:.0f}", x) : fmt::format("{:.3g}", x); }

std::string verdict(const NumberRow& row) { return !row.ours ? "not here" : !row.target ? "-" : row.is_met() ? "met" : "NOT MET"; }

std::string metric_text(const NumberRow& row) {
  return row.metric + (row.unit.empty() ? "" : ", " + row.unit) + (row.mesh.empty() ? "" : " (" + row.mesh + ")");
}

std::string quoted_cell(std::string text) {
  std::replace(text.begin(), text.end(), '"', '\'');
  return '"' + text + '"';
}

}  // namespace

std::size_t NumbersReport::measured() const {
  return static_cast<std::size_t>(std::count_if(rows.begin(), rows.end(), [](const NumberRow& row) { return row.is_measured(); }));
}

std::size_t NumbersReport::met() const {
  return static_cast<std::size_t>(std::count_if(rows.begin(), rows.end(), [](const NumberRow& row) { return row.is_met(); }));
}

Result<NumbersReport> measure_numbers(const NumbersSettings& settings, const Stopwatch& watch,
                                      const std::vector<QueryStructureKind>& structures, const std::vector<NamedMesh>& meshes,
                                      const Progress& progress) {
  const std::uint64_t start = Stopwatch::ticks();
  NumbersReport report;
  report.conditions = begin_conditions(watch, settings.seed);
  Numbers numbers(settings, watch, structures, progress);
  if (auto done = numbers.measure_all(meshes); !done) return tl::unexpected(done.error());
  report.rows = std::move(numbers.rows);
  report.meshes = std::move(numbers.figures);
  end_conditions(report.conditions, start, watch);
  return report;
}

std::string to_csv(const NumbersReport& report) {
  std::string text = "what,metric,unit,target,chai3d_3_3_quoted,hapton,verdict,mesh,peers,note\n";
  for (const NumberRow& row : report.rows) {
    std::string peers;
    for (const auto& [name, value] : row.peers) peers += fmt::format("{}{}={:.6g}", peers.empty() ? "" : ";", name, value);
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{},{},{},{}\n", quoted_cell(row.what), quoted_cell(row.metric), row.unit,
                   row.target ? fmt::format("{:g}", *row.target) : "", quoted_cell(row.quoted),
                   row.ours ? fmt::format("{:.6g}", *row.ours) : "", verdict(row), quoted_cell(row.mesh), quoted_cell(peers),
                   quoted_cell(row.note));
  }
  return text;
}

std::string to_json(const NumbersReport& report) {
  Json json = to_json(report.conditions, "hapton bench numbers");
  json["quoted_from"] = kQuotedFrom;
  json["targets_measured"] = report.measured();
  json["targets_met"] = report.met();
  json["rows"] = Json::array();
  for (const NumberRow& row : report.rows) {
    Json one{{"what", row.what},         {"metric", row.metric},
             {"unit", row.unit},         {"target", row.target ? Json(*row.target) : Json(nullptr)},
             {"at_least", row.at_least}, {"chai3d_3_3_quoted", row.quoted}};
    one["peers"] = Json::object();
    for (const auto& [name, value] : row.peers) one["peers"][name] = value;
    one["hapton"] = row.ours ? Json(*row.ours) : Json(nullptr);
    one["verdict"] = verdict(row);
    one["mesh"] = row.mesh;
    one["note"] = row.note;
    json["rows"].push_back(std::move(one));
  }
  json["meshes"] = to_json(report.meshes);
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_text(const NumbersReport& report) {
  std::string text;
  const auto out = std::back_inserter(text);
  std::string last;
  for (const NumberRow& row : report.rows) {
    if (row.what != last) {
      fmt::format_to(out, "\n{}\n  {:<46} {:>12} {:>12} {:>9}   {:<30} {}\n", row.what, "", "target", "Hapton", "", "CHAI3D 3.3 (quoted)",
                     "peers, this run");
      last = row.what;
    }
    std::string peers;
    for (const auto& [name, value] : row.peers) peers += fmt::format("{}{} {}", peers.empty() ? "" : ", ", name, figure(value));
    fmt::format_to(out, "  {:<46} {:>12} {:>12} {:>9}   {:<30} {}\n", metric_text(row),
                   row.target ? (row.at_least ? ">= " : "<= ") + figure(*row.target) : "-", row.ours ? figure(*row.ours) : "-",
                   verdict(row), row.quoted, peers);
    const bool is_last_of_note = &row == &report.rows.back() || (&row)[1].note != row.note;
    if (is_last_of_note && !row.note.empty()) fmt::format_to(out, "    {}\n", row.note);
  }
  if (!report.meshes.empty()) fmt::format_to(out, "\n{}", to_text(report.meshes));
  fmt::format_to(out, "\n{} of {} targets measured here are met.\n", report.met(), report.measured());
  fmt::format_to(out, "{}.\nQuoted: {}.\n", report.conditions.to_text(), kQuotedFrom);
  return text;
}

}  // namespace hapton
