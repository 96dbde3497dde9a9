#include "bench/measure/mesh_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <span>
#include <utility>

#include "bench/measure/converged_steps.h"
#include "bench/measure/facet_locator.h"
#include "core/force/reference/reference_method.h"
#include "core/geometry/mesh_measures.h"

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;
using SwitchCause = BranchSwitch::Cause;

constexpr double kSlideShare =
    1e-9;  // share of the extent: a proxy that has moved farther since the last step slides; above rounding, a free choice

struct Slide {
  std::uint64_t seed;
  TouchTrajectory trajectory;
};

struct Windows {
  std::vector<ForceSample> method, converged, reference;  // one window after the other, all of the same length
  struct Begin {
    std::uint64_t seed = 0;  // seed of the slide
    std::size_t step = 0;    // step of the slide after which the window begins
    Vec3 proxy = Vec3::Zero(), device = Vec3::Zero();
    bool is_sliding = false;
  };
  std::vector<Begin> begins;
};

// Chooses where windows begin: at contact steps with a whole window before the next reset; with friction only at those in which the proxy
// moves, so that the windows include such motion.
std::vector<std::size_t> choose_starts(const Slide& slide, const std::vector<ForceSample>& felt, const MeshRunSettings& settings,
                                       double least_move_m) {
  std::vector<std::size_t> possible;
  const std::size_t piece = slide.trajectory.reset_every;
  for (std::size_t i = 1; i + settings.window_steps < felt.size(); ++i) {
    const bool has_moved = (felt[i].proxy - felt[i - 1].proxy).norm() > least_move_m;
    if (i % piece != 0 && i % piece + settings.window_steps < piece && !felt[i].force_n.isZero(0.0) && has_moved) possible.push_back(i);
  }
  std::mt19937_64 random(slide.seed);
  std::vector<std::size_t> starts;
  for (std::size_t i = 0; i < settings.windows && !possible.empty(); ++i) starts.push_back(possible[random() % possible.size()]);
  return starts;
}

// Computes the reference over one window.
std::vector<ForceSample> compute_reference(ReferenceMethod& reference, const Windows::Begin& begin, std::span<const ForceSample> samples) {
  reference.continue_from(begin.proxy, begin.device, begin.is_sliding);
  std::vector<ForceSample> felt;
  for (const ForceSample& sample : samples) {
    const MethodOutput expected = reference.step({.p_SD = sample.device});
    felt.push_back({sample.device, expected.p_SP, expected.force_n, reference.last_step().settled});
  }
  return felt;
}

void compute_windows(ReferenceMethod& reference, ConvergedSteps& converged, const Slide& slide, const std::vector<ForceSample>& felt,
                     const MeshRunSettings& settings, double least_move_m, Windows& windows) {
  for (const std::size_t start : choose_starts(slide, felt, settings, least_move_m)) {
    const ConvergedSteps::Window finished = converged.compute(slide.trajectory, start, settings.window_steps);
    windows.begins.push_back({slide.seed, start, felt[start].proxy, finished.begins_at, finished.begins_sliding});
    windows.converged.insert(windows.converged.end(), finished.felt.begin(), finished.felt.end());
    const auto first = felt.begin() + static_cast<std::ptrdiff_t>(start) + 1;
    windows.method.insert(windows.method.end(), first, first + static_cast<std::ptrdiff_t>(settings.window_steps));
    const std::vector<ForceSample> expected =
        compute_reference(reference, windows.begins.back(), std::span(windows.method).last(settings.window_steps));
    windows.reference.insert(windows.reference.end(), expected.begin(), expected.end());
  }
}

MethodSettings settings_of(const char* name, double probe_radius_m) {
  MethodSettings settings;
  settings.name = name;
  settings.probe_radius_m = probe_radius_m;
  return settings;
}

// Computes the reference again with 16 times as many sub-steps, in each window with an unexplained switch. Where its force now differs by
// more than kBranchShare, coarser sub-steps agreed by chance, so the step is not settled; a switch is unsettled if its first step is not
// settled. This changes neither which steps count as errors nor the size of an error.
void check_reference(ReferenceMethod& fine, const std::vector<BranchSwitch>& switches, std::size_t window_steps, Windows& windows) {
  std::size_t checked = windows.begins.size();
  for (const BranchSwitch& branch : switches) {
    const std::size_t window = branch.first_step / window_steps;
    if (branch.cause != SwitchCause::unexplained || window == checked) continue;
    checked = window;
    const std::span steps = std::span(windows.reference).subspan(window * window_steps, window_steps);
    const std::vector<ForceSample> finer = compute_reference(fine, windows.begins[window], steps);
    for (std::size_t i = 0; i < window_steps; ++i) {
      const double change = (finer[i].force_n - steps[i].force_n).norm();
      if (change > ForceError::kBranchShare * steps[i].force_n.norm()) steps[i].settled = false;
    }
  }
}

