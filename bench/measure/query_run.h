#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "bench/measure/query_structure.h"
#include "bench/measure/step_times.h"
#include "core/force/evaluation/force_error.h"

namespace hapton {

// The queries of a force method along a trajectory: the segments that a proxy sweeps to the next device point, and the device points.
struct TouchQueries {
  struct Segment {
    Vec3 from, to;
  };
  std::vector<Segment> segments;  // from the proxy of the step before to the device point of this step
  std::vector<Vec3> points;
  double radius = 0.0;  // search radius for the nearest triangle, m: a fortieth of the extent, 2.5 mm of 100

  bool empty() const { return points.empty(); }
};

// Makes the queries from a method's output; no segment crosses a reset.
TouchQueries make_queries(std::span<const ForceSample> felt, std::size_t reset_every, double extent_m);

struct QueryTiming {
  TimeSpread time;
  double mean_ns = 0.0;  // mean without reading the clock in between
  int repetitions = 0;
  std::size_t found = 0;     // timed queries that found something
  std::size_t compared = 0;  // queries compared with brute force in double
  std::size_t agree = 0;     // those that are equal within 1e-4 of the extent, a 25th of the depth from which a fall-through counts
};

// Results of one structure over one mesh.
struct StructureTiming {
  double build_ms = 0.0;
  std::size_t bytes = 0;  // as the library reports them, otherwise the growth of the heap
  QueryTiming segments, nearests;
};

// Brute-force results of every n-th query; n is the stride.
struct BruteResults {
  std::size_t segment_stride = 1, point_stride = 1;
  std::vector<double> hits, distances;
};
BruteResults query_by_brute_force(const TriangleMesh& mesh, const TouchQueries& queries);

// Builds the structure and times its queries. If all of them would exceed the budget, every n-th is used. Error: that of kind.make.
Result<StructureTiming> time_structure(const Stopwatch& watch, const TimingBudget& budget, const QueryStructureKind& kind,
                                       const TriangleMesh& mesh, const TouchQueries& queries, const BruteResults& truth, double extent_m);

}  // namespace hapton
