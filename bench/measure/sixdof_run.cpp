#include "bench/measure/sixdof_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/tool/penetration_check.h"

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;

// The root mean square error of a vector quantity and of its direction.
class VectorError {
 public:
  void add(const Vec3& found, const Vec3& expected) {
    difference_squares_ += (found - expected).squaredNorm();
    expected_squares_ += expected.squaredNorm();
    if (!(found.norm() > 0.0) || !(expected.norm() > 0.0)) return;
    const double angle = std::atan2(found.cross(expected).norm(), found.dot(expected));
    angle_squares_ += angle * angle;
    ++angle_count_;
  }
  // In percent of the expected values, or of `scale` if that is larger.
  double percent(double scale) const { return 100.0 * std::sqrt(difference_squares_) / std::max(std::sqrt(expected_squares_), scale); }
  double angle_deg() const {
    return angle_count_ == 0 ? 0.0 : std::sqrt(angle_squares_ / static_cast<double>(angle_count_)) * 180.0 / std::numbers::pi;
  }
  double expected_norm() const { return std::sqrt(expected_squares_); }
  bool any() const { return expected_squares_ > 0.0; }

 private:
  double difference_squares_ = 0.0;
  double expected_squares_ = 0.0;
  double angle_squares_ = 0.0;
  std::size_t angle_count_ = 0;
};

void note_errors(SixdofRow& row, const SixdofScenario& scenario, const std::vector<ToolOutput>& felt) {
  row.has_errors = static_cast<bool>(scenario.expected);
  if (!row.has_errors) return;
  VectorError force;
  VectorError torque;
  for (std::size_t i = 0; i < felt.size(); ++i) {
    const Wrench6 expected = scenario.expected(scenario.device[i]);
    force.add(felt[i].force_n, expected.force_n);
    torque.add(felt[i].torque_nm, expected.torque_nm);
  }
  const double lever = std::sqrt(scenario.coupling.rotational_stiffness_nm_per_rad / scenario.coupling.stiffness_n_per_m);
  row.force_error_percent = force.percent(0.0);
  row.force_angle_deg = force.angle_deg();
  row.torque_error_percent = torque.percent(torque.any() ? 0.0 : force.expected_norm() * lever);
  row.torque_angle_deg = torque.any() ? torque.angle_deg() : 0.0;
}

void note_gaps(SixdofRow& row, const ToolStep& exact, const std::vector<Placement>& placements,
               const std::vector<std::uint8_t>& in_contact) {
  // A search up to 1 mm finds many pairs, and on the finest scene millions.
  constexpr std::size_t kWideEvery = 16;
  constexpr std::size_t kMaxForWide = 200'000;  // triangles of the scene
  constexpr double kWideM = 1e-3;
  PenetrationCheck check(exact.tool(), exact.scene());
  row.least_gap = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < placements.size(); ++i) {
    const bool penetrates = check.penetrates(placements[i]);
    row.penetrations += penetrates ? 1 : 0;
    const double gap = penetrates ? 0.0 : check.find_gap(placements[i], 2.0 * ToolProxy::kContactOffset);
    row.least_gap = std::min(row.least_gap, gap / ToolProxy::kContactOffset);
    if (penetrates || in_contact[i] == 0 || i % kWideEvery != 0 || exact.scene().triangle_count() > kMaxForWide) continue;
    const double gap_m = check.find_gap(placements[i], kWideM / exact.scene().unit_m()) * exact.scene().unit_m();
    if (std::isfinite(gap_m)) row.widest_gap_um = std::max(row.widest_gap_um, 1e6 * gap_m);
  }
}

}  // namespace

