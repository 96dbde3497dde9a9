#include "plugin/plugin_effects.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/standins/paths.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/system_call_guard.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

PluginChoice odd_effect(const std::string& parameters) {
  return *parse_plugin_choice(standin::library("plugins/odd_effect.so") + (parameters.empty() ? "" : ":" + parameters));
}

struct PluginEffectsTest : testing::Test {
  SimulatedClock clock;
  PluginEffects effects{clock};
  EffectMoment moment;

  PluginForce step() {
    ++moment.sample;
    moment.time_ns += 1'000'000;
    moment.p_WD.x() += 1e-4;
    return effects.step(moment);
  }
};

TEST_F(PluginEffectsTest, TheForcesOfAllAreAdded) {
  ASSERT_TRUE(effects.add(odd_effect("n=1")));
  ASSERT_TRUE(effects.add(odd_effect("n=0.5")));
  EXPECT_NEAR(step().force_n.x(), 1.5, 1e-12);
}

TEST_F(PluginEffectsTest, VelocityAndContactForceAreThoseOfTheHandInW) {
  ASSERT_TRUE(effects.add(odd_effect("does=copy")));
  moment.force_n = {0.1, -0.2, 0.3};
  for (int n = 0; n < 20; ++n) step();
  const PluginForce force = step();
  EXPECT_NEAR(force.force_n.x(), 0.01, 1e-9) << "0.1 m/s";
  EXPECT_NEAR(force.force_n.y(), 0.0, 1e-12);
  EXPECT_EQ(force.torque_nm, Vec3(0.01 * moment.force_n));
}

TEST_F(PluginEffectsTest, TimeBeginsAnewAtAReset) {
  ASSERT_TRUE(effects.add(odd_effect("does=lean")));
  moment.sample = static_cast<std::uint64_t>(-1);  // the step makes it 0
  moment.time_ns = 1'700'000'000'000;
  EXPECT_NEAR(step().force_n.x(), 0.001, 1e-12);
  moment.sample = static_cast<std::uint64_t>(-1);
  EXPECT_NEAR(step().force_n.x(), 0.002, 1e-12);
  effects.reset();
  moment.sample = 0;
  EXPECT_NEAR(step().force_n.x(), 1.001, 1e-12) << "and the sample is 1";
}

TEST_F(PluginEffectsTest, OneThatMisbehavesIsNamedOnceAndTheOthersGoOn) {
  ASSERT_TRUE(effects.add(odd_effect("does=strong,after=10")));
  ASSERT_TRUE(effects.add(odd_effect("n=0.25")));
  for (int n = 0; n < 10; ++n) step();
  EXPECT_FALSE(effects.has_notices());
  EXPECT_NEAR(step().force_n.x(), 1.24, 1e-12);
  EXPECT_TRUE(effects.has_notices());
  const auto notices = effects.take_notices();
  ASSERT_THAT(notices, SizeIs(1));
  EXPECT_THAT(notices[0], AllOf(HasSubstr("odd_one"), HasSubstr("odd_effect.so"), HasSubstr("1e+09 N, its limit is 2 N")));
  EXPECT_THAT(effects.take_notices(), IsEmpty());
  for (int n = 0; n < 100; ++n) step();
  EXPECT_NEAR(step().force_n.x(), 0.25, 1e-12);
  EXPECT_THAT(effects.describe(), HasSubstr("11 calls"));
  EXPECT_THAT(effects.describe(), HasSubstr("CUT OFF"));
}

TEST_F(PluginEffectsTest, EveryKindOfNonsenseCutsOff) {
  for (const char* does : {"nan", "torque_nan", "huge", "strong", "exception"}) {
    PluginEffects one(clock);
    ASSERT_TRUE(one.add(odd_effect(std::string("after=1,does=") + does)));
    EXPECT_EQ(one.step(moment).force_n.x(), 1.0);
    const PluginForce force = one.step(moment);
    EXPECT_TRUE(one.has_notices()) << does;
    EXPECT_NEAR(force.force_n.x(), 0.99, 1e-12) << does;
    EXPECT_TRUE(force.force_n.allFinite() && force.torque_nm.allFinite());
  }
}

// This test uses the machine's clock: a slow machine can only make a call that sleeps longer.
TEST_F(PluginEffectsTest, OneThatSleepsIsCutOffAfterTheSecondCall) {
  const SteadyClock steady;
  PluginEffects one(steady);
  ASSERT_TRUE(one.add(odd_effect("does=sleep,ms=15")));
  one.step(moment);
  EXPECT_FALSE(one.has_notices());
  one.step(moment);
  ASSERT_TRUE(one.has_notices());
  EXPECT_THAT(one.take_notices()[0], HasSubstr("it took too long too often"));
}

TEST_F(PluginEffectsTest, ItsOwnWordsOfRejectionAreOneLine) {
  const auto rejected = effects.add(odd_effect("does=reject,n=7"));
  ASSERT_FALSE(rejected);
  EXPECT_THAT(rejected.error().what, AllOf(HasSubstr("odd_one does not start: n must be less than 7"), HasSubstr("does=reject,n=7")));
  EXPECT_THAT(effects.add(odd_effect("does=silent")).error().what, HasSubstr("it does not say why"));
  EXPECT_THAT(effects.add(odd_effect("does=create_exception")).error().what, HasSubstr("threw a C++ exception in create"));
  EXPECT_TRUE(effects.empty());
}

TEST_F(PluginEffectsTest, TheTextOfARecordingNamesThemAndWhoWasCutOff) {
  EXPECT_EQ(effects.to_text(), "");
  ASSERT_TRUE(effects.add(odd_effect("n=1")));
  ASSERT_TRUE(effects.add(odd_effect("does=nan")));
  EXPECT_THAT(effects.to_text(), testing::MatchesRegex(" effects=odd_one@[0-9a-f]{16},odd_one@[0-9a-f]{16}"));
  step();
  EXPECT_THAT(effects.to_text(), testing::MatchesRegex(" effects=odd_one@[0-9a-f]{16},odd_one@[0-9a-f]{16}!cut"));
  ASSERT_TRUE(effects.add(odd_effect("n=2")));
  EXPECT_THAT(effects.add(odd_effect("n=3")).error().what, HasSubstr("at most 3"));
}

TEST_F(PluginEffectsTest, OurSideUsesNoHeapAndMakesNoSystemCall) {
  const auto work = [&] {
    for (int n = 0; n < 1000; ++n) step();
    effects.reset();
    for (int n = 0; n < 1000; ++n) step();
  };
  ASSERT_TRUE(effects.add(odd_effect("n=1")));
  ASSERT_TRUE(effects.add(odd_effect("does=strong,after=500")));
  if (SystemCallGuard::is_available()) {
    EXPECT_EQ(SystemCallGuard::run([] {}, work), "");
  }
  if (AllocationGuard::is_available()) {
    const AllocationGuard heap;
    work();
    EXPECT_EQ(heap.count(), 0U);
  }
}

}  // namespace
}  // namespace hapton
