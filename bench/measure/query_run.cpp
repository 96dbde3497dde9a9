#include "bench/measure/query_run.h"

#include <algorithm>
#include <cmath>

#include "bench/measure/live_heap.h"
#include "bench/measure/own_structures.h"

namespace hapton {
namespace {

// Radius of the queries for the nearest triangle, as a share of the extent: 2.5 mm for 100 mm, a firm press at 1 N/mm; a free choice.
constexpr double kSearchRadiusShare = 0.025;
// Share of the extent by which single precision may differ from brute force: a 25th of the depth from which a fall-through counts
// (ForceError).
constexpr double kAgreeShare = 1e-4;
// Triangle tests by brute force for each kind of query, which take about a second: 20 to 500 queries, depending on the size of the mesh.
constexpr double kMaxTriangleTests = 4e7;
constexpr double kMinCompared = 20.0;
constexpr double kMaxCompared = 500.0;
// Queries from which the time of one is estimated, and the fewest in a measurement; a free choice.
constexpr std::size_t kMinQueries = 16;

// Stride through the queries with which at most `most` of them are used.
std::size_t stride_for(std::size_t queries, std::size_t most) {
  return std::max<std::size_t>(1, (queries + most - 1) / std::max<std::size_t>(1, most));
}

// Stride through the queries with which they fit into a third of the time budget, so that they can be timed about three times. Estimated
// from a few queries.
template <class Query>
std::size_t find_stride(const Stopwatch& watch, const TimingBudget& budget, std::size_t queries, Query&& query) {
  if (queries <= kMinQueries) return 1;
  const std::uint64_t start = Stopwatch::ticks();
  for (std::size_t i = 0; i < kMinQueries; ++i) query(i * (queries / kMinQueries));
  const double each_s = 1e-9 * watch.ns_between(start, Stopwatch::ticks()) / static_cast<double>(kMinQueries);
  const double fit = budget.seconds / 3.0 / std::max(each_s, 1e-9);
  return stride_for(queries, std::max(kMinQueries, static_cast<std::size_t>(std::min(fit, 1e9))));
}

// Two replies agree: both found nothing, or both found the same.
bool is_same_result(double a, double b, double tolerance) {
  if (std::isfinite(a) != std::isfinite(b)) return false;
  return !std::isfinite(a) || std::fabs(a - b) <= tolerance;
}

template <class Query, class Tolerance>
QueryTiming time_queries(const Stopwatch& watch, const TimingBudget& budget, std::size_t queries, const std::vector<double>& truth,
                         std::size_t truth_stride, Query&& query, Tolerance&& tolerance) {
  QueryTiming timing;
  const std::size_t stride = find_stride(watch, budget, queries, query);
  const std::size_t query_count = (queries + stride - 1) / stride;
  std::vector<double> replies(query_count);
  const TimedSteps timed = time_steps(
      watch, budget, query_count, [](std::size_t) {}, [&](std::size_t i) { replies[i] = query(i * stride); }, [](std::size_t) {});
  timing.time = spread_of_times(timed.least.ns());
  timing.mean_ns = timed.mean_ns;
  timing.repetitions = timed.repetitions;
  timing.found = static_cast<std::size_t>(std::count_if(replies.begin(), replies.end(), [](double a) { return std::isfinite(a); }));
  for (std::size_t i = 0; i < truth.size(); ++i) {
    ++timing.compared;
    if (is_same_result(query(i * truth_stride), truth[i], tolerance(i * truth_stride))) ++timing.agree;
  }
  return timing;
}

}  // namespace

TouchQueries make_queries(std::span<const ForceSample> felt, std::size_t reset_every, double extent_m) {
  TouchQueries queries;
  queries.radius = kSearchRadiusShare * extent_m;
  for (std::size_t i = 0; i < felt.size(); ++i) {
    queries.points.push_back(felt[i].device);
    if (i == 0 || (reset_every > 0 && i % reset_every == 0)) continue;
    queries.segments.push_back({felt[i - 1].proxy, felt[i].device});
  }
  return queries;
}

BruteResults query_by_brute_force(const TriangleMesh& mesh, const TouchQueries& queries) {
  BruteResults replies;
  const double fit = kMaxTriangleTests / static_cast<double>(std::max<std::size_t>(1, mesh.triangles.size()));
  const auto most = static_cast<std::size_t>(std::clamp(fit, kMinCompared, kMaxCompared));
  replies.segment_stride = stride_for(queries.segments.size(), most);
  replies.point_stride = stride_for(queries.points.size(), most);
  const auto brute = own_structures().front().make(mesh);
  for (std::size_t i = 0; i < queries.segments.size(); i += replies.segment_stride) {
    replies.hits.push_back((*brute)->first_hit(queries.segments[i].from, queries.segments[i].to));
  }
  for (std::size_t i = 0; i < queries.points.size(); i += replies.point_stride)
    replies.distances.push_back((*brute)->nearest(queries.points[i], queries.radius));
  return replies;
}

Result<StructureTiming> time_structure(const Stopwatch& watch, const TimingBudget& budget, const QueryStructureKind& kind,
                                       const TriangleMesh& mesh, const TouchQueries& queries, const BruteResults& truth, double extent_m) {
  StructureTiming timing;
  const std::size_t heap = read_live_heap_bytes();
  const std::uint64_t start = Stopwatch::ticks();
  auto made = kind.make(mesh);
  timing.build_ms = 1e-6 * watch.ns_between(start, Stopwatch::ticks());
  if (!made) return tl::unexpected(made.error());
  QueryStructure& structure = **made;
  const std::size_t grown = read_live_heap_bytes();
  timing.bytes = structure.bytes() > 0 ? structure.bytes() : grown > heap ? grown - heap : 0;
  if (kind.segments) {
    timing.segments = time_queries(
        watch, budget, queries.segments.size(), truth.hits, truth.segment_stride,
        [&](std::size_t i) { return structure.first_hit(queries.segments[i].from, queries.segments[i].to); },
        [&](std::size_t i) {
          return kAgreeShare * extent_m / std::max(1e-300, (queries.segments[i].to - queries.segments[i].from).norm());
        });
  }
  if (kind.nearests) {
    timing.nearests = time_queries(
        watch, budget, queries.points.size(), truth.distances, truth.point_stride,
        [&](std::size_t i) { return structure.nearest(queries.points[i], queries.radius); },
        [&](std::size_t) { return kAgreeShare * extent_m; });
  }
  return timing;
}

}  // namespace hapton
