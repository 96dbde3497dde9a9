#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "bench/papers/papers_report.h"
#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// A mesh and the name that the report gives it.
struct PapersMesh {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;
};

struct PapersSettings {
  std::uint64_t seed = 1;
  std::size_t steps = 12000;    // steps of the sliding trajectory for force rates and hulls
  double touch_seconds = 12.0;  // how long the fast and the slow task run, at each rate
  double hapton_seconds = 5.0;
  TimingBudget budget{.repetitions = 5, .seconds = 3.0};  // for each measured value
};

// Fills in all rows but those that need running nodes. car: a car body of 3,300 triangles, as many as the HP memo's object has polygons;
// paper_mesh: a mesh of about 20,000 triangles, as in the FDH paper. Error: a mesh or method that cannot be used; a slow task that gave no
// set of triangles. A row that cannot be measured says why. RT: set-up only.
Result<void> measure_papers(const PapersSettings& settings, const Stopwatch& watch, const PapersMesh& car, const PapersMesh& paper_mesh,
                            const std::function<void(const std::string&)>& progress, PapersReport& report);

}  // namespace hapton
