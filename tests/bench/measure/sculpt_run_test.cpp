#include "bench/measure/sculpt_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace hapton {
namespace {

TEST(SculptRun, MeasuresEveryBodyBallAndSeed) {
  const Stopwatch watch = Stopwatch::calibrate();
  SculptRunSettings settings;
  settings.grids = {32};
  settings.radii_voxels = {2.0, 5.0};
  settings.seeds = {1, 2};
  settings.steps = 5000;
  settings.budget = {.repetitions = 1, .seconds = 0.01};
  std::vector<std::string> lines;
  const auto report = measure_sculpting(settings, watch, [&](const std::string& line) { lines.push_back(line); });
  ASSERT_TRUE(report) << report.error().what;
  ASSERT_EQ(report->rows.size(), 12U);
  ASSERT_EQ(lines.size(), 24U) << "two parts of each row";
  EXPECT_EQ(lines[0], "1 of 12: ball, 32 voxels, ball of 2, seed 1: steps");
  EXPECT_EQ(lines[23], "12 of 12: torus, 32 voxels, ball of 5, seed 2: surfaces");
  for (const SculptRunRow& row : report->rows) {
    EXPECT_GT(row.carves, 20U) << row.shape;
    EXPECT_EQ(row.carving.count, row.carves);
    EXPECT_GT(row.touching.count, 20U) << row.shape;
    EXPECT_EQ(row.all.count, 5000U);
    EXPECT_GT(row.presses, 0U);
    EXPECT_GT(row.surface.count, 2U);
    EXPECT_GE(row.all.worst_ns, row.carving.worst_ns);
  }
  EXPECT_NE(report->rows[0].carves, report->rows[1].carves) << "another seed is another motion";
  EXPECT_EQ(nlohmann::json::parse(to_json(*report)).at("rows").size(), 12U);
  const std::string csv = to_csv(*report);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 13);
  EXPECT_NE(to_text(*report).find("torus"), std::string::npos);
}

// The number of carves depends on the motion alone, not on how often it is timed.
TEST(SculptRun, EachRepetitionBeginsWithTheWholeBody) {
  const Stopwatch watch = Stopwatch::calibrate();
  SculptRunSettings settings;
  settings.grids = {32};
  settings.radii_voxels = {4.0};
  settings.seeds = {3};
  settings.steps = 800;
  settings.budget = {.repetitions = 1, .seconds = 0.01};
  const auto once = measure_sculpting(settings, watch, [](const std::string&) {});
  settings.budget = {.repetitions = 3, .seconds = 1e3};
  const auto often = measure_sculpting(settings, watch, [](const std::string&) {});
  ASSERT_TRUE(once && often);
  for (std::size_t i = 0; i < once->rows.size(); ++i) EXPECT_EQ(once->rows[i].carves, often->rows[i].carves);
}

}  // namespace
}  // namespace hapton
