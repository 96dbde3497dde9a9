#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/measure/mesh_run.h"
#include "bench/measure/pareto_run.h"

namespace hapton {

struct NumbersSettings {
  // Least number of triangles of each mesh on which the growth of the time is measured, from coarse to fine. Other rows use the finest.
  std::vector<std::size_t> ladder = {5000, 20000, 80000, 300000, 1000000};
  std::size_t steps = 20000;
  std::size_t compared_steps = 2000;  // steps compared with the reference at every scale
  std::vector<int> scale_exponents = {-6, -5, -4, -3, -2, -1, 0, 1, 2, 3, 4, 5, 6};
  std::uint64_t seed = 1;
  TimingBudget budget{.repetitions = 6, .seconds = 5.0};
  std::size_t rough_triangles = 1000000;  // least number of triangles of the rough sphere
  MeshRunSettings meshes;                 // how every mesh is measured
};

// A row of the report: a target, the values of other libraries or papers, and ours.
struct NumberRow {
  std::string what;                                   // for example "contact step, point probe, 1,310,720 triangles"
  std::string metric;                                 // for example "p50"
  std::string unit;                                   // for example "ns"
  std::optional<double> target;                       // none: only for comparison
  bool at_least = false;                              // true: values of at least the target meet it
  std::string quoted;                                 // value of CHAI3D 3.3 or a paper, measured earlier elsewhere; empty: none
  std::vector<std::pair<std::string, double>> peers;  // other libraries' values, measured in this run
  std::optional<double> ours;                         // none: another command measures it
  std::string note;
  std::string mesh = {};  // name of the mesh, where the value is the worst of many meshes

  bool is_measured() const { return target.has_value() && ours.has_value(); }
  bool is_met() const { return is_measured() && (at_least ? *ours >= *target : *ours <= *target); }
};

// Names of the rows whose values other programs measure.
constexpr const char* kRoundTripRow = "force round trip, three processes, loopback";
constexpr const char* kHaptonsRow = "haptons: triangle pairs a millisecond, on edge, located to 0.1 %";

struct NumbersReport {
  RunConditions conditions;
  std::vector<NumberRow> rows;
  std::vector<MeshFigures> meshes;  // source of the rows over all meshes

  std::size_t measured() const;  // number of rows with a target and a value of ours
  std::size_t met() const;
};

// Conditions under which the quoted CHAI3D values were measured.
constexpr const char* kQuotedFrom =
    "CHAI3D 3.3.0, finger proxy, g++ 12 -O3 -march=native, one core of a 2-CPU AMD EPYC (Turin) guest, Debian 12, slides of the same kind "
    "over meshes of the same size at 10 units a metre; measured once, not in this run";

// Measures all rows over bumpy spheres of 100 mm, then method `proxy` over these meshes, the smooth bumpy sphere and a rough one with
// curvature radii smaller than the depth. Error: a method or structure that cannot be made.
Result<NumbersReport> measure_numbers(const NumbersSettings& settings, const Stopwatch& watch,
                                      const std::vector<QueryStructureKind>& structures, const std::vector<NamedMesh>& meshes,
                                      const Progress& progress);

std::string to_csv(const NumbersReport& report);
std::string to_json(const NumbersReport& report);
std::string to_text(const NumbersReport& report);

}  // namespace hapton
