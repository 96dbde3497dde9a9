#include "bench/measure/numbers_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/measure/own_structures.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

NumberRow row(std::optional<double> target, std::optional<double> ours, bool at_least = false) {
  NumberRow made;
  made.what = "what";
  made.metric = "p50";
  made.target = target;
  made.ours = ours;
  made.at_least = at_least;
  return made;
}

TEST(NumberRow, IsMetAtItsTargetAndNotBeyond) {
  EXPECT_TRUE(row(5.0, 5.0).is_met());
  EXPECT_FALSE(row(5.0, 5.1).is_met());
  EXPECT_TRUE(row(5.0, 5.0, true).is_met());
  EXPECT_FALSE(row(5.0, 4.9, true).is_met());
  EXPECT_FALSE(row(5.0, std::nullopt).is_met());
  EXPECT_FALSE(row(std::nullopt, 1.0).is_met());
}

TEST(NumbersReport, CountsWhatWasMeasuredAndMet) {
  NumbersReport report;
  report.rows = {row(5.0, 1.0), row(5.0, 9.0), row(5.0, std::nullopt), row(std::nullopt, 1.0)};
  EXPECT_EQ(report.measured(), 2U);
  EXPECT_EQ(report.met(), 1U);
  const std::string text = to_text(report);
  EXPECT_THAT(text, HasSubstr("1 of 2 targets"));
  EXPECT_THAT(text, HasSubstr("NOT MET"));
}

// The whole measurement, small: every row of the table exists, and everything that does not depend on the machine holds.
TEST(Numbers, MeasureEveryRow) {
  NumbersSettings settings;
  settings.ladder = {300, 1000};
  settings.steps = 400;
  settings.compared_steps = 300;
  settings.scale_exponents = {-6, 0, 6};
  settings.budget = {.repetitions = 1, .seconds = 0.05};
  settings.rough_triangles = 1000;
  settings.meshes = {.seeds = {1, 2}, .steps = 400, .repetitions = 1, .windows = 1, .window_steps = 20};
  std::vector<QueryStructureKind> structures = own_structures();
  std::erase_if(structures, [](const QueryStructureKind& kind) { return kind.full_name() != "fdh 14"; });
  const auto report =
      measure_numbers(settings, Stopwatch::calibrate(), structures,
                      {{"box", std::make_shared<TriangleMesh>(make_box(Vec3(0.1, 0.06, 0.04)))}}, [](const std::string&) {});
  ASSERT_TRUE(report.has_value()) << report.error().what;
  EXPECT_EQ(report->rows.size(), 123U);
  EXPECT_EQ(report->measured(), 33U);
  for (const NumberRow& one : report->rows) {
    if (one.what.starts_with("fall-through") || one.what.starts_with("stuck")) {
      EXPECT_EQ(*one.ours, 0.0) << one.what << ": " << one.note;
    }
    if (one.unit == "ns") {
      EXPECT_GT(*one.ours, 0.0) << one.what;
    }
  }
  const auto json = nlohmann::json::parse(to_json(*report));
  EXPECT_EQ(json["schema"], "hapton.bench/3");
  EXPECT_EQ(json["rows"].size(), report->rows.size());
  EXPECT_EQ(json["meshes"].size(), 12U);  // three meshes, two probes, without and with friction
}

}  // namespace
}  // namespace hapton
