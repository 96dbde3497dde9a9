#include "plugin/plugin_method.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/force/touch_step.h"
#include "core/math/rotation_vector.h"
#include "tests/standins/paths.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

PluginChoice floor_file(const std::string& parameters = "") {
  return *parse_plugin_choice(standin::library("plugins/odd_method.so") + (parameters.empty() ? "" : ":" + parameters));
}
TouchScene one_sheet() { return {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {.stiffness_n_per_m = 500.0}}}}; }

struct PluginMethodTest : testing::Test {
  SimulatedClock clock;
  std::unique_ptr<PluginMethod> make(const std::string& parameters = "") {
    auto made = PluginMethod::make(floor_file(parameters), one_sheet(), clock);
    EXPECT_TRUE(made) << made.error().what;
    return std::move(*made);
  }
};

TEST_F(PluginMethodTest, GivesForceProxyAndObjectWithTheMaterialsOfTheScene) {
  const auto method = make();
  method->reset({0, 0.01, 0});
  const MethodOutput free = method->step({.p_SD = {0.02, 0.001, 0.03}});
  EXPECT_FALSE(free.contact);
  EXPECT_EQ(free.p_SP, Vec3(0.02, 0.001, 0.03));
  const MethodOutput pressed = method->step({.p_SD = {0.02, -0.002, 0.03}});
  EXPECT_TRUE(pressed.contact);
  EXPECT_NEAR(pressed.force_n.y(), 1.0, 1e-12);
  EXPECT_EQ(pressed.p_SP, Vec3(0.02, 0, 0.03));
  EXPECT_EQ(pressed.object, 0);
  const Material softer{.stiffness_n_per_m = 100.0};
  method->set_materials({&softer, 1});
  EXPECT_NEAR(method->step({.p_SD = {0.02, -0.002, 0.03}}).force_n.y(), 0.2, 1e-12);
}

// The scene is turned by a quarter about y: x of S is -z of W.
TEST_F(PluginMethodTest, KnowsStylusVelocityTimeAndButtonsInTheFrameOfTheScene) {
  TouchStep touch(make("does=tell"));
  TouchInput input;
  input.X_WS.linear() = turn_by(Vec3(0, 0.5 * std::numbers::pi, 0)).toRotationMatrix();
  input.q_WT = turn_by(Vec3(0, 0, -0.5));  // its y axis leans to +x
  input.buttons = 5;
  touch.reset(input);
  TouchOutput output;
  for (int n = 0; n < 20; ++n) {
    input.p_WD = Vec3(0.01 + 2e-4 * n, 0.1, 0.0);
    output = touch.step(input);
  }
  const Vec3 v_W = output.force_n;  // in frame W again
  EXPECT_NEAR(v_W.x(), 0.2, 1e-9);
  EXPECT_NEAR(v_W.head<2>().norm(), 0.2, 1e-9);
  const Vec3 p_S = input.X_WS.inverse(Eigen::Isometry) * Vec3(input.p_WD + output.visual_offset_m);
  EXPECT_NEAR(p_S.x(), 0.019, 1e-9) << "time since the first sample";
  EXPECT_NEAR(p_S.y(), 5.0, 1e-9);
  // The y axis of the stylus is (sin 0.5, cos 0.5, 0) in W; x of S is -z of W, so this axis has no component along x of S.
  EXPECT_NEAR(p_S.z(), 0.0, 1e-9);
  input.X_WS = Pose::Identity();
  for (int n = 0; n < 20; ++n) output = touch.step(input);
  EXPECT_NEAR(input.p_WD.z() + output.visual_offset_m.z(), std::sin(0.5), 1e-9);
  EXPECT_NEAR(output.force_n.norm(), 0.0, 1e-9) << "the scene moved, the hand did not";
  touch.reset(input);
  output = touch.step(input);
  EXPECT_NEAR(input.p_WD.x() + output.visual_offset_m.x(), 0.0, 1e-12) << "time begins again";
}

TEST_F(PluginMethodTest, ASampleThatIsNotFiniteGivesNoForceAndReachesNoPlugin) {
  const auto method = make();
  const MethodOutput output = method->step({.p_SD = {0, std::nan(""), 0}});
  EXPECT_FALSE(output.contact);
  EXPECT_EQ(method->guard().times().count(), 0U);
}

// A contact that continues after a break has such a step. A plug-in may divide by the duration.
TEST_F(PluginMethodTest, AStepOfNoDurationReachesNoPlugin) {
  const auto method = make();
  method->step({.p_SD = {0.02, 0.001, 0.03}});
  const MethodOutput output = method->step({.p_SD = {0.02, -0.002, 0.03}, .dt_s = 0.0});
  EXPECT_FALSE(output.contact);
  EXPECT_EQ(output.force_n, Vec3::Zero());
  EXPECT_TRUE(method->step({.p_SD = {0.02, -0.002, 0.03}}).contact);
}

