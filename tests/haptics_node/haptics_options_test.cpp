#include "haptics_node/haptics_options.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/option_range.h"

namespace hapton {
namespace {

std::variant<HapticsOptions, int> parse_haptics(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), {"haptics_node", "--scene", "a.toml"});
  return parse_haptics_options(static_cast<int>(arguments.size()), arguments.data());
}

TEST(HapticsOptions, AnyCpuMayBePinnedToAndNoneIsTheDefault) {
  EXPECT_EQ(std::get<HapticsOptions>(parse_haptics({})).realtime.cpu, -1);
  for (const auto& [given, cpu] : {std::pair{"-1", -1}, {"0", 0}, {"1023", 1023}}) {
    EXPECT_EQ(std::get<HapticsOptions>(parse_haptics({"--cpu", given})).realtime.cpu, cpu);
  }
  EXPECT_NE(std::get<int>(parse_haptics({"--cpu", "-2"})), 0);
}

TEST(HapticsOptions, APluginsBudgetIsInMicroseconds) {
  HapticsOptions options;
  EXPECT_EQ(options.plugin_budget_ns(), CallBudget::kDefaultNs);
  options.plugin_budget_us = 250.0;
  EXPECT_EQ(options.plugin_budget_ns(), 250'000);
}

TEST(HapticsOptions, NumbersHaveTheRangesThatHelpNames) {
  const OptionRange<HapticsOptions> ranges[] = {
      {"--plugin-budget", "1", "1e4", "0.9", "10001", [](const HapticsOptions& o) { return static_cast<double>(o.plugin_budget_us); }},
      {"--crease", "0", "180", "-0.1", "180.1", [](const HapticsOptions& o) { return static_cast<double>(o.method.crease_deg); }},
      {"--coupling", "0", "1e6", "-0.1", "1.1e6", [](const HapticsOptions& o) { return static_cast<double>(o.method.coupling_n_per_m); }},
      {"--shading", "0", "1", "-0.1", "1.1", [](const HapticsOptions& o) { return static_cast<double>(o.method.shading); }},
      {"--rotational-stiffness", "0", "1e6", "-0.1", "1.1e6",
       [](const HapticsOptions& o) { return static_cast<double>(o.tool_nm_per_rad); }},
      {"--grasp-button", "1", "32", "0", "33", [](const HapticsOptions& o) { return static_cast<double>(o.grasp_button); }},
      {"--rt-priority", "0", "99", "-1", "100", [](const HapticsOptions& o) { return static_cast<double>(o.realtime.priority); }},
      {"--cpu", "-1", "1023", "-2", "1024", [](const HapticsOptions& o) { return static_cast<double>(o.realtime.cpu); }},
      {"--spin", "0", "1000", "-0.1", "1001", [](const HapticsOptions& o) { return static_cast<double>(o.spin_us); }},
      {"--patch-bandwidth", "0.01", "1000", "0", "1001", [](const HapticsOptions& o) { return static_cast<double>(o.patch_mbit_per_s); }},
      {"--seconds", "0", "1e9", "-0.1", "1.1e9", [](const HapticsOptions& o) { return static_cast<double>(o.seconds); }},
  };
  for (const auto& range : ranges) expect_range(range, parse_haptics);
}

TEST(HapticsOptions, UnitsAndWordsAreParsed) {
  const auto options = std::get<HapticsOptions>(parse_haptics(
      {"--offset-in",    "0.5",   "--simplify", "0.2mm", "--grid",          "7",      "--unit", "mm",          "--no-seal", "--no-fit",
       "--probe-radius", "0.003", "--rt",       "off",   "--build-at-once", "--tool", "t.obj",  "--tool-unit", "in",        "--tool-grip",
       "centre"}));
  EXPECT_DOUBLE_EQ(options.method.offset_m, 0.0127);
  EXPECT_DOUBLE_EQ(options.method.simplify_m, 0.0002);
  EXPECT_EQ(options.method.probe_radius_m, 0.003);
  EXPECT_FALSE(options.method.build_on_approach);
  EXPECT_EQ(options.realtime.mode, RealtimeMode::off);
  EXPECT_EQ(options.loading.sealing, CrackSealing::off);
  EXPECT_EQ(options.loading.fit, MeshFit::off);
  const auto defaults = std::get<HapticsOptions>(parse_haptics({}));
  EXPECT_DOUBLE_EQ(defaults.method.offset_m, HapticsOptions().method.offset_m);
  EXPECT_TRUE(defaults.method.build_on_approach);
  EXPECT_NE(defaults.loading.sealing, CrackSealing::off);
  EXPECT_NE(defaults.loading.fit, MeshFit::off);
  EXPECT_FALSE(defaults.watch_scene);
  EXPECT_NE(std::get<int>(parse_haptics({"--offset-in", "0"})), 0);
  EXPECT_NE(std::get<int>(parse_haptics({"--probe-radius", "-0.001"})), 0);
  EXPECT_NE(std::get<int>(parse_haptics({"--tool-unit", "in"})), 0) << "without a tool";
}

}  // namespace
}  // namespace hapton
