#include "tools/relay/relay_script.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hapton {
namespace {

using ::testing::HasSubstr;

TEST(RelayScriptTest, ReadsPhasesWithBothWaysAndOneWay) {
  const auto script = parse_relay_script(
      "seed = 42\nrepeat = true\n"
      "[[phase]]\nname = \"storm\"\nseconds = 2\nloss = 0.3\njitter_ms = 20\nto_nodes = { loss = 0.1, corrupt = 0.01 }\n"
      "[[phase]]\nseconds = 0.5\npartition = true\n",
      "s.toml");
  ASSERT_TRUE(script) << script.error().what;
  EXPECT_EQ(script->seed, 42U);
  EXPECT_TRUE(script->schedule.repeat);
  ASSERT_EQ(script->schedule.phases.size(), 2U);
  const FaultPhase& storm = script->schedule.phases[0];
  EXPECT_EQ(storm.name, "storm");
  EXPECT_EQ(storm.duration_ns, 2'000'000'000);
  EXPECT_EQ(storm.to_hub.loss, 0.3);
  EXPECT_EQ(storm.to_hub.jitter_ns, 20'000'000);
  EXPECT_EQ(storm.to_hub.corrupt, 0.0);
  EXPECT_EQ(storm.to_nodes.loss, 0.1);
  EXPECT_EQ(storm.to_nodes.jitter_ns, 20'000'000);
  EXPECT_EQ(storm.to_nodes.corrupt, 0.01);
  EXPECT_EQ(script->schedule.phases[1].name, "2");
  EXPECT_TRUE(script->schedule.phases[1].to_hub.partition);
  EXPECT_TRUE(script->schedule.phases[1].to_nodes.partition);
}

struct BadScript {
  const char* text;
  const char* complaint;
};

TEST(RelayScriptTest, SaysWhatIsWrongAndWhere) {
  const BadScript scripts[] = {
      {"", "no [[phase]]"},
      {"[[phase]\n", "s.toml:1"},
      {"[[phase]]\nloss = 0.1\n", "needs seconds"},
      {"[[phase]]\nseconds = 1\nlos = 0.1\n", "s.toml:3: unknown key 'los'; did you mean 'loss'?"},
      {"[[phase]]\nseconds = 1\nloss = 1.5\n", "loss is 1.5"},
      {"[[phase]]\nseconds = 1\nloss = \"much\"\n", "'loss' must be a number"},
      {"[[phase]]\nseconds = 1\nloss = nan\n", "'loss' must be a number"},
      {"[[phase]]\nseconds = 1\ndelay_ms = -3\n", "delay is -1 ms"},
      {"[[phase]]\nseconds = -1\n", "needs seconds"},
      {"[[phase]]\nseconds = 1e300\n", "needs seconds"},
      {"[[phase]]\nseconds = 1\npartition = 1\n", "'partition' must be true or false"},
      {"[[phase]]\nseconds = 1\nto_hub = 3\n", "'to_hub' must be a table"},
      {"[[phase]]\nseconds = 1\nto_hub = { seconds = 1 }\n", "unknown key 'seconds'"},
      {"seed = -1\n[[phase]]\nseconds = 1\n", "'seed' must be a whole number"},
      {"phase = [1]\n", "a phase is a table"},
      {"frobnicate = 1\n[[phase]]\nseconds = 1\n", "unknown key 'frobnicate'"},
  };
  for (const BadScript& bad : scripts) {
    const auto script = parse_relay_script(bad.text, "s.toml");
    ASSERT_FALSE(script) << bad.text;
    EXPECT_THAT(script.error().what, HasSubstr(bad.complaint));
    EXPECT_THAT(script.error().what, HasSubstr("s.toml"));
    EXPECT_EQ(script.error().what.find('\n'), std::string::npos);
  }
  EXPECT_THAT(read_relay_script("/nowhere/s.toml").error().what, HasSubstr("/nowhere/s.toml"));
}

TEST(RelayScriptTest, EachFaultIsThatOfItsKey) {
  const auto script = parse_relay_script(
      "[[phase]]\nseconds = 1\ndelay_ms = 1\njitter_ms = 2\nloss = 0.03\nburst_share = 0.04\nburst_length = 5\nburst_loss = 0.06\n"
      "reorder = 0.07\nreorder_ms = 8\nduplicate = 0.09\ncorrupt = 0.1\nto_hub = { partition = true }\n",
      "s.toml");
  ASSERT_TRUE(script) << script.error().what;
  const FaultPhase& phase = script->schedule.phases.at(0);
  for (const LinkFaults* faults : {&phase.to_hub, &phase.to_nodes}) {
    EXPECT_EQ(faults->delay_ns, 1'000'000);
    EXPECT_EQ(faults->jitter_ns, 2'000'000);
    EXPECT_EQ(faults->loss, 0.03);
    EXPECT_EQ(faults->burst_share, 0.04);
    EXPECT_EQ(faults->burst_length, 5.0);
    EXPECT_EQ(faults->burst_loss, 0.06);
    EXPECT_EQ(faults->reorder, 0.07);
    EXPECT_EQ(faults->reorder_by_ns, 8'000'000);
    EXPECT_EQ(faults->duplicate, 0.09);
    EXPECT_EQ(faults->corrupt, 0.1);
    EXPECT_EQ(faults->partition, faults == &phase.to_hub);
  }
}

}  // namespace
}  // namespace hapton