Result<void> compare_windows(const MethodSettings& fine, const TouchScene& scene, const ForceErrorSettings& settings, Windows& windows,
                             MeshFigures& figures) {
  figures.error = compare_forces(windows.method, windows.reference, settings, windows.converged);
  if (figures.error.count(SwitchCause::unexplained) > 0) {
    auto reference = ReferenceMethod::make_reference(fine, scene);
    if (!reference) return tl::unexpected(reference.error());
    check_reference(**reference, figures.error.switches, settings.reset_every, windows);
    figures.error = compare_forces(windows.method, windows.reference, settings, windows.converged);
  }
  figures.converged = compare_forces(windows.converged, windows.reference, settings, windows.converged);
  for (const BranchSwitch& branch : figures.error.switches) {
    const Windows::Begin& begin = windows.begins[branch.first_step / settings.reset_every];
    const std::size_t step = begin.step + 1 + branch.first_step % settings.reset_every;
    // Windows are drawn independently, so two of them may overlap.
    const auto is_same = [&](const MeshFigures::Switch& known) { return known.seed == begin.seed && known.step == step; };
    if (std::ranges::none_of(figures.switches, is_same)) figures.switches.push_back({begin.seed, step, branch});
  }
  return {};
}

std::uint64_t count_facets(const FacetLocator& locator, const Slide& slide, const std::vector<ForceSample>& felt) {
  std::uint64_t crossed = 0;
  for (std::size_t i = 1; i < felt.size(); ++i) {
    if (i % slide.trajectory.reset_every == 0 || felt[i].force_n.isZero(0.0) || felt[i - 1].force_n.isZero(0.0)) continue;
    crossed += locator.count_crossed(felt[i - 1].proxy, felt[i].proxy);
  }
  return crossed;
}

std::size_t count_above(const std::vector<double>& ns, double limit_ns) {
  return static_cast<std::size_t>(std::count_if(ns.begin(), ns.end(), [&](double t) { return t > limit_ns; }));
}

Result<MeshFigures> measure_one(const MeshRunSettings& settings, const Stopwatch& watch, const NamedMesh& mesh,
                                const std::vector<Slide>& slides, const FacetLocator& locator, double probe_radius_m, bool friction) {
  MeshFigures figures;
  figures.mesh = mesh.name;
  figures.triangles = mesh.mesh->triangles.size();
  figures.probe_radius_m = probe_radius_m;
  figures.friction = friction;
  TouchScene scene;
  Material material;
  if (friction) {
    material.friction_static = settings.friction_static;
    material.friction_dynamic = settings.friction_dynamic;
  }
  scene.objects.push_back({mesh.mesh, material});
  auto reference = ReferenceMethod::make_reference(settings_of("reference", probe_radius_m), scene);
  if (!reference) return tl::unexpected(reference.error());
  auto converged = ConvergedSteps::make(settings_of("proxy", probe_radius_m), scene);
  if (!converged) return tl::unexpected(converged.error());
  const TimingBudget budget{.repetitions = settings.repetitions, .seconds = std::numeric_limits<double>::infinity()};
  ForceErrorSettings error;
  error.stiffness_n_per_m = material.stiffness_n_per_m;
  error.extent_m = compute_bounds(*mesh.mesh).extent();
  error.reset_every = settings.window_steps;
  std::vector<double> contact_ns, free_p50_ns;
  Windows windows;
  for (const Slide& slide : slides) {
    auto timing = time_method(watch, budget, settings_of("proxy", probe_radius_m), scene, slide.trajectory);
    if (!timing) return tl::unexpected(timing.error());
    contact_ns.insert(contact_ns.end(), timing->contact_ns.begin(), timing->contact_ns.end());
    if (timing->free.count > 0) free_p50_ns.push_back(timing->free.p50_ns);
    figures.facets_crossed += count_facets(locator, slide, timing->felt);
    compute_windows(**reference, *converged, slide, timing->felt, settings, friction ? kSlideShare * error.extent_m : -1.0, windows);
  }
  double sum_ns = 0.0;
  for (const double ns : contact_ns) sum_ns += ns;
  figures.ns_per_facet = sum_ns / static_cast<double>(std::max<std::uint64_t>(1, figures.facets_crossed));
  figures.over_10us = count_above(contact_ns, 10e3);
  figures.over_50us = count_above(contact_ns, 50e3);
  figures.over_100us = count_above(contact_ns, 100e3);
  figures.contact = spread_of_times(std::move(contact_ns));
  figures.free_p50_ns = spread_of_times(std::move(free_p50_ns)).p50_ns;
  MethodSettings fine = settings_of("reference", probe_radius_m);
  fine.reference_substeps *= 16;
  fine.reference_substep_limit = 4 * fine.reference_substeps;
  if (auto compared = compare_windows(fine, scene, error, windows, figures); !compared) return tl::unexpected(compared.error());
  return figures;
}

