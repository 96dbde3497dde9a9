#include "bench/measure/pareto_run.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bench/measure/own_structures.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

// Counts the columns of a CSV line; a comma within quotes does not separate.
std::size_t count_columns(const std::string& line) {
  bool is_quoted = false;
  std::size_t columns = 1;
  for (const char c : line) {
    if (c == '"') is_quoted = !is_quoted;
    if (c == ',' && !is_quoted) ++columns;
  }
  return columns;
}

TEST(TakeHeads, KeepsTheFirstRowsOfEachPiece) {
  TouchTrajectory whole;
  whole.reset_every = 4;
  for (int i = 0; i < 10; ++i) whole.p_SD.push_back(Vec3::Constant(i));
  const TouchTrajectory heads = take_heads(whole, 2);
  EXPECT_EQ(heads.reset_every, 2U);
  ASSERT_EQ(heads.p_SD.size(), 6U);
  const double expected[] = {0, 1, 4, 5, 8, 9};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(heads.p_SD[i].x(), expected[i]);
}

TEST(TakeHeads, OfAllRowsIsTheWhole) {
  TouchTrajectory whole;
  whole.p_SD.assign(5, Vec3::Zero());
  EXPECT_EQ(take_heads(whole, 100).p_SD.size(), 5U);
}

TEST(MakeQueries, LeadFromProxyToDeviceAndNotAcrossAReset) {
  std::vector<ForceSample> samples(6);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].device = Vec3::Constant(static_cast<double>(i));
    samples[i].proxy = Vec3::Constant(static_cast<double>(i) + 100.0);
  }
  const TouchQueries queries = make_queries(samples, 3, 0.1);
  EXPECT_EQ(queries.points.size(), 6U);
  ASSERT_EQ(queries.segments.size(), 4U);
  EXPECT_EQ(queries.segments[2].from.x(), 103.0);
  EXPECT_EQ(queries.segments[2].to.x(), 4.0);
  EXPECT_DOUBLE_EQ(queries.radius, 0.0025);
}

TEST(Pareto, MeasuresEveryMethodAndStructure) {
  ParetoSettings settings;
  settings.steps = 400;
  settings.compared_steps = 300;
  settings.budget = {.repetitions = 1, .seconds = 0.02};
  TriangleMesh sphere = make_bumpy_sphere(0.045, 0.2, 1000, 1);
  ParetoReport report;
  const auto structures = own_structures();
  const auto done = measure_pareto(
      settings, Stopwatch::calibrate(), "bumpy", std::make_shared<TriangleMesh>(std::move(sphere)), structures, [](const std::string&) {},
      report);
  ASSERT_TRUE(done.has_value()) << done.error().what;
  EXPECT_EQ(report.queries.size(), structures.size());
  for (const char* family : {"proxy point", "proxy sphere", "sweep", "smooth", "smooth layer", "reference"}) {
    EXPECT_TRUE(std::any_of(report.methods.begin(), report.methods.end(), [&](const MethodRow& row) { return row.family == family; }))
        << family;
  }
  for (const int directions : {6, 14, 18, 26}) {
    EXPECT_TRUE(std::any_of(report.methods.begin(), report.methods.end(), [&](const MethodRow& row) {
      return row.structure == fmt::format("fdh {}, set 64", directions);
    })) << directions;
  }
  for (const MethodRow& row : report.methods) {
    EXPECT_GT(row.timing.contact.count, 0U) << row.family;
    EXPECT_GE(row.timing.contact.worst_ns, row.timing.contact.p50_ns) << row.family;
    EXPECT_GT(row.error.contact_steps, 0U) << row.family;
    if (row.family.starts_with("proxy")) {
      EXPECT_EQ(row.error.fall_throughs, 0U) << row.family;
      EXPECT_LT(row.error.error.p99, 1e-3) << row.family;
    }
  }
  for (const QueryRow& row : report.queries) {
    if (row.kind.precision != "double") continue;  // in float, rounding loses a segment that begins on the surface
    EXPECT_EQ(row.timing.segments.agree, row.timing.segments.compared) << row.kind.full_name();
    EXPECT_EQ(row.timing.nearests.agree, row.timing.nearests.compared) << row.kind.full_name();
  }
  const std::string csv = to_csv(report);
  std::istringstream lines(csv);
  std::string header;
  std::getline(lines, header);
  for (std::string line; std::getline(lines, line);) EXPECT_EQ(count_columns(line), count_columns(header)) << line;
  EXPECT_EQ(nlohmann::json::parse(to_json(report))["methods"].size(), report.methods.size());
  const auto marks = pareto_marks(report);
  for (const char* label : {"8", "128", "d6", "d26"})
    EXPECT_TRUE(std::any_of(marks.begin(), marks.end(), [&](const ParetoMark& mark) { return mark.label == label; })) << label;
}

}  // namespace
}  // namespace hapton
