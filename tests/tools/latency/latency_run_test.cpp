#include "tools/latency/latency_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <signal.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "runtime/report.h"
#include "tests/support/one_line.h"
#include "tests/support/scratch_folder.h"
#include "tests/tools/reporting_hub.h"
#include "tools/latency/latency_compare.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kForever = 1e6;  // s: a test that waits for so long fails by its time limit

// The report of a hub that has run for `seconds` at 1 kHz.
HubReport report_after(double seconds) {
  const int samples = static_cast<int>(1e3 * seconds);
  const nlohmann::ordered_json json = {{"schema", kReportSchema},
                                       {"seconds", seconds},
                                       {"rates_hz", {{"servo_requested", 1000.0}}},
                                       {"counters", {{"samples", samples}, {"forces", samples}}},
                                       {"notes", {{"device", "simulated"}}}};
  return {json.dump(), "hop,lower_ns,upper_ns,count\nround_trip,10000,11000," + std::to_string(samples) + "\n"};
}

Result<LatencyRun> watch_hub(const ReportingHub& hub, double seconds, const ScratchFolder& folder) {
  LatencyRunOptions options;
  options.seconds = seconds;
  options.out = folder.path() / "run";
  options.hosts = hub.address();
  options.key_file = hub.key_file();
  return run_latency(options);
}

TEST(LatencyRunOfAHub, AnInterruptEndsItWithTheReportSoFar) {
  const ScratchFolder folder;
  bool is_interrupted = false;
  const ReportingHub hub([](int number) { return report_after(10.0 * number); },
                         [&] {
                           if (!std::exchange(is_interrupted, true)) ::kill(::getpid(), SIGINT);
                           return true;
                         });
  const auto run = watch_hub(hub, kForever, folder);
  ASSERT_TRUE(run) << run.error().what;
  EXPECT_THAT(run->text, HasSubstr("verdict at 1 kHz: held"));
  const auto report = read_report_json(folder.path() / "run");
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_GT((*report)["counters"]["samples"].get<int>(), 0);
}

TEST(LatencyRunOfAHub, AHubThatIsGoneIsNamed) {
  const ScratchFolder folder;
  const ReportingHub hub([](int number) { return report_after(10.0 * number); }, [] { return false; });
  const auto run = watch_hub(hub, kForever, folder);
  ASSERT_FALSE(run);
  EXPECT_THAT(run.error().what, HasSubstr(hub.address() + " does not reply any more"));
}

TEST(LatencyRunOfAHub, AHubThatWasStartedAgainIsNamed) {
  const ScratchFolder folder;
  const ReportingHub hub([](int number) { return report_after(100.0 - number); });
  const auto run = watch_hub(hub, 0.1, folder);
  ASSERT_FALSE(run);
  EXPECT_THAT(run.error().what, HasSubstr("was started again meanwhile"));
}

TEST(LatencyRunOfAHub, AReportWithOtherTypesIsRejectedInOneLine) {
  for (const char* wrong : {R"({"notes": 7})", R"({"rates_hz": [1]})", R"({"seconds": "long"})"}) {
    const ScratchFolder folder;
    const ReportingHub hub([&](int) { return HubReport{wrong, "hop,lower_ns,upper_ns,count\nround_trip,1,2,3\n"}; });
    const auto run = watch_hub(hub, 0.1, folder);
    ASSERT_FALSE(run) << wrong;
    EXPECT_THAT(run.error().what, AllOf(HasSubstr("a report that cannot be read; it is another version of Hapton"), IsOneLine())) << wrong;
  }
}

}  // namespace
}  // namespace hapton
