#include "io_node/session_setup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace hapton {
namespace {

std::map<std::string, std::string> settings_of(const SessionHeader& header) { return {header.settings.begin(), header.settings.end()}; }

TEST(SessionSetup, TheHeaderHasTheOptionsThatAForceDependsOn) {
  IoOptions options;
  options.bind = "127.0.0.1:7";
  options.device.name = "replay";
  options.rate_hz = 4000.0;
  options.device.max_force_n = std::numeric_limits<double>::infinity();
  options.device.max_speed_m_per_s = 1.5;
  options.device.trajectory = "walk.csv";
  options.device.passive_mass_kg = 0.25;
  options.overrun = "stop";
  SimulatedClock clock;
  clock.advance_ns(77);
  const std::int64_t before_ns =
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  SessionHeader header = make_session_header(options, 0xABC, clock);
  EXPECT_EQ(header.start_ns, clock.now_ns());
  EXPECT_GE(header.start_unix_ns, before_ns);
  EXPECT_EQ(header.session, 0xABCU);
  EXPECT_FALSE(header.build.empty());
  std::map<std::string, std::string> settings = settings_of(header);
  EXPECT_EQ(settings["bind"], "127.0.0.1:7");
  EXPECT_EQ(settings["device"], "replay");
  EXPECT_EQ(settings["rate"], "4000");
  EXPECT_EQ(settings["max-force"], "the device's own");
  EXPECT_EQ(settings["max-speed"], "1.5");
  EXPECT_EQ(settings["passive-mass"], "0.25");
  EXPECT_EQ(settings["trajectory"], "walk.csv");
  EXPECT_EQ(settings["overrun"], "stop");
  for (const char* empty : {"name", "device-id", "device-file"}) EXPECT_FALSE(settings.contains(empty)) << empty;
  options.device.max_force_n = 3.5;
  options.name = "left";
  options.device.id = "123";
  options.device.file = "a.toml";
  header = make_session_header(options, 1, clock);
  settings = settings_of(header);
  EXPECT_EQ(settings["max-force"], "3.5");
  EXPECT_EQ(settings["name"], "left");
  EXPECT_EQ(settings["device-id"], "123");
  EXPECT_EQ(settings["device-file"], "a.toml");
}

// The folder is --flight, else a folder beside the report, else one in the user's state; each of several devices has its own in it.
TEST(SessionSetup, FindsTheFolderOfTheFlightRecords) {
  ::setenv("STATE_DIRECTORY", "/state", 1);
  IoOptions options;
  EXPECT_EQ(find_flight_folder(options), "/state/flight");
  options.name = "left";
  EXPECT_EQ(find_flight_folder(options), "/state/flight/left");
  options.out = "out";
  EXPECT_EQ(find_flight_folder(options), "out/flight");
  options.flight = "flights";
  EXPECT_EQ(find_flight_folder(options), "flights/left");
  options.name.clear();
  EXPECT_EQ(find_flight_folder(options), "flights");
  options.flight = "off";
  EXPECT_EQ(find_flight_folder(options), "");
  ::unsetenv("STATE_DIRECTORY");
}

TEST(SessionSetup, WithoutAFolderForStateThereAreNoFlightRecords) {
  std::map<std::string, std::string> before;
  for (const char* name : {"STATE_DIRECTORY", "XDG_STATE_HOME", "HOME"}) {
    if (const char* value = std::getenv(name)) before[name] = value;
    ::unsetenv(name);
  }
  IoOptions options;
  options.name = "left";
  EXPECT_EQ(find_flight_folder(options), "");
  for (const auto& [name, value] : before) ::setenv(name.c_str(), value.c_str(), 1);
}

// Either its driver does not use the heartbeat page, or the path or report of its HID device does not fit into the page.
TEST(SessionSetup, ADeviceThatTheWatchdogProcessCannotReleaseIsWarnedOf) {
  HeartbeatPage page;
  EXPECT_THAT(describe_missing_means(page, "my arm"), testing::HasSubstr("cannot release the force of this device (my arm)"));
  for (const CutMeans means : {CutMeans::kill, CutMeans::simulated, CutMeans::no_motors}) {
    page.set_means(means);
    EXPECT_EQ(describe_missing_means(page, "my arm"), "") << static_cast<int>(means);
  }
  page.set_hid("/dev/hidraw0", std::vector<std::uint8_t>{1});
  EXPECT_EQ(describe_missing_means(page, "my arm"), "");
  page.set_hid("/dev/" + std::string(HeartbeatPage::kMaxPath, 'h'), std::vector<std::uint8_t>{1});
  EXPECT_NE(describe_missing_means(page, "my arm"), "");
}

TEST(SessionSetup, ARecordingWithoutASampleIsWarnedOf) {
  IoOptions options;
  EXPECT_EQ(describe_lost_samples(options, 3), "") << "nothing was recorded";
  options.record = "day.hsn";
  EXPECT_EQ(describe_lost_samples(options, 0), "");
  EXPECT_THAT(describe_lost_samples(options, 1), testing::StartsWith("day.hsn: 1 samples are missing in the recording"));
  options.name = "left";
  EXPECT_THAT(describe_lost_samples(options, 20), testing::StartsWith("left: day.hsn: 20 samples are missing"));
}

}  // namespace
}  // namespace hapton
