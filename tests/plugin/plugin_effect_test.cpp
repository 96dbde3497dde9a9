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

}  // namespace
}  // namespace hapton
