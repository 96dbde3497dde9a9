#include "bench/measure/query_run.h"

#include <gtest/gtest.h>

#include <memory>

#include "bench/measure/own_structures.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

class FindsNothing : public QueryStructure {
 public:
  double first_hit(const Vec3&, const Vec3&) override { return kNothingFound; }
  double nearest(const Vec3&, double) override { return kNothingFound; }
};

constexpr std::size_t kQueries = 40;

// Segments down through the sheet, and points a millimetre above it.
TouchQueries queries_at_sheet() {
  TouchQueries queries;
  queries.radius = 0.0025;
  for (std::size_t i = 0; i < kQueries; ++i) {
    const Vec3 above(1e-3 * static_cast<double>(i) - 0.0196, 0.003, 0.001);
    queries.segments.push_back({above, above - Vec3(0.0, 0.0, 0.002)});
    queries.points.push_back(above);
  }
  return queries;
}

Result<StructureTiming> time_at_sheet(const QueryStructureKind& kind) {
  const TriangleMesh sheet = make_plane_grid(0.1, 4);
  const TouchQueries queries = queries_at_sheet();
  return time_structure(Stopwatch::calibrate(), {.repetitions = 1, .seconds = 10.0}, kind, sheet, queries,
                        query_by_brute_force(sheet, queries), 0.1);
}

// In single precision, results agree if they differ by less than a share of the extent.
TEST(QueryRun, AStructureThatFindsWhatBruteForceFindsAgreesInAll) {
  for (const std::size_t number : {0U, 1U}) {
    const QueryStructureKind kind = own_structures()[number];
    SCOPED_TRACE(kind.precision);
    const auto timing = time_at_sheet(kind);
    ASSERT_TRUE(timing) << timing.error().what;
    for (const QueryTiming& query_timing : {timing->segments, timing->nearests}) {
      EXPECT_EQ(query_timing.found, kQueries);
      EXPECT_EQ(query_timing.compared, kQueries);
      EXPECT_EQ(query_timing.agree, kQueries);
    }
  }
}

TEST(QueryRun, AStructureThatFindsNothingAgreesInNone) {
  const auto timing = time_at_sheet({.name = "nothing", .make = [](const TriangleMesh&) -> Result<std::unique_ptr<QueryStructure>> {
                                       return std::make_unique<FindsNothing>();
                                     }});
  ASSERT_TRUE(timing) << timing.error().what;
  for (const QueryTiming& query_timing : {timing->segments, timing->nearests}) {
    EXPECT_EQ(query_timing.found, 0U);
    EXPECT_EQ(query_timing.compared, kQueries);
    EXPECT_EQ(query_timing.agree, 0U);
  }
}

}  // namespace
}  // namespace hapton
