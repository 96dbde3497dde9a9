#include "bench/measure/mesh_rows.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

namespace hapton {
namespace {

std::string condition_of(const MeshFigures& f) {
  return fmt::format("{}, {}", f.probe_radius_m > 0.0 ? fmt::format("sphere of {:g} mm", 1e3 * f.probe_radius_m) : "point probe",
                     f.friction ? "friction" : "no friction");
}

// Makes the rows that summarise all meshes.
class RowsOverMeshes {
 public:
  RowsOverMeshes(const std::vector<MeshFigures>& all, const MeshRunSettings& settings)
      : all_(all),
        settings_(settings),
        over_(fmt::format("over {} meshes and {} seeds, {}", all.size(), settings.seeds.size(), condition_of(all[0]))),
        is_point_(all[0].probe_radius_m == 0.0 && !all[0].friction) {}

  void add_times() {
    const std::string times = "contact step " + over_;
    const std::string note = fmt::format("of {} contact steps", sum([](const MeshFigures& f) { return f.contact.count; }));
    const auto goal = [this](double ns) { return is_point_ ? std::optional<double>(ns) : std::nullopt; };
    add_pair(times, "p50", "ns", std::nullopt, "", note, [](const MeshFigures& f) { return f.contact.p50_ns; });
    add_pair(times, "p99", "ns", goal(2000.0), "", note, [](const MeshFigures& f) { return f.contact.p99_ns; });
    add_pair(times, "worst", "ns", goal(25000.0), "", note, [](const MeshFigures& f) { return f.contact.worst_ns; });
    add_pair(times, "a facet crossed", "ns", std::nullopt, "", note, [](const MeshFigures& f) { return f.ns_per_facet; });
    add_sum(times, "steps above 10 us", std::nullopt, note, [](const MeshFigures& f) { return f.over_10us; });
    add_sum(times, "steps above 50 us", std::nullopt, note, [](const MeshFigures& f) { return f.over_50us; });
    add_sum(times, "steps above 100 us", 0.0, note, [](const MeshFigures& f) { return f.over_100us; });
  }

  void add_errors() {
    const std::string errors = "force error against the limit " + over_;
    const std::string note = describe_windows();
    const auto goal = [this](double share) { return all_[0].friction ? std::nullopt : std::optional<double>(share); };
    add_pair(errors, "RMS", "%", goal(0.001), is_point_ ? "23 (70 k), 2000 (1.3 M)" : "", note,
             [](const MeshFigures& f) { return 100.0 * f.error.error.rms; });
    add_pair(errors, "p99", "%", std::nullopt, "", note, [](const MeshFigures& f) { return 100.0 * f.error.error.p99; });
    add_pair(errors, "max", "%", goal(0.1), "", note, [](const MeshFigures& f) { return 100.0 * f.error.error.most; });
    add_pair(errors, "RMS, every step converged", "%", std::nullopt, "", note,
             [](const MeshFigures& f) { return 100.0 * f.converged.error.rms; });
    add_pair(errors, "max, every step converged", "%", std::nullopt, "", note,
             [](const MeshFigures& f) { return 100.0 * f.converged.error.most; });
    const std::string faults = "fall-throughs, false contacts, stuck steps, force discontinuities";
    add_sum(errors, faults, 0.0, note, [](const MeshFigures& f) { return f.error.faults(); });
    add_sum(errors, faults + ", every step converged", std::nullopt, note, [](const MeshFigures& f) { return f.converged.faults(); });
  }

  std::vector<NumberRow> take() { return std::move(rows_); }

 private:
  template <class Count>
  std::size_t sum(Count&& count) const {
    std::size_t total = 0;
    for (const MeshFigures& f : all_) total += count(f);
    return total;
  }

  // Adds two rows: the median over the meshes, and the worst mesh. target: goal for the worst mesh. quoted: the value of another library
  // that is shown with the median.
  template <class Figure>
  void add_pair(const std::string& what, const std::string& metric, const std::string& unit, std::optional<double> target,
                const std::string& quoted, const std::string& note, Figure&& figure) {
    const MedianAndWorst both = over_meshes(all_, figure);
    rows_.push_back({what, metric + ", median mesh", unit, std::nullopt, false, quoted, {}, both.median, note});
    rows_.push_back({what, metric + ", worst mesh", unit, target, false, "", {}, both.worst, note, both.worst_mesh});
  }

  template <class Count>
  void add_sum(const std::string& what, const std::string& metric, std::optional<double> target, const std::string& note, Count&& count) {
    rows_.push_back({what, metric, "", target, false, "", {}, static_cast<double>(sum(count)), note});
  }

  std::string describe_windows() const {
    using Cause = BranchSwitch::Cause;
    const auto count_switches = [this](Cause cause) { return sum([&](const MeshFigures& f) { return f.error.count(cause); }); };
    return fmt::format(
        "{} contact steps in windows of {}, each begun from the proxy's own state; {} branch switches of {} steps in all: {} unconverged, "
        "{} where the reference has not settled, {} unexplained; {} steps not settled",
        sum([](const MeshFigures& f) { return f.error.contact_steps; }), settings_.window_steps,
        sum([](const MeshFigures& f) { return f.error.branch_switches; }), sum([](const MeshFigures& f) { return f.error.switched_steps; }),
        count_switches(Cause::unconverged), count_switches(Cause::unsettled), count_switches(Cause::unexplained),
        sum([](const MeshFigures& f) { return f.error.unsettled_steps; }));
  }

  const std::vector<MeshFigures>& all_;
  const MeshRunSettings& settings_;
  const std::string over_;
  const bool is_point_;
  std::vector<NumberRow> rows_;
};

}  // namespace

std::vector<NumberRow> rows_of_mesh(const MeshFigures& f, const MeshRunSettings& settings) {
  std::vector<NumberRow> rows;
  const auto add = [&](NumberRow row) { rows.push_back(std::move(row)); };
  const std::string what = fmt::format("contact step, {} triangles, {}", f.mesh, condition_of(f));
  const std::string note =
      fmt::format("{} contact steps of {} seeds, least of {}; {} above 10 us, {} above 50, {} above 100", f.contact.count,
                  settings.seeds.size(), settings.repetitions, f.over_10us, f.over_50us, f.over_100us);
  const bool point = f.probe_radius_m == 0.0;
  const auto goal = [&](double of_point, double of_sphere) -> std::optional<double> {
    if (f.friction) return std::nullopt;
    return point ? of_point : of_sphere;
  };
  const auto quoted = [&](const char* of_point, const char* of_sphere) { return f.friction ? "" : point ? of_point : of_sphere; };
  add({what, "p50", "ns", goal(150, 1000), false, quoted("2171", "51948 (smooth)"), {}, f.contact.p50_ns, note});
  add({what, "p99", "ns", goal(800, 8000), false, quoted("10440", "461802 (smooth)"), {}, f.contact.p99_ns, note});
  add({what, "worst", "ns", goal(3000, 30000), false, quoted("75046", "746579 (smooth)"), {}, f.contact.worst_ns, note});
  add({what, "a facet crossed", "ns", std::nullopt, false, "", {}, f.ns_per_facet, note});
  return rows;
}

std::vector<NumberRow> rows_over_meshes(const std::vector<MeshFigures>& all, const MeshRunSettings& settings) {
  RowsOverMeshes rows(all, settings);
  rows.add_times();
  rows.add_errors();
  return rows.take();
}

}  // namespace hapton