Result<SixdofRow> measure_scenario(const SixdofScenario& scenario, const SixdofMethodKind& kind, const Stopwatch& watch,
                                   const TimingBudget& budget) {
  // This tool measures penetrations and gaps on the meshes themselves, whatever the method.
  auto exact = ToolStep::make(*scenario.tool, {scenario.scene}, scenario.coupling);
  if (!exact) return tl::unexpected(exact.error());
  auto made = kind.make(scenario);
  if (!made) return tl::unexpected(made.error());
  SixdofMethod& method = **made;
  SixdofRow row;
  row.name = scenario.name;
  row.method = kind.name;
  const std::size_t steps = scenario.device.size();
  ToolOutput output;
  std::vector<ToolOutput> felt(steps);
  std::vector<Placement> placements(steps);
  const TimedSteps timed = time_steps(
      watch, budget, steps,
      [&](std::size_t i) {
        if (i == 0) method.reset(scenario.device[0]);
        if (i > 0) method.follow();
      },
      [&](std::size_t i) { output = method.step(scenario.device[i]); },
      [&](std::size_t i) {
        felt[i] = output;
        placements[i] = method.placement(**exact);
      });

  std::vector<std::uint8_t> in_contact(steps, 0);
  double rounds = 0.0;
  for (std::size_t i = 0; i < steps; ++i) {
    row.unconverged += felt[i].proxy.converged ? 0 : 1;
    row.most_rounds = std::max(row.most_rounds, felt[i].proxy.rounds);
    row.most_haptons = std::max(row.most_haptons, felt[i].proxy.haptons);
    if (!felt[i].contact) continue;
    in_contact[i] = 1;
    ++row.contact_steps;
    rounds += felt[i].proxy.rounds;
  }
  row.mean_rounds = row.contact_steps > 0 ? rounds / static_cast<double>(row.contact_steps) : 0.0;
  note_errors(row, scenario, felt);
  note_gaps(row, **exact, placements, in_contact);
  row.contact = spread_of_times(timed.least.only(in_contact));
  return row;
}

