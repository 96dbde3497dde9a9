#include "closed_loop/force_chain.h"

#include <gtest/gtest.h>

#include <vector>

namespace hapton {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;

// Replies to a position of x metres with a force of x newtons, and records its input.
struct EchoLaw final : ForceLaw {
  Vec3 step(const Vec3& p_WD, double dt_s) noexcept override {
    positions_m.push_back(p_WD.x());
    durations_s.push_back(dt_s);
    return p_WD;
  }
  void reset(const Vec3& p_WD) noexcept override { reset_positions_m.push_back(p_WD.x()); }
  std::vector<double> positions_m;
  std::vector<double> durations_s;
  std::vector<double> reset_positions_m;
};

// Adds a newton along y, and records its input.
struct AddingStage final : ForceStage {
  void observe(const Vec3& p_WD, std::int64_t now_ns) noexcept override {
    read_m.push_back(p_WD.x());
    last_ns = now_ns;
  }
  Vec3 shape(const Vec3& force_n, std::int64_t) noexcept override { return force_n + Vec3(0, 1, 0); }
  void note_written(const Vec3& force_n) noexcept override { written.push_back(force_n); }
  std::vector<double> read_m;
  std::vector<Vec3> written;
  std::int64_t last_ns = 0;
};

Vec3 along_x(double x) { return {x, 0.0, 0.0}; }

TEST(ForceChain, WithoutALinkTheForceIsThatOfTheSample) {
  EchoLaw law;
  ForceChain chain(law, {});
  chain.sample(along_x(3.0), kMillisecond);
  EXPECT_EQ(chain.force_n(), along_x(3.0));
  chain.sample(along_x(4.0), 3 * kMillisecond);
  EXPECT_EQ(chain.force_n(), along_x(4.0));
  EXPECT_EQ(law.reset_positions_m, std::vector{3.0}) << "once, where the device is first";
  ASSERT_EQ(law.durations_s.size(), 2U);
  EXPECT_EQ(law.durations_s[0], 0.0);
  EXPECT_NEAR(law.durations_s[1], 0.002, 1e-15);
  EXPECT_EQ(chain.counters().samples, 2U);
  EXPECT_EQ(chain.counters().replies, 2U);
  EXPECT_EQ(chain.counters().lost, 0U);
  EXPECT_EQ(chain.counters().overtaken, 0U);
  EXPECT_EQ(chain.governor(), nullptr);
}

TEST(ForceChain, TheEncoderReadsWholeSteps) {
  EchoLaw law;
  ForceChain chain(law, {.encoder_step_m = 0.5});
  const std::pair<double, double> cases[] = {{0.2, 0.0}, {0.3, 0.5}, {0.7, 0.5}, {-0.3, -0.5}, {-1.1, -1.0}};
  std::int64_t now_ns = 0;
  for (const auto& [at, read_m] : cases) {
    chain.sample(along_x(at), now_ns += kMillisecond);
    EXPECT_EQ(law.positions_m.back(), read_m) << at;
  }
}

TEST(ForceChain, TheForceArrivesAfterBothDelays) {
  EchoLaw law;
  ForceChain chain(law, {.to_law = {.delay_ns = 2 * kMillisecond}, .from_law = {.delay_ns = 3 * kMillisecond}});
  EXPECT_EQ(chain.next_ns(), std::nullopt);
  chain.sample(along_x(1.0), 10 * kMillisecond);
  EXPECT_EQ(chain.next_ns(), 12 * kMillisecond);
  chain.receive(12 * kMillisecond - 1);
  EXPECT_TRUE(law.positions_m.empty());
  chain.receive(12 * kMillisecond);
  EXPECT_EQ(law.positions_m.size(), 1U);
  EXPECT_EQ(chain.next_ns(), 15 * kMillisecond);
  chain.receive(15 * kMillisecond - 1);
  EXPECT_EQ(chain.force_n(), along_x(0.0));
  chain.receive(15 * kMillisecond);
  EXPECT_EQ(chain.force_n(), along_x(1.0));
  EXPECT_EQ(chain.next_ns(), std::nullopt);
  chain.sample(along_x(2.0), 16 * kMillisecond);
  EXPECT_EQ(chain.force_n(), along_x(1.0)) << "the newest holds until another has come";
}

TEST(ForceChain, LostPacketsAreCountedAndGiveNoForce) {
  EchoLaw law;
  ForceChain without_samples(law, {.to_law = {.loss = 1.0}});
  without_samples.sample(along_x(1.0), kMillisecond);
  EXPECT_TRUE(law.positions_m.empty());
  EXPECT_EQ(without_samples.counters().lost, 1U);
  ForceChain without_replies(law, {.from_law = {.loss = 1.0}});
  without_replies.sample(along_x(1.0), kMillisecond);
  EXPECT_EQ(law.positions_m.size(), 1U);
  EXPECT_EQ(without_replies.counters().lost, 1U);
  EXPECT_EQ(without_replies.counters().replies, 0U);
  EXPECT_EQ(without_replies.force_n(), along_x(0.0));
}

TEST(ForceChain, ADuplicateIsAcceptedOnce) {
  EchoLaw law;
  ForceChain chain(law, {.to_law = {.duplicate = 1.0}, .from_law = {.duplicate = 1.0}});
  chain.sample(along_x(1.0), kMillisecond);
  chain.receive(100 * kMillisecond);
  EXPECT_EQ(law.positions_m.size(), 1U);
  EXPECT_EQ(chain.counters().replies, 2U);
  EXPECT_EQ(chain.counters().overtaken, 2U) << "one at either end";
}

// The jitter is many periods long: the law sees no older sample after a newer one, and forces come in the order of their samples.
TEST(ForceChain, BothEndsUseOnlyTheNewest) {
  EchoLaw law;
  ForceChain chain(law, {.to_law = {.jitter_ns = 20 * kMillisecond}, .from_law = {.jitter_ns = 20 * kMillisecond}, .seed = 3});
  double last = 0.0;
  for (int n = 1; n <= 300; ++n) {
    chain.sample(along_x(n), n * kMillisecond);
    EXPECT_GE(chain.force_n().x(), last);
    last = chain.force_n().x();
  }
  chain.receive(1'000 * kMillisecond);  // samples that are still on the way to the law
  chain.receive(2'000 * kMillisecond);  // and forces on the way back
  EXPECT_GT(last, 200.0);
  EXPECT_TRUE(std::is_sorted(law.positions_m.begin(), law.positions_m.end()));
  EXPECT_LT(law.positions_m.size(), 300U);
  EXPECT_GT(chain.counters().overtaken, 300U - law.positions_m.size());
  double total_s = 0.0;
  for (const double duration_s : law.durations_s) total_s += duration_s;
  EXPECT_NEAR(total_s, 1e-3 * (law.positions_m.back() - law.positions_m.front()), 1e-9);
}

TEST(ForceChain, TheForceIsAtMostThatOfTheMotors) {
  EchoLaw law;
  ForceChain chain(law, {.max_force_n = 2.0});
  chain.sample({3.0, 4.0, 0.0}, kMillisecond);
  EXPECT_NEAR((chain.force_n() - Vec3(1.2, 1.6, 0.0)).norm(), 0.0, 1e-11);
  chain.sample({0.3, 0.4, 0.0}, 2 * kMillisecond);
  EXPECT_EQ(chain.force_n(), Vec3(0.3, 0.4, 0.0));
}

TEST(ForceChain, AStageSeesEachSampleAndWhatIsWrittenOfItsForce) {
  EchoLaw law;
  AddingStage stage;
  ForceChain chain(law, {.encoder_step_m = 1.0, .max_force_n = 1.0, .from_law = {.delay_ns = 2 * kMillisecond}, .stage = &stage});
  chain.sample(along_x(0.9), kMillisecond);
  EXPECT_EQ(stage.read_m, std::vector{1.0});
  EXPECT_EQ(stage.last_ns, kMillisecond);
  ASSERT_EQ(stage.written.size(), 1U) << "though no force has come";
  EXPECT_EQ(stage.written[0], Vec3(0, 1, 0));
  chain.sample(along_x(0.9), 3 * kMillisecond);
  EXPECT_NEAR((chain.force_n() - Vec3(std::sqrt(0.5), std::sqrt(0.5), 0.0)).norm(), 0.0, 1e-11) << "shortened after the stage";
  EXPECT_EQ(stage.written.back(), chain.force_n());
  // Until the next force comes, the newest one is kept, and is shaped again at each sample.
  const std::size_t written = stage.written.size();
  chain.sample(along_x(0.0), 4 * kMillisecond);
  EXPECT_EQ(stage.written.size(), written + 1);
  EXPECT_NEAR(chain.force_n().x(), std::sqrt(0.5), 1e-11);
}

TEST(ForceChain, TheFilterHoldsAForceForTwentyMillisecondsOfItsSample) {
  EchoLaw law;
  ForceChain chain(law, {.to_law = {.delay_ns = 5 * kMillisecond}, .gate = ForceChain::Gate::filter});
  chain.sample(along_x(1.0), 10 * kMillisecond);
  chain.receive(15 * kMillisecond);
  EXPECT_EQ(chain.force_n(), along_x(1.0));
  EchoLaw undelayed_law;
  ForceChain undelayed(undelayed_law, {.gate = ForceChain::Gate::filter, .stage = nullptr});
  undelayed.sample(along_x(1.0), 10 * kMillisecond);
  EXPECT_EQ(undelayed.force_n(), along_x(1.0));
  chain.sample(along_x(2.0), 29 * kMillisecond);
  EXPECT_EQ(chain.force_n(), along_x(1.0));
  chain.sample(along_x(2.0), 31 * kMillisecond);
  EXPECT_EQ(chain.force_n(), along_x(0.0)) << "21 ms after its sample, and the next is on its way";
  chain.receive(34 * kMillisecond);
  EXPECT_EQ(chain.force_n(), along_x(2.0));
}

TEST(ForceChain, TheGovernorLimitsRateAndMagnitude) {
  EchoLaw law;
  const DeviceLimits limits{.max_force_n = 3.0,
                            .max_slew_n_per_s = 100.0,
                            .max_stiffness_n_per_m = 1e6,
                            .workspace_min_m = Vec3::Constant(-10.0),
                            .workspace_max_m = Vec3::Constant(10.0),
                            .max_speed_m_per_s = 3.0};
  ForceChain chain(law, {.gate = ForceChain::Gate::governor, .limits = limits});
  ASSERT_NE(chain.governor(), nullptr);
  double last = 0.0;
  double most = 0.0;
  for (int n = 1; n < 2000; ++n) {
    chain.sample(along_x(5.0), n * kMillisecond);
    EXPECT_LE(chain.force_n().x() - last, 100.0 * 1e-3 + 1e-9) << n;
    last = chain.force_n().x();
    most = std::max(most, last);
  }
  EXPECT_GT(most, 0.5);
  EXPECT_LE(most, 3.0);
}

}  // namespace
}  // namespace hapton
