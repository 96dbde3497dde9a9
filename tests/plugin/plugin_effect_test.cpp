#include "plugin/plugin_effect.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/standins/paths.h"

namespace hapton {
namespace {

TEST(PluginEffect, HasItsNameAndForgetsAtAReset) {
  SimulatedClock clock;
  const auto made = PluginEffect::make(*parse_plugin_choice(standin::library("plugins/odd_effect.so") + ":does=nan,after=2"), clock, 1000);
  ASSERT_TRUE(made) << made.error().what;
  PluginEffect& effect = **made;
  EXPECT_EQ(effect.name(), "odd_one");
  hapton_effect_input input = {};
  input.dt_s = 1e-3;
  for (int n = 0; n < 3; ++n) {
    effect.step(input);
    effect.step(input);
    EXPECT_FALSE(effect.guard().cut_off()) << n;
    effect.reset();
  }
  for (int n = 0; n < 3; ++n) effect.step(input);
  EXPECT_TRUE(effect.guard().cut_off());
  effect.reset();
  EXPECT_EQ(effect.step(input).force_n, Vec3(0, 0, 0));
}

// Functions that a plug-in may leave out are not called if it has none.
TEST(PluginEffect, ResetAndDestroyMayBeMissing) {
  SimulatedClock clock;
  auto made = PluginEffect::make(*parse_plugin_choice(standin::library("plugins/bare_effect.so") + ":n=0.5"), clock, 1000);
  ASSERT_TRUE(made) << made.error().what;
  hapton_effect_input input = {};
  input.dt_s = 1e-3;
  EXPECT_EQ((*made)->step(input).force_n, Vec3(0.5, 0, 0));
  (*made)->reset();
  EXPECT_FALSE((*made)->guard().cut_off());
  EXPECT_EQ((*made)->step(input).force_n, Vec3(0.5, 0, 0));
  made->reset();
}

// The stand-in aborts if it is destroyed without having been created.
TEST(PluginEffect, OneThatRejectsItsParametersIsNotDestroyedAndSaysWhyInOneLine) {
  SimulatedClock clock;
  const auto rejection = [&](const std::string& does) {
    const auto made = PluginEffect::make(*parse_plugin_choice(standin::library("plugins/odd_effect.so") + ":does=" + does), clock, 1000);
    return made ? "it was made" : made.error().what;
  };
  EXPECT_THAT(rejection("reject_lines"), testing::EndsWith("odd_one does not start: n is odd"));
  EXPECT_THAT(rejection("blank"), testing::EndsWith("odd_one does not start: it does not say why"));
  EXPECT_THAT(rejection("silent"), testing::EndsWith("odd_one does not start: it does not say why"));
}

TEST(PluginEffect, AnExceptionInResetCutsItOff) {
  SimulatedClock clock;
  const auto made =
      PluginEffect::make(*parse_plugin_choice(standin::library("plugins/odd_effect.so") + ":does=reset_exception"), clock, 1000);
  ASSERT_TRUE(made) << made.error().what;
  EXPECT_FALSE((*made)->guard().cut_off());
  (*made)->reset();
  EXPECT_EQ((*made)->guard().cut_off().reason, CutOff::Reason::exception);
}

// Each axis of force and torque is the one that the plug-in gives, from the same axis of velocity and contact force in its input.
TEST(PluginEffect, EachAxisIsItsOwn) {
  SimulatedClock clock;
  const auto made = PluginEffect::make(*parse_plugin_choice(standin::library("plugins/odd_effect.so") + ":does=copy,after=9"), clock, 1000);
  ASSERT_TRUE(made) << made.error().what;
  hapton_effect_input input = {};
  input.dt_s = 1e-3;
  for (int k = 0; k < 3; ++k) {
    input.velocity_m_per_s[k] = 1.0 + k;
    input.contact_force_n[k] = 4.0 + k;
  }
  const PluginForce given = (*made)->step(input);
  EXPECT_LT((given.force_n - Vec3(0.1, 0.2, 0.3)).norm(), 1e-12);
  EXPECT_LT((given.torque_nm - Vec3(0.04, 0.05, 0.06)).norm(), 1e-12);
}

}  // namespace
}  // namespace hapton
