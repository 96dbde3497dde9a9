#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/measure/method_run.h"

namespace hapton {

// A mesh that `numbers` measures; its longest side is 100 mm.
struct NamedMesh {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;
};

struct MeshRunSettings {
  std::vector<std::uint64_t> seeds = {1, 2, 3, 4, 5, 6};  // one slide for each seed
  std::size_t steps = 20000;                              // steps of each slide
  std::vector<double> probe_radii_m = {0.0, 0.0005};      // 0: a point
  // Coefficients of static and dynamic friction: those with which the quoted CHAI3D values were measured.
  double friction_static = 0.5;
  double friction_dynamic = 0.4;
  int repetitions = 3;            // runs of each slide; the least time of each step counts
  std::size_t windows = 4;        // windows of each slide that are compared with the reference
  std::size_t window_steps = 40;  // steps of a window
};

// Results of method proxy over one mesh with one probe, without or with friction, for all seeds together.
struct MeshFigures {
  std::string mesh;
  std::size_t triangles = 0;
  double probe_radius_m = 0.0;
  bool friction = false;
  TimeSpread contact;                                        // least times of the contact steps
  std::size_t over_10us = 0, over_50us = 0, over_100us = 0;  // contact steps that take longer
  std::uint64_t facets_crossed = 0;                          // facets that the proxy crosses between two contact steps, by FacetLocator
  double ns_per_facet = 0.0;                                 // time of all contact steps divided by facets_crossed
  double free_p50_ns = 0.0;
  ForceError error;      // force error in the windows
  ForceError converged;  // the same when every step of a window converges before the next sample, without work limit
  struct Switch {        // a branch switch of `error`
    std::uint64_t seed = 0;
    std::size_t step = 0;  // step of the slide at which it begins
    BranchSwitch branch;
  };
  std::vector<Switch> switches;
};

// Measures method `proxy` over a mesh: slides of every seed, each probe, without and with friction.
//
// The errors are those in windows of consecutive steps. The seed chooses where a window begins among the contact steps (with friction:
// those in which the proxy moves); the reference continues there from the proxy's own state, also if that step ran out of work
// (ForceMethod::carried_from). So a branch switch before the window does not count, and one within it counts to the window's end. A window
// with an unexplained switch is computed again by a reference with 16 times as many sub-steps, which can only make more steps unsettled.
// Error: a trajectory or method that cannot be made.
Result<std::vector<MeshFigures>> measure_mesh(const MeshRunSettings& settings, const Stopwatch& watch, const NamedMesh& mesh,
                                              const std::function<void(const std::string&)>& progress);

// Median (the upper of two in the middle) and largest value of one figure over all meshes. Pre: figures is not empty.
struct MedianAndWorst {
  double median = 0.0;
  double worst = 0.0;
  std::string worst_mesh;
};
MedianAndWorst over_meshes(const std::vector<MeshFigures>& figures, const std::function<double(const MeshFigures&)>& figure);

std::string to_csv(const std::vector<MeshFigures>& figures);
// One row for every branch switch, with its cause.
std::string switches_to_csv(const std::vector<MeshFigures>& figures);
nlohmann::ordered_json to_json(const std::vector<MeshFigures>& figures);
std::string to_text(const std::vector<MeshFigures>& figures);

}  // namespace hapton
