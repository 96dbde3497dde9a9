#include "io_node/device_hub.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "link/link_key.h"
#include "link/udp_endpoint.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

struct DeviceHubs : testing::Test {
  void SetUp() override {
    ASSERT_TRUE(make_key_file(scratch.path() / "key"));
    options.key_file = (scratch.path() / "key").string();
    options.bind = "127.0.0.1:0";
    options.flight = "off";
    options.realtime.mode = RealtimeMode::off;
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

TEST_F(DeviceHubs, SayWhyTheyCannotBe) {
  const auto there = DeviceHub::open(options, clock);
  ASSERT_TRUE(there);
  options.bind = to_string((*there)->address());
  EXPECT_THAT(DeviceHub::open(options, clock).error().what, HasSubstr(options.bind));
  options.device.name = "replay";
  EXPECT_THAT(DeviceHub::open(options, clock).error().what, HasSubstr("--trajectory"));
}

}  // namespace
}  // namespace hapton