const char* cause_text(SwitchCause cause) {
  switch (cause) {
    case SwitchCause::unconverged:
      return "unconverged";
    case SwitchCause::unsettled:
      return "unsettled";
    case SwitchCause::unexplained:
      break;
  }
  return "unexplained";
}

std::string probe_text(double radius_m) { return radius_m > 0.0 ? fmt::format("sphere {:g} mm", 1e3 * radius_m) : "point"; }

}  // namespace

Result<std::vector<MeshFigures>> measure_mesh(const MeshRunSettings& settings, const Stopwatch& watch, const NamedMesh& mesh,
                                              const std::function<void(const std::string&)>& progress) {
  progress(fmt::format("{}: slides of {} seeds", mesh.name, settings.seeds.size()));
  std::vector<Slide> slides;
  for (const std::uint64_t seed : settings.seeds) {
    auto made = make_slide_trajectory(*mesh.mesh, {.seed = seed, .rows = settings.steps, .rate_hz = 1000.0});
    if (!made) return tl::unexpected(made.error());
    slides.push_back({seed, std::move(*made)});
  }
  const FacetLocator locator(*mesh.mesh);
  std::vector<MeshFigures> all;
  for (const double radius : settings.probe_radii_m) {
    for (const bool friction : {false, true}) {
      progress(fmt::format("{}: {}{}", mesh.name, probe_text(radius), friction ? ", friction" : ""));
      auto figures = measure_one(settings, watch, mesh, slides, locator, radius, friction);
      if (!figures) return tl::unexpected(figures.error());
      all.push_back(std::move(*figures));
    }
  }
  return all;
}

MedianAndWorst over_meshes(const std::vector<MeshFigures>& figures, const std::function<double(const MeshFigures&)>& figure) {
  MedianAndWorst result;
  std::vector<double> values;
  for (const MeshFigures& one : figures) {
    values.push_back(figure(one));
    if (values.size() > 1 && values.back() <= result.worst) continue;
    result.worst = values.back();
    result.worst_mesh = one.mesh;
  }
  // For an even number of values this is the upper of the two in the middle, so that the median is a measured value.
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  result.median = values[values.size() / 2];
  return result;
}

std::string to_csv(const std::vector<MeshFigures>& figures) {
  std::string text =
      "mesh,triangles,probe_radius_m,friction,contact_steps,p50_ns,p90_ns,p99_ns,p99_9_ns,worst_ns,free_p50_ns,over_10us,over_50us,over_"
      "100us,"
      "facets_crossed,ns_per_facet,compared_steps,compared_contact_steps,unsettled_steps,error_rms,error_p50,error_p99,error_max,branch_"
      "switches,"
      "unconverged_switches,unsettled_switches,unexplained_switches,converged_rms,converged_max,converged_switches,converged_faults,"
      "switched_steps,fall_throughs,false_contacts,stuck_steps,force_discontinuities,not_finite\n";
  for (const MeshFigures& f : figures) {
    const TimeSpread& t = f.contact;
    const ForceError& e = f.error;
    fmt::format_to(
        std::back_inserter(text),
        "{},{},{:g},{},{},{:.1f},{:.1f},{:.1f},{:.1f},{:.1f},{:.1f},{},{},{},{},{:.1f},{},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{},{},{}"
        ",{},{:.6g},{:.6g},{},{},{},{},{},{},{},{}\n",
        f.mesh, f.triangles, f.probe_radius_m, f.friction ? 1 : 0, t.count, t.p50_ns, t.p90_ns, t.p99_ns, t.p99_9_ns, t.worst_ns,
        f.free_p50_ns, f.over_10us, f.over_50us, f.over_100us, f.facets_crossed, f.ns_per_facet, e.steps, e.contact_steps,
        e.unsettled_steps, e.error.rms, e.error.p50, e.error.p99, e.error.most, e.branch_switches, e.count(SwitchCause::unconverged),
        e.count(SwitchCause::unsettled), e.count(SwitchCause::unexplained), f.converged.error.rms, f.converged.error.most,
        f.converged.branch_switches, f.converged.faults(), e.switched_steps, e.fall_throughs, e.false_contacts, e.stuck_steps,
        e.discontinuities, e.not_finite);
  }
  return text;
}

