#include "io_node/device_hub.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

#include "link/link_key.h"
#include "link/udp_endpoint.h"
#include "runtime/log.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

struct DeviceHubs : testing::Test {
  void SetUp() override {
    ASSERT_TRUE(make_key_file(scratch.path() / "key"));
    options.key_file = (scratch.path() / "key").string();
    options.bind = "127.0.0.1:0";
    options.flight = "off";
    options.realtime.mode = RealtimeMode::off;
  }

  static std::string read(const std::string& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }

  ScratchFolder scratch;
  SteadyClock clock;
  IoOptions options;
};

TEST_F(DeviceHubs, RunSideBySideInOneProcess) {
  options.name = "left";
  const auto left = DeviceHub::open(options, clock);
  options.name = "right";
  const auto right = DeviceHub::open(options, clock);
  ASSERT_TRUE(left && right);
  EXPECT_THAT((*left)->describe(), StartsWith("left: hub on 127.0.0.1:"));
  EXPECT_NE((*left)->address().port, (*right)->address().port);
}

TEST_F(DeviceHubs, RunAndReport) {
  options.seconds = 0.05;
  options.out = (scratch.path() / "out").string();
  const StopSignal stop;
  const auto hub = DeviceHub::open(options, clock);
  ASSERT_TRUE(hub) << hub.error().what;
  EXPECT_THAT((*hub)->describe(), StartsWith("hub on 127.0.0.1:"));
  EXPECT_TRUE((*hub)->run(stop));
  EXPECT_TRUE(std::filesystem::exists(scratch.path() / "out/report.json"));
}

TEST_F(DeviceHubs, SayWhyTheyCannotBeOpened) {
  const auto first = DeviceHub::open(options, clock);
  ASSERT_TRUE(first);
  options.bind = to_string((*first)->address());
  EXPECT_THAT(DeviceHub::open(options, clock).error().what, HasSubstr(options.bind));
  options.device.name = "replay";
  EXPECT_THAT(DeviceHub::open(options, clock).error().what, HasSubstr("--trajectory"));
}

TEST_F(DeviceHubs, DescribeWhatTheyRun) {
  options.rate_hz = 2000.0;
  options.device.seed = 42;
  options.device.max_force_n = 1.5;
  const auto hub = DeviceHub::open(options, clock);
  ASSERT_TRUE(hub);
  EXPECT_THAT((*hub)->describe(), HasSubstr("2000 Hz, at most 1.50 N, seed 42"));
}

// Limits can only be tightened; the log warns where a larger limit than the device's own is requested.
TEST_F(DeviceHubs, WarnOfALimitAboveTheDevicesOwn) {
  const auto log_of = [&](double max_force_n, double max_slew_n_per_s) {
    options.device.max_force_n = max_force_n;
    options.device.max_slew_n_per_s = max_slew_n_per_s;
    testing::internal::CaptureStderr();
    start_log("io_node");
    EXPECT_TRUE(DeviceHub::open(options, clock));
    return testing::internal::GetCapturedStderr();
  };
  constexpr char kWarning[] = "limits can only be tightened: the device's own apply";
  EXPECT_THAT(log_of(1e3, 0.0), HasSubstr(kWarning));
  EXPECT_THAT(log_of(0.5, 1e9), HasSubstr(kWarning));
  EXPECT_THAT(log_of(0.5, 1.0), Not(HasSubstr(kWarning)));
  EXPECT_THAT(log_of(std::numeric_limits<double>::infinity(), 0.0), Not(HasSubstr(kWarning)));
}

TEST_F(DeviceHubs, ServeMetricsOnlyWhereAnAddressIsGiven) {
  const auto log_of = [&](const std::string& metrics) {
    options.metrics = metrics;
    testing::internal::CaptureStderr();
    start_log("io_node");
    EXPECT_TRUE(DeviceHub::open(options, clock));
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_THAT(log_of(""), Not(HasSubstr("metrics")));
  EXPECT_THAT(log_of("127.0.0.1:0"), HasSubstr("metrics at http://127.0.0.1:"));
  options.metrics = "9464";  // it is not clear whether this is a port or an address
  EXPECT_FALSE(DeviceHub::open(options, clock));
}

TEST_F(DeviceHubs, MeasureABareEchoOnlyWhereOneIsNamed) {
  const auto report_of = [&](const std::string& responder) {
    options.seconds = 0.05;
    options.echo_probe = responder;
    options.out = (scratch.path() / ("echo" + std::to_string(responder.size()))).string();
    const StopSignal stop;
    const auto hub = DeviceHub::open(options, clock);
    EXPECT_TRUE(hub && (*hub)->run(stop));
    return read(options.out + "/report.json");
  };
  EXPECT_THAT(report_of(""), Not(HasSubstr("\"echo_probe\"")));
  const auto responder = open_udp_endpoint("127.0.0.1:0");
  ASSERT_TRUE(responder);
  EXPECT_THAT(report_of(to_string((*responder)->local_address())), HasSubstr("\"echo_probe\""));
  options.echo_probe = "4950";
  EXPECT_FALSE(DeviceHub::open(options, clock));
}

TEST_F(DeviceHubs, RecordTheSessionAndPrintHowMuch) {
  options.seconds = 0.05;
  options.record = (scratch.path() / "session.hapton").string();
  const StopSignal stop;
  const auto hub = DeviceHub::open(options, clock);
  ASSERT_TRUE(hub);
  testing::internal::CaptureStdout();
  EXPECT_TRUE((*hub)->run(stop));
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("0 dropped: " + options.record));
  EXPECT_GT(std::filesystem::file_size(options.record), 1000U);
}

TEST_F(DeviceHubs, PrintNothingOfRecordingsWhereThereAreNone) {
  options.seconds = 0.05;
  const StopSignal stop;
  const auto hub = DeviceHub::open(options, clock);
  ASSERT_TRUE(hub);
  testing::internal::CaptureStdout();
  EXPECT_TRUE((*hub)->run(stop));
  const std::string out = testing::internal::GetCapturedStdout();
  EXPECT_THAT(out, Not(HasSubstr("recorded")));
  EXPECT_THAT(out, Not(HasSubstr("flight")));
}

}  // namespace
}  // namespace hapton
