#pragma once

#include <cstddef>
#include <vector>

#include "bench/measure/query_run.h"
#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// The cost and gain of Fixed Direction Hulls with a given number of directions over one mesh. With 6 directions they are boxes.
struct HullDirections {
  int directions = 0;
  StructureTiming structure;  // build, bytes, segment and nearest-triangle queries along a slide
  TimeSpread local_set;       // the slow task's query: the 64 triangles nearest to the path
  double nodes = 0.0;         // nodes opened per such query
  double triangles = 0.0;     // distances to triangles computed per such query
};

struct HullDirectionsSettings {
  std::uint64_t seed = 1;
  std::size_t steps = 6000;  // steps of the slide from which the queries are taken
  TimingBudget budget{.repetitions = 5, .seconds = 2.0};
};

// Measures 6, 14, 18 and 26 directions, in that order, on the same queries. Error: a slide or tree that cannot be made. RT: set-up only.
Result<std::vector<HullDirections>> compare_hull_directions(const HullDirectionsSettings& settings, const Stopwatch& watch,
                                                            const TriangleMesh& mesh);

}  // namespace hapton
