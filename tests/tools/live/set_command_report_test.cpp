// What `hapton set` prints about the faults of the hub that it contacts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/command_run.h"
#include "tests/tools/reporting_hub.h"

namespace hapton {
namespace {

CommandRun reset_faults(const std::string& report) {
  const ReportingHub hub([&](int) { return HubReport{report, "hop,lower_ns,upper_ns,count\n"}; });
  return run_hapton({"set", "--reset-faults", "--hub", hub.address(), "--key", hub.key_file()});
}

TEST(SetCommand, SaysThatNoFaultIsLatched) {
  const CommandRun run = reset_faults(R"({"notes": {"safety_fault": "none"}})");
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, testing::HasSubstr("no fault is latched"));
}

TEST(SetCommand, AReportWithOtherTypesIsRejectedInOneLine) {
  for (const char* wrong : {R"({"notes": {"safety_fault": 1}})", R"({"notes": 1})", R"([])"}) {
    const CommandRun run = reset_faults(wrong);
    EXPECT_EQ(run.code, 1) << wrong;
    EXPECT_EQ(run.err, "hapton set: the hub does not report faults; it is another version of Hapton\n") << wrong;
  }
}

constexpr const char* kLatched = R"({"notes": {"safety_fault": "speed", "safety_fault_text": "the device moved too fast"}})";

// A script that resets faults must not go on as if forces came back.
TEST(SetCommand, AFaultThatRemainsIsAnErrorThatNamesIt) {
  const CommandRun run = reset_faults(kLatched);
  EXPECT_EQ(run.code, 1);
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(
      run.err,
      "hapton set: the fault remains, as its cause persists: the device moved too fast; fix that (docs/safety.md), then reset again\n");
  EXPECT_THAT(reset_faults(R"({"notes": {"safety_fault": "speed"}})").err, testing::HasSubstr("persists: speed; fix that"))
      << "of a hub that has no text for it";
}

// The hub processes the request in its next cycle, and a report may be older than that.
TEST(SetCommand, AFaultThatIsResetInTheThirdReportIsReset) {
  const ReportingHub hub([&](int number) {
    return HubReport{number < 3 ? kLatched : R"({"notes": {"safety_fault": "none"}})", "hop,lower_ns,upper_ns,count\n"};
  });
  const CommandRun run = run_hapton({"set", "--reset-faults", "--hub", hub.address(), "--key", hub.key_file()});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, testing::HasSubstr("no fault is latched; forces ramp up"));
}

}  // namespace
}  // namespace hapton
