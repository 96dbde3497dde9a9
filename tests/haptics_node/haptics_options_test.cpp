#include "haptics_node/haptics_options.h"

#include <gtest/gtest.h>

#include <vector>

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

}  // namespace
}  // namespace hapton
