#include "bench/measure/objects_run.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace hapton {
namespace {

TEST(ObjectsRun, MeasuresEachSceneBesideTheTouchedObjectAlone) {
  const Stopwatch watch = Stopwatch::calibrate();
  ObjectsSettings settings;
  settings.counts = {1, 27};
  settings.triangles = 20000;
  settings.steps = 1000;
  settings.budget = {.repetitions = 2, .seconds = 0.2};
  const auto report = measure_objects(settings, watch, [](const std::string&) {});
  ASSERT_TRUE(report) << report.error().what;
  ASSERT_EQ(report->rows.size(), 10U);
  for (const ObjectsRow& row : report->rows) {
    EXPECT_NEAR(static_cast<double>(row.triangles), 20000.0, 1500.0) << row.what;
    EXPECT_GT(row.all.count, 100U) << row.what;
    EXPECT_EQ(row.all.count, row.alone.count) << row.objects << " objects, " << row.what << ": the others were touched";
    EXPECT_GT(row.all.p50_ns, 0.0) << row.what;
  }
  EXPECT_EQ(report->rows.back().objects, 27U);
  EXPECT_EQ(nlohmann::json::parse(to_json(*report)).at("rows").size(), 10U);
  const std::string csv = to_csv(*report);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 11);
  EXPECT_NE(to_text(*report).find("27"), std::string::npos);
}

// 10 objects need 180 triangles: the coarsest torus has 18.
TEST(ObjectsRun, RejectsMoreObjectsThanThereAreTrianglesFor) {
  const Stopwatch watch = Stopwatch::calibrate();
  ObjectsSettings settings;
  settings.triangles = 100;
  settings.counts = {10};
  const auto report = measure_objects(settings, watch, [](const std::string&) {});
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().what.find("10 objects"), std::string::npos) << report.error().what;
}

}  // namespace
}  // namespace hapton
