#include "bench/papers/smooth_tasks.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TouchScene bumpy_scene() {
  TouchScene scene;
  scene.objects.push_back({made::shared(make_bumpy_sphere(0.045, 0.1, 5000, 1)), {}});
  return scene;
}

SmoothTasksSettings short_run() {
  SmoothTasksSettings settings;
  settings.seconds = 2.0;
  settings.repetitions = 2;
  return settings;
}

TEST(MeasureSmoothTasks, TheFastTaskUsesTheSetsOfTheSlowOne) {
  const TouchScene scene = bumpy_scene();
  const Stopwatch watch = Stopwatch::calibrate();
  for (const double rate_hz : {1000.0, 3000.0}) {
    const auto tasks = measure_smooth_tasks(short_run(), watch, scene, rate_hz);
    ASSERT_TRUE(tasks) << tasks.error().what;
    EXPECT_EQ(tasks->steps, static_cast<std::size_t>(2.0 * rate_hz));
    EXPECT_EQ(tasks->repetitions, 2);
    EXPECT_GT(tasks->contact_steps, tasks->steps / 4);
    EXPECT_GT(tasks->offered, 20U);
    EXPECT_GE(tasks->slow.count, tasks->offered) << "no set without a selection";
    EXPECT_GT(tasks->swap.p50_ns, 0.0);
    EXPECT_LT(tasks->share_without_set(), 0.5);
    EXPECT_LE(tasks->beyond_set, tasks->without_set);
    EXPECT_LE(tasks->at_work.count, tasks->steps);
    EXPECT_GT(tasks->at_work.count, 0U);
    EXPECT_LT(tasks->age.p50_ns, 1e9);
  }
}

// If the slow task runs seldom, the fast one selects more often by itself. If it never runs, that is an error, not a row of zeros.
TEST(MeasureSmoothTasks, ASlowTaskThatRunsSeldomShows) {
  const TouchScene scene = bumpy_scene();
  const Stopwatch watch = Stopwatch::calibrate();
  SmoothTasksSettings often = short_run();
  often.slow_period_s = 0.001;
  SmoothTasksSettings seldom = short_run();
  seldom.slow_period_s = 0.2;
  const auto with_frequent_sets = measure_smooth_tasks(often, watch, scene, 1000.0);
  const auto with_rare_sets = measure_smooth_tasks(seldom, watch, scene, 1000.0);
  ASSERT_TRUE(with_frequent_sets) << with_frequent_sets.error().what;
  ASSERT_TRUE(with_rare_sets) << with_rare_sets.error().what;
  EXPECT_LT(with_frequent_sets->without_set, with_rare_sets->without_set);
  EXPECT_GT(with_frequent_sets->offered, with_rare_sets->offered);

  SmoothTasksSettings never = short_run();
  never.slow_period_s = 1e6;
  const auto nothing = measure_smooth_tasks(never, watch, scene, 1000.0);
  ASSERT_FALSE(nothing);
  EXPECT_NE(nothing.error().what.find("never gave the fast one a set"), std::string::npos) << nothing.error().what;
}

TEST(SmoothTasks, IdleIsWhatIsLeftOfThePeriod) {
  SmoothTasks tasks;
  tasks.rate_hz = 3000.0;
  tasks.busy_mean_ns = 1e9 / 6000.0;
  tasks.at_work_mean_ns = 1e9 / 3000.0;
  tasks.busy.worst_ns = 2e9 / 3000.0;
  EXPECT_NEAR(tasks.idle_share(), 0.5, 1e-12) << "the paper's 50 %";
  EXPECT_NEAR(tasks.idle_share_at_work(), 0.0, 1e-12);
  EXPECT_NEAR(tasks.idle_share_worst(), -1.0, 1e-12) << "late by a period";
}

}  // namespace
}  // namespace hapton
