#include "haptics_node/haptics_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "core/force/force_method.h"
#include "runtime/log.h"
#include "tests/haptics_node/reply_loop_stage.h"
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

// Method smooth has about seven lines on each object.
TEST(HapticsReport, ObjectsAreLoggedInOneLine) {
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

TEST(HapticsReport, NothingMeasuredGivesNoLine) { EXPECT_EQ(describe_times("step", LatencyHistogram()), ""); }

class HapticsReportOfARun : public ReplyLoopStage {
 protected:
  void take(const Message&) override {}
  std::string report() const { return make_haptics_report(step_, client_, {}, {}); }
  void reply(double z_m) {
    step_.offer({.sample = ++sample_, .sample_time_ns = 1'000'000 * static_cast<std::int64_t>(sample_), .p_WD = Vec3(0.01, 0.01, z_m)});
    step_.reply();
  }

  TouchScene scene_ = {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {}}}};
  HapticsStep step_{std::make_unique<TouchStep>(*make_method({}, scene_)), 1e-5};
  std::uint64_t sample_ = 0;
};

TEST_F(HapticsReportOfARun, SaysHowManySamplesHadAReplyAndHowStrongItWas) {
  EXPECT_THAT(report(), testing::HasSubstr("0 samples with a reply, 0 in contact, maximum 0.000 N; 0 skipped, 0 lost, 0 reordered; joined "
                                           "the hub 0 times\n"));
  Datagram datagram;
  for (int i = 0; i < 10 && client_.state() != JoinState::joined; ++i) {
    client_.receive(datagram, clock_.now_ns() + kMs);
    receive_at_hub();
  }
  reply(0.001);
  reply(-0.002);
  step_.offer({.sample = ++sample_, .sample_time_ns = 3'000'000, .p_WD = Vec3(0.01, 0.01, -0.009)});
  reply(-0.001);
  const std::string text = report();
  EXPECT_THAT(text,
              testing::StartsWith("haptics_node: 3 samples with a reply, 2 in contact, maximum 2.000 N; 1 skipped, 0 lost, 0 reordered; "
                                  "joined the hub once\n"));
  EXPECT_THAT(text, testing::EndsWith(step_.touch().method().describe()));
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("view transforms")));
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("methods changed")));
}

TEST_F(HapticsReportOfARun, NamesTurnsOfTheSceneAndChangesOfTheMethod) {
  ASSERT_FALSE(step_.turn_scene({.X_WS = {}}));
  EXPECT_THAT(report(), testing::HasSubstr("view transforms: 0 applied, 1 rejected (not rigid)\n"));
  for (std::uint32_t revision = 1; revision <= 2; ++revision) ASSERT_TRUE(step_.turn_scene({.revision = revision}));
  EXPECT_THAT(report(), testing::HasSubstr("view transforms: 2 applied, 1 rejected (not rigid)\n"));
  reply(0.001);
  (void)step_.replace(std::make_unique<TouchStep>(*make_method({.name = "sweep"}, scene_)));
  EXPECT_THAT(report(), testing::HasSubstr("methods changed while running: 1\n"));
}

TEST(HapticsReport, SaysHowLateTheToolWas) {
  EXPECT_EQ(describe_late_tool({.samples = 1000, .faded = 0, .longest_s = 0.04}), "");
  const std::string late = describe_late_tool({.samples = 1000, .faded = 25, .longest_s = 0.183});
  EXPECT_NE(late.find("more than 50 ms late in 2.5 % of samples, 183 ms at most"), std::string::npos) << late;
}

}  // namespace
}  // namespace hapton