TEST_F(PluginMethodTest, NonsenseCutsItOffAndItsForceFades) {
  for (const char* does : {"nan", "nan_proxy", "exception"}) {
    const auto method = make(std::string("after=1,does=") + does);
    EXPECT_NEAR(method->step({.p_SD = {0, -0.002, 0}}).force_n.y(), 1.0, 1e-12);
    double last_n = 1.0;
    for (int n = 0; n < 110; ++n) {
      const MethodOutput output = method->step({.p_SD = {0, -0.002, 0}});
      EXPECT_LE(std::abs(output.force_n.norm() - last_n), 0.0101) << does;
      EXPECT_TRUE(output.p_SP.allFinite());
      EXPECT_EQ(output.contact, output.force_n.norm() > 0.0);
      last_n = output.force_n.norm();
    }
    EXPECT_EQ(last_n, 0.0);
    EXPECT_TRUE(method->guard().cut_off()) << does;
    EXPECT_THAT(method->notice(), AllOf(HasSubstr("method floor"), HasSubstr("is cut off"), HasSubstr("hapton set --method")));
    EXPECT_THAT(method->describe(), HasSubstr("CUT OFF"));
  }
}

// The stand-in aborts if it is called after it was cut off.
TEST_F(PluginMethodTest, WhatIsCutOffIsCalledNoMore) {
  const auto method = make("does=nan");
  method->step({.p_SD = {0, -0.002, 0}});
  ASSERT_TRUE(method->guard().cut_off());
  const Material softer{.stiffness_n_per_m = 100.0};
  method->set_materials({&softer, 1});
  method->reset({0, 0.01, 0});
  EXPECT_EQ(method->step({.p_SD = {0, -0.002, 0}}).force_n, Vec3::Zero());
}

TEST_F(PluginMethodTest, AnExceptionInResetOrWithMaterialsCutsItOff) {
  const auto throws_in_reset = make("does=reset_exception");
  throws_in_reset->reset({0, std::nan(""), 0});
  EXPECT_FALSE(throws_in_reset->guard().cut_off()) << "a position that is not finite is not passed on";
  throws_in_reset->reset({0, 0.01, 0});
  EXPECT_EQ(throws_in_reset->guard().cut_off().reason, CutOff::Reason::exception);
  const auto throws_in_set_materials = make("does=material_exception");
  throws_in_set_materials->reset({0, 0.01, 0});
  EXPECT_FALSE(throws_in_set_materials->guard().cut_off());
  const Material softer{.stiffness_n_per_m = 100.0};
  throws_in_set_materials->set_materials({&softer, 1});
  EXPECT_EQ(throws_in_set_materials->guard().cut_off().reason, CutOff::Reason::exception);
}

// Without set_materials the materials from its creation stay. Without destroy nothing is called at its end.
TEST_F(PluginMethodTest, MaterialsAndDestroyMayBeMissing) {
  auto made = PluginMethod::make({.file = standin::library("plugins/bare_method.so")}, one_sheet(), clock);
  ASSERT_TRUE(made) << made.error().what;
  const Material softer{.stiffness_n_per_m = 100.0};
  (*made)->set_materials({&softer, 1});
  EXPECT_FALSE((*made)->guard().cut_off());
  EXPECT_NEAR((*made)->step({.p_SD = {0, -0.002, 0}}).force_n.y(), 1.0, 1e-12);
  made->reset();
}

TEST_F(PluginMethodTest, AnObjectNumberOutOfRangeIsUnknown) {
  const auto method = make("does=odd_object");
  EXPECT_EQ(method->step({.p_SD = {0, -0.002, 0}}).object, -1);
}

TEST_F(PluginMethodTest, ItsNameHasTheHashAndItsRejectionIsOneLine) {
  EXPECT_THAT(make()->full_name(), testing::MatchesRegex("plugin:floor@[0-9a-f]{16}"));
  EXPECT_TRUE(is_plugin_method("plugin"));
  EXPECT_TRUE(is_plugin_method(make()->full_name()));
  EXPECT_FALSE(is_plugin_method("proxy"));
  EXPECT_THAT(PluginMethod::make(floor_file(), {}, clock).error().what, HasSubstr("it wants one object, not 0"));
  EXPECT_THAT(PluginMethod::make(floor_file("does=reject"), one_sheet(), clock).error().what, HasSubstr("floor does not start"));
  EXPECT_THAT(PluginMethod::make({.file = standin::library("plugins/odd_effect.so")}, one_sheet(), clock).error().what,
              HasSubstr("exports no hapton_method"));
}

TEST_F(PluginMethodTest, OurSideUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "allocations cannot be counted in this build";
  const auto method = make("after=2000,does=nan");
  const Material softer{.stiffness_n_per_m = 100.0};
  const AllocationGuard heap;
  for (int n = 0; n < 3000; ++n) {
    method->step({.p_SD = {0, 0.001 * std::sin(0.01 * n), 0}});
    if (n % 100 == 0) method->set_materials({&softer, 1});
    if (n % 500 == 0) method->reset({0, 0.01, 0});
  }
  EXPECT_EQ(heap.count(), 0U);
}

TEST(PluginMethods, AWordWithALibraryNamesAFile) {
  EXPECT_TRUE(names_plugin_file("a/b.so"));
  EXPECT_TRUE(names_plugin_file("b.so:n=1"));
  EXPECT_FALSE(names_plugin_file("proxy"));
}

}  // namespace
}  // namespace hapton
