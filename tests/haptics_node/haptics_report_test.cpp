#include "haptics_node/haptics_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/force/force_method.h"
#include "runtime/log.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TEST(HapticsReport, TimesSayTheWorstStepAndTheTail) {
  LatencyHistogram times;
  for (int i = 0; i < 9980; ++i) times.record(1'000);
  for (int i = 0; i < 19; ++i) times.record(50'000);
  times.record(1'250'000);
  const std::string text = describe_times("step", times);
  EXPECT_THAT(text, testing::StartsWith("step: p50 1.0"));
  EXPECT_THAT(text, testing::ContainsRegex("p99.9 (49|50)\\."));
  EXPECT_THAT(text, testing::HasSubstr("worst 1250.00, n 10000"));
}

// Method smooth has seven lines or so on each.
TEST(HapticsReport, OfTheObjectsOneLineIsLogged) {
  const auto log_of = [](int objects) {
    TouchScene scene;
    for (int n = 0; n < objects; ++n)
      scene.objects.push_back({.mesh = made::shared(made::box(Vec3(0.1 * n, 0, 0), Vec3(0.1 * n + 0.05, 0.05, 0.05))), .material = {}});
    const auto method = make_method({.name = "smooth"}, scene);
    EXPECT_TRUE(method);
    testing::internal::CaptureStderr();
    start_log("haptics_node");
    if (method) log_method(**method);
    return testing::internal::GetCapturedStderr();
  };
  const std::string of_many = log_of(13);
  EXPECT_THAT(of_many, testing::HasSubstr("smooth: "));
  EXPECT_THAT(of_many, testing::ContainsRegex("object 0: .* \\(and [0-9]+ more lines on objects\\)"));
  EXPECT_THAT(of_many, testing::Not(testing::HasSubstr("object 1:")));
  EXPECT_LT(std::count(of_many.begin(), of_many.end(), '\n'), 10);
}

TEST(HapticsReport, NothingMeasuredIsNoLine) { EXPECT_EQ(describe_times("step", LatencyHistogram()), ""); }

TEST(HapticsReport, SaysHowLateTheToolWas) {
  EXPECT_EQ(describe_late_tool({.samples = 1000, .faded = 0, .longest_s = 0.04}), "");
  const std::string late = describe_late_tool({.samples = 1000, .faded = 25, .longest_s = 0.183});
  EXPECT_NE(late.find("more than 50 ms late in 2.5 % of samples, 183 ms at most"), std::string::npos) << late;
}

}  // namespace
}  // namespace hapton
