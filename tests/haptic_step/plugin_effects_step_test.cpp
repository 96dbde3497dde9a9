// Effects from shared libraries in the step of the haptics node.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "haptic_step/haptics_step.h"
#include "haptic_step/method_text.h"
#include "plugin/plugin_effects.h"
#include "tests/standins/paths.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TouchScene one_sheet() { return {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {}}}}; }
std::unique_ptr<TouchStep> sheet_touch(const char* method) {
  return std::make_unique<TouchStep>(*make_method({.name = method}, one_sheet()));
}

struct PluginEffectsStep : testing::Test {
  SimulatedClock clock;
  PluginEffects effects{clock};
  HapticsStep step{sheet_touch("proxy"), MethodSettings().offset_m};
  DeviceState state;

  void use(const std::string& parameters) {
    ASSERT_TRUE(effects.add(*parse_plugin_choice(standin::library("plugins/odd_effect.so") + ":" + parameters)));
    step.use_effects(&effects);
  }
  ForceCommand reply_at(const Vec3& p_WD) {
    ++state.sample;
    state.sample_time_ns += 1'000'000;
    state.p_WD = p_WD;
    step.offer(state);
    return step.reply();
  }
};

TEST_F(PluginEffectsStep, TheirForceIsAddedInFreeSpaceAndInContact) {
  use("n=1");
  EXPECT_TRUE(step.has_effects());
  const ForceCommand free = reply_at({0.01, 0.01, 0.002});
  EXPECT_EQ(free.force_n, Vec3(1, 0, 0));
  EXPECT_TRUE(free.contact) << "an effect acts";
  EXPECT_EQ(free.visual_offset_m, Vec3(0, 0, 0));
  const ForceCommand pressed = reply_at({0.01, 0.01, -0.002});
  EXPECT_NEAR(pressed.force_n.x(), 1.0, 1e-9);
  EXPECT_NEAR(pressed.force_n.z(), 2.0, 1e-6);
}

TEST_F(PluginEffectsStep, TheySeeTheContactOfTheMethod) {
  use("does=copy");
  reply_at({0.01, 0.01, 0.002});
  const ForceCommand pressed = reply_at({0.01, 0.01, -0.002});
  EXPECT_NEAR(pressed.torque_nm.z(), 0.02, 1e-6) << "the stand-in gives a hundredth of the contact force back as a torque";
}

// The force of the method fades as usual; the force of the effect neither jumps nor fades.
TEST_F(PluginEffectsStep, AChangeOfMethodLeavesThemAsTheyAre) {
  use("n=1");
  reply_at({0.01, 0.01, 0.002});
  reply_at({0.01, 0.01, -0.002});
  const Vec3 before = reply_at({0.01, 0.01, -0.002}).force_n;
  step.replace(sheet_touch("sweep"));
  for (int n = 0; n < 150; ++n) {
    const Vec3 after = reply_at({0.01, 0.01, -0.002}).force_n;
    EXPECT_NEAR(after.x(), 1.0, 1e-9);
    EXPECT_NEAR(after.z(), before.z(), 1e-3);
  }
  const Material softer{.stiffness_n_per_m = 500.0};
  step.set_materials({&softer, 1});
  for (int n = 0; n < 150; ++n) EXPECT_NEAR(reply_at({0.01, 0.01, -0.002}).force_n.x(), 1.0, 1e-9);
}

TEST_F(PluginEffectsStep, ANewSessionResetsThem) {
  use("does=nan,after=5");
  for (int n = 0; n < 20; ++n) {
    if (n % 5 == 0) step.restart();
    EXPECT_EQ(reply_at({0.01, 0.01, 0.002}).force_n, Vec3(1, 0, 0)) << n;
  }
}

TEST(MethodText, EffectsAreReadFromTheTextAndAreNoSettings) {
  const std::string text = to_text({.name = "proxy", .probe_radius_m = 0.001});
  const std::string text_with_effects = text + " effects=magnet@0123456789abcdef,wind@0!cut cut=method";
  EXPECT_EQ(effects_in(text_with_effects), "magnet@0123456789abcdef,wind@0!cut");
  EXPECT_EQ(effects_in(text), "");
  ASSERT_TRUE(parse_method_text(text_with_effects));
  EXPECT_EQ(parse_method_text(text_with_effects)->probe_radius_m, 0.001);
}

}  // namespace
}  // namespace hapton
