#include "bench/papers/papers_run.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TEST(MeasurePapers, FillsAllRowsButThoseOfTheNodes) {
  PapersSettings settings;
  settings.steps = 300;
  settings.touch_seconds = 1.0;
  settings.hapton_seconds = 0.01;
  settings.budget = {.repetitions = 1, .seconds = 0.05};
  const PapersMesh mesh{"bumpy", made::shared(make_bumpy_sphere(0.045, 0.1, 5000, 1))};
  PapersReport report = make_papers_report();
  const auto done = measure_papers(
      settings, Stopwatch::calibrate(), mesh, mesh, [](const std::string&) {}, report);
  ASSERT_TRUE(done) << done.error().what;
  EXPECT_FALSE(report.is_complete()) << "no node has run";
  for (const auto key : {kStereoCulled, kStereoUnculled, kRoundTrip, kSystemLatency}) EXPECT_FALSE(report.row(key).ours) << key;
  EXPECT_EQ(report.tasks.size(), 3U);
  EXPECT_EQ(report.hulls.size(), 4U);
  const double mean = *report.row("memo.grid_mean").ours;
  EXPECT_GT(mean, 1.0);
  EXPECT_GE(*report.row("memo.grid_max").ours, mean);
  EXPECT_GT(*report.row("memo.force_rate_grid").ours, *report.row("memo.force_rate_all").ours) << "a grid of one cell tests every triangle";
  EXPECT_GE(*report.row("fdh.query_most").ours, *report.row("fdh.query_typical").ours);
  EXPECT_GT(*report.row("fdh.idle_1khz").ours, *report.row("fdh.idle_10khz").ours);
  report.leave_out_nodes();
  EXPECT_TRUE(report.is_complete());
}

}  // namespace
}  // namespace hapton
