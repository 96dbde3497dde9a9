#include "hid/space_mouse_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <memory>
#include <thread>
#include <utility>

#include "tests/support/fake_hid.h"
#include "tests/support/patience.h"

namespace hapton {
namespace {

const FakeHid::Bytes kPushed = {1, 0x5e, 0x01, 0, 0, 0, 0};  // x: 350

TEST(SpaceMouseReader, ReportsTheCapUntilItIsUnpluggedAndAgainAfterwards) {
  FakeHid hid;
  SpaceMouseReader reader(hid.opener());
  ASSERT_TRUE(reader.open());
  SteadyClock clock;
  EXPECT_TRUE(reader.state(clock.now_ns()).is_at_rest());
  EXPECT_TRUE(reader.is_there());
  const auto is_pushed = [&] {
    if (hid.is_drained()) hid.send(kPushed);
    return reader.state(clock.now_ns()).push.x() == 1.0;
  };
  EXPECT_TRUE(wait_until(is_pushed));
  hid.unplug();
  EXPECT_TRUE(wait_until([&] { return reader.state(clock.now_ns()).is_at_rest() && !reader.is_there(); }));
  hid.plug_in();
  EXPECT_TRUE(wait_until(is_pushed));
  EXPECT_TRUE(reader.is_there());
}

// A device all of whose reports are there before the first read.
class PrefilledHid final : public HidTransport {
 public:
  explicit PrefilledHid(std::deque<FakeHid::Bytes> reports) : reports_(std::move(reports)) {
    description_.path = "/dev/hidraw3";
    description_.product = "SpaceNavigator";
  }
  const HidDescription& description() const noexcept override { return description_; }
  HidRead read(std::span<std::uint8_t> into, int wait_ms) noexcept override {
    if (reports_.empty()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
      return {};
    }
    const FakeHid::Bytes report = reports_.front();
    reports_.pop_front();
    std::copy(report.begin(), report.end(), into.begin());
    return {HidIo::done, report.size()};
  }
  bool write(std::span<const std::uint8_t>) noexcept override { return false; }
  Result<std::size_t> get_feature(std::span<std::uint8_t>) override { return fail("it has none"); }

 private:
  HidDescription description_;
  std::deque<FakeHid::Bytes> reports_;
};

TEST(SpaceMouseReader, AReportWithoutStateHidesNoReportBeforeIt) {
  const FakeHid::Bytes buttons = {3, 5}, battery = {0x17, 99};
  SpaceMouseReader reader([&]() -> Result<std::unique_ptr<HidTransport>> {
    return std::make_unique<PrefilledHid>(std::deque<FakeHid::Bytes>{buttons, battery});
  });
  ASSERT_TRUE(reader.open());
  EXPECT_TRUE(wait_until([&] { return reader.state(SteadyClock().now_ns()).buttons == 5U; }));
  EXPECT_EQ(reader.description().product, "SpaceNavigator");
}

TEST(SpaceMouseReader, WithoutADeviceSaysWhy) {
  FakeHid hid;
  hid.unplug();
  SpaceMouseReader reader(hid.opener());
  EXPECT_EQ(reader.open().error().what, "the fake device is not plugged in");
}

}  // namespace
}  // namespace hapton