Result<SixdofReport> measure_sixdof(const SixdofSettings& settings, const Stopwatch& watch, const Progress& progress) {
  const std::uint64_t start = Stopwatch::ticks();
  SixdofReport report;
  report.conditions = begin_conditions(watch, settings.seed);
  std::vector<SixdofScenario> scenarios = make_analytic_scenarios(settings.steps);
  scenarios.push_back(make_size_scenario(1'000, 1'000, settings.steps, settings.seed));
  scenarios.push_back(make_size_scenario(5'000, 50'000, settings.steps, settings.seed));
  if (settings.with_large) scenarios.push_back(make_size_scenario(50'000, 1'000'000, settings.steps, settings.seed));
  const auto measure = [&](const SixdofScenario& scenario, const SixdofMethodKind& kind) -> Result<void> {
    progress(fmt::format("{}: {}", scenario.name, kind.name));
    auto row = measure_scenario(scenario, kind, watch, settings.budget);
    if (!row) return fail("{}: {}: {}", scenario.name, kind.name, row.error().what);
    report.rows.push_back(std::move(*row));
    return {};
  };
  for (const SixdofScenario& scenario : scenarios) {
    for (const SixdofMethodKind& own : {proxy_tool(), force_task(1), force_task(5)}) {
      if (auto done = measure(scenario, own); !done) return tl::unexpected(done.error());
    }
    for (const SixdofMethodKind& kind : settings.compared) {
      if (scenario.scene->triangles.size() > kind.most_triangles) continue;
      if (auto done = measure(scenario, kind); !done) return tl::unexpected(done.error());
    }
  }
  if (auto done = measure(make_peg_scenario(settings.peg_steps, settings.seed), proxy_tool()); !done) return tl::unexpected(done.error());
  for (const SixdofMethodKind& own : {proxy_tool(), force_task(1), force_task(5)})
    report.methods.push_back(fmt::format("{}: {}", own.name, own.what));
  for (const SixdofMethodKind& kind : settings.compared) report.methods.push_back(fmt::format("{}: {}", kind.name, kind.what));
  end_conditions(report.conditions, start, watch);
  return report;
}

std::string to_csv(const SixdofReport& report) {
  std::string text =
      "scenario,method,contact_steps,force_error_percent,force_angle_deg,torque_error_percent,torque_angle_deg,penetrations,least_gap_"
      "offsets,widest_gap_um,"
      "unconverged,mean_rounds,most_rounds,most_haptons,p50_ns,p99_ns,worst_ns\n";
  for (const SixdofRow& row : report.rows) {
    const auto error = [&](double value) { return row.has_errors ? fmt::format("{:.6g}", value) : std::string(); };
    fmt::format_to(std::back_inserter(text), "\"{}\",\"{}\",{},{},{},{},{},{},{:.6g},{:.6g},{},{:.4g},{},{},{:.6g},{:.6g},{:.6g}\n",
                   row.name, row.method, row.contact_steps, error(row.force_error_percent), error(row.force_angle_deg),
                   error(row.torque_error_percent), error(row.torque_angle_deg), row.penetrations, row.least_gap, row.widest_gap_um,
                   row.unconverged, row.mean_rounds, row.most_rounds, row.most_haptons, row.contact.p50_ns, row.contact.p99_ns,
                   row.contact.worst_ns);
  }
  return text;
}

std::string to_json(const SixdofReport& report) {
  Json json = to_json(report.conditions, "hapton bench sixdof");
  json["rows"] = Json::array();
  for (const SixdofRow& row : report.rows) {
    Json one{{"scenario", row.name},
             {"method", row.method},
             {"contact_steps", row.contact_steps},
             {"penetrations", row.penetrations},
             {"least_gap_offsets", row.least_gap},
             {"widest_gap_um", row.widest_gap_um},
             {"unconverged", row.unconverged},
             {"mean_rounds", row.mean_rounds},
             {"most_rounds", row.most_rounds},
             {"most_haptons", row.most_haptons},
             {"p50_ns", row.contact.p50_ns},
             {"p99_ns", row.contact.p99_ns},
             {"worst_ns", row.contact.worst_ns}};
    if (row.has_errors) {
      one["force_error_percent"] = row.force_error_percent;
      one["force_angle_deg"] = row.force_angle_deg;
      one["torque_error_percent"] = row.torque_error_percent;
      one["torque_angle_deg"] = row.torque_angle_deg;
    }
    json["rows"].push_back(std::move(one));
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_text(const SixdofReport& report) {
  const auto heading = [](const auto&... word) {
    return fmt::format("{:<26} {:<15} {:>7} {:>8} {:>7} {:>8} {:>7} {:>7} {:>6} {:>8} {:>7} {:>6} {:>9} {:>9} {:>9}\n", word...);
  };
  std::string text = heading("", "", "contact", "force", "angle", "torque", "angle", "pene-", "least", "widest", "uncon-", "rounds", "p50",
                             "p99", "worst");
  text += heading("scenario", "method", "steps", "% RMS", "deg", "% RMS", "deg", "trates", "gap", "gap, um", "verged", "mean", "us", "us",
                  "us");
  for (const SixdofRow& row : report.rows) {
    const auto error = [&](double value) { return row.has_errors ? fmt::format("{:.3f}", value) : std::string("-"); };
    fmt::format_to(std::back_inserter(text),
                   "{:<26} {:<15} {:>7} {:>8} {:>7} {:>8} {:>7} {:>7} {:>6.3f} {:>8.1f} {:>7} {:>6.2f} {:>9.1f} {:>9.1f} {:>9.1f}\n",
                   row.name, row.method, row.contact_steps, error(row.force_error_percent), error(row.force_angle_deg),
                   error(row.torque_error_percent), error(row.torque_angle_deg), row.penetrations, row.least_gap, row.widest_gap_um,
                   row.unconverged, row.mean_rounds, 1e-3 * row.contact.p50_ns, 1e-3 * row.contact.p99_ns, 1e-3 * row.contact.worst_ns);
  }
  text +=
      "force, torque: of the expected one; a torque where none is expected: of the force times the coupling's lever. penetrates: steps in "
      "which a triangle of the tool intersects the scene, by exact signs. least gap: of the contact offset. widest gap: in contact, in "
      "every 16th step; 0: none up to 1 mm, or a scene of more than 200,000 triangles, where it is not measured.\n";
  for (const std::string& method : report.methods) text += method + ".\n";
  return text + report.conditions.to_text() + ".\n";
}

}  // namespace hapton
