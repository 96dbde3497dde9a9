#pragma once

#include <cstddef>
#include <vector>

#include "bench/measure/query_run.h"
#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// What Fixed Direction Hulls of one number of directions cost and gain over one mesh. 6 directions are boxes.
struct HullDirections {
  int directions = 0;
  StructureTiming structure;  // build, bytes, segment and nearest-triangle queries along a slide
  TimeSpread local_set;       // the slow task's query: the 64 triangles nearest to the path
  double nodes = 0.0;         // opened per such query
  double triangles = 0.0;     // distances computed per such query
};

struct HullDirectionsSettings {
  std::uint64_t seed = 1;
  std::size_t steps = 6000;  // of the slide that the queries come from
  TimingBudget budget{.repetitions = 5, .seconds = 2.0};
};

// 6, 14, 18 and 26 directions on the same queries, in that order. Error: as make_slide_trajectory and the trees. RT: set-up only.
Result<std::vector<HullDirections>> compare_hull_directions(const HullDirectionsSettings& settings, const Stopwatch& watch,
                                                            const TriangleMesh& mesh);

}  // namespace hapton
