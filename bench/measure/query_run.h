#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "bench/measure/query_structure.h"
#include "bench/measure/step_times.h"
#include "core/force/evaluation/force_error.h"

namespace hapton {

// What touch asks a structure along a trajectory: the segments a proxy sweeps to the next device point, and the device points themselves.
struct TouchQueries {
  struct Segment {
    Vec3 from, to;
  };
  std::vector<Segment> segments;  // proxy before -> device now
  std::vector<Vec3> points;
  double radius = 0.0;  // within which the nearest triangle is asked for: a fortieth of the extent, 2.5 mm of 100

  bool empty() const { return points.empty(); }
};

// From what a method felt; nothing leads across a reset.
TouchQueries make_queries(std::span<const FeltStep> felt, std::size_t reset_every, double extent_m);

struct QueryTiming {
  TimeSpread time;
  double mean_ns = 0.0;  // no clock in between
  int repetitions = 0;
  std::size_t found = 0;     // queries that found something
  std::size_t compared = 0;  // with brute force in double,
  std::size_t agree = 0;     // the same within 1e-4 of the extent, a quarter of the least that is felt as a fall
};

// One structure over one mesh.
struct StructureTiming {
  double build_ms = 0.0;
  std::size_t bytes = 0;  // as the library says, else by which the heap grew
  QueryTiming segments, nearests;
};

// Answers of brute force to some of the queries, spread evenly.
struct BruteAnswers {
  std::size_t segment_stride = 1, point_stride = 1;
  std::vector<double> hits, distances;
};
BruteAnswers answer_by_brute_force(const TriangleMesh& mesh, const TouchQueries& queries);

// Builds the structure and times its queries. Where all of them would take longer than the budget, every n-th is asked. Error: as its make.
Result<StructureTiming> time_structure(const Stopwatch& watch, const TimingBudget& budget, const QueryStructureKind& kind,
                                       const TriangleMesh& mesh, const TouchQueries& queries, const BruteAnswers& truth, double extent_m);

}  // namespace hapton
