#include "bench/measure/effects_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace hapton {
namespace {

TEST(EffectsRun, MeasuresEveryEffectBesideNone) {
  const Stopwatch watch = Stopwatch::calibrate();
  EffectsSettings settings;
  settings.triangles = 2000;
  settings.steps = 300;
  settings.budget = {.repetitions = 1, .seconds = 0.1};
  const auto report = measure_effects(settings, watch, [](const std::string&) {});
  ASSERT_TRUE(report) << report.error().what;
  ASSERT_EQ(report->rows.size(), 28U);
  EXPECT_EQ(report->rows[0].effect, "none");
  EXPECT_EQ(report->rows[0].added_ns, 0.0);
  for (const EffectsRow& row : report->rows) {
    EXPECT_GT(row.contact.count, 30U) << row.effect;
    EXPECT_GT(row.mean_ns, 0.0) << row.effect;
    EXPECT_DOUBLE_EQ(row.added_ns, row.contact.p50_ns - report->rows[0].contact.p50_ns) << row.effect;
    EXPECT_EQ(row.error.has_value(), row.effect.rfind("texture", 0) != 0) << row.effect;
  }
  EXPECT_EQ(nlohmann::json::parse(to_json(*report)).at("rows").size(), 28U);
  EXPECT_LT(report->rows[1].error->rms, 1e-6) << report->rows[1].effect;
  EXPECT_TRUE(nlohmann::json::parse(to_json(*report)).at("rows").back().at("error_rms").is_null());
  const std::string csv = to_csv(*report);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 29);
  EXPECT_NE(to_text(*report).find("gravity well"), std::string::npos);
  EXPECT_NE(to_text(*report).find("texture of 10 kHz"), std::string::npos);
}

}  // namespace
}  // namespace hapton
