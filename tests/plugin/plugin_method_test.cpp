#include "plugin/plugin_method.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

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

TEST_F(PluginMethodTest, ASampleThatIsNotFiniteGivesNoForceAndReachesNoPlugin) {
  const auto method = make();
  const MethodOutput output = method->step({.p_SD = {0, std::nan(""), 0}});
  EXPECT_FALSE(output.contact);
  EXPECT_EQ(method->guard().times().count(), 0U);
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

TEST_F(PluginMethodTest, AnObjectThatIsNoneIsUnknown) {
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

}  // namespace
}  // namespace hapton