std::string switches_to_csv(const std::vector<MeshFigures>& figures) {
  std::string text = "mesh,probe_radius_m,friction,seed,step,steps,error_max,cause\n";
  for (const MeshFigures& f : figures) {
    for (const MeshFigures::Switch& s : f.switches) {
      fmt::format_to(std::back_inserter(text), "{},{:g},{},{},{},{},{:.6g},{}\n", f.mesh, f.probe_radius_m, f.friction ? 1 : 0, s.seed,
                     s.step, s.branch.steps, s.branch.most, cause_text(s.branch.cause));
    }
  }
  return text;
}

Json to_json(const std::vector<MeshFigures>& figures) {
  Json all = Json::array();
  for (const MeshFigures& f : figures) {
    const TimeSpread& t = f.contact;
    const ForceError& e = f.error;
    Json switches = Json::array();
    for (const MeshFigures::Switch& s : f.switches)
      switches.push_back({{"seed", s.seed},
                          {"step", s.step},
                          {"steps", s.branch.steps},
                          {"error_max", s.branch.most},
                          {"cause", cause_text(s.branch.cause)}});
    all.push_back({{"mesh", f.mesh},
                   {"triangles", f.triangles},
                   {"probe_radius_m", f.probe_radius_m},
                   {"friction", f.friction},
                   {"contact",
                    {{"n", t.count},
                     {"p50_ns", t.p50_ns},
                     {"p90_ns", t.p90_ns},
                     {"p99_ns", t.p99_ns},
                     {"p99_9_ns", t.p99_9_ns},
                     {"worst_ns", t.worst_ns}}},
                   {"free_p50_ns", f.free_p50_ns},
                   {"over_10us", f.over_10us},
                   {"over_50us", f.over_50us},
                   {"over_100us", f.over_100us},
                   {"facets_crossed", f.facets_crossed},
                   {"ns_per_facet", f.ns_per_facet},
                   {"compared_steps", e.steps},
                   {"compared_contact_steps", e.contact_steps},
                   {"unsettled_steps", e.unsettled_steps},
                   {"force_error", {{"rms", e.error.rms}, {"p50", e.error.p50}, {"p99", e.error.p99}, {"max", e.error.most}}},
                   {"branch_switches", e.branch_switches},
                   {"unconverged_switches", e.count(SwitchCause::unconverged)},
                   {"unsettled_switches", e.count(SwitchCause::unsettled)},
                   {"unexplained_switches", e.count(SwitchCause::unexplained)},
                   {"switches", std::move(switches)},
                   {"converged",
                    {{"rms", f.converged.error.rms},
                     {"max", f.converged.error.most},
                     {"branch_switches", f.converged.branch_switches},
                     {"faults", f.converged.faults()}}},
                   {"switched_steps", e.switched_steps},
                   {"fall_throughs", e.fall_throughs},
                   {"false_contacts", e.false_contacts},
                   {"stuck_steps", e.stuck_steps},
                   {"force_discontinuities", e.discontinuities},
                   {"not_finite", e.not_finite}});
  }
  return all;
}

std::string to_text(const std::vector<MeshFigures>& figures) {
  std::string text = fmt::format(
      "{:<24} {:<14} {:<4} {:>8} {:>7} {:>8} {:>9} {:>6} {:>6} {:>6} {:>8} {:>9} {:>9} {:>9} {:>8} {:>8} {:>8} {:>8} {:>9} {:>9}\n", "mesh",
      "probe", "mu", "contact", "p50 ns", "p99 ns", "worst ns", ">10us", ">50us", ">100us", "ns/facet", "RMS %", "p99 %", "max %",
      "switches", "unconv", "unsettl", "unexpl", "RMS cv %", "max cv %");
  for (const MeshFigures& f : figures) {
    const ForceError& e = f.error;
    fmt::format_to(std::back_inserter(text),
                   "{:<24} {:<14} {:<4} {:>8} {:>7.0f} {:>8.0f} {:>9.0f} {:>6} {:>6} {:>6} {:>8.0f} {:>9.3g} {:>9.3g} {:>9.3g} {:>8} {:>8} "
                   "{:>8} {:>8} {:>9.3g} {:>9.3g}\n",
                   f.mesh, probe_text(f.probe_radius_m), f.friction ? "on" : "off", f.contact.count, f.contact.p50_ns, f.contact.p99_ns,
                   f.contact.worst_ns, f.over_10us, f.over_50us, f.over_100us, f.ns_per_facet, 100.0 * e.error.rms, 100.0 * e.error.p99,
                   100.0 * e.error.most, e.branch_switches, e.count(SwitchCause::unconverged), e.count(SwitchCause::unsettled),
                   e.count(SwitchCause::unexplained), 100.0 * f.converged.error.rms, 100.0 * f.converged.error.most);
  }
  return text;
}

}  // namespace hapton
