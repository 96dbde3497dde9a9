#include "hid/hid_port.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>

#include "runtime/log.h"
#include "tests/support/fake_hid.h"
#include "tests/support/patience.h"

namespace hapton {
namespace {

struct Listener final : HidListener {
  Result<void> on_opened(HidTransport&) override {
    ++opened_count;
    if (is_unusable) return fail("not this one");
    return {};
  }
  void on_report(std::span<const std::uint8_t> report, std::int64_t) noexcept override {
    newest = report.empty() ? 0 : report[0];
    ++report_count;
  }
  void on_drained(std::int64_t) noexcept override { ++drained_count; }
  void on_gone() noexcept override { ++gone_count; }

  std::atomic<bool> is_unusable = false;
  std::atomic<int> opened_count = 0, report_count = 0, drained_count = 0, gone_count = 0, newest = -1;
};

TEST(HidPort, WhatIsNotThereIsAnErrorInOneLine) {
  FakeHid hid;
  hid.unplug();
  Listener listener;
  HidPort port(hid.opener(), listener, "fake");
  const auto opened = port.open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().what, "the fake device is not plugged in");
}

TEST(HidPort, BringsEveryReportInOrderAndThenSaysThatThereAreNoMore) {
  FakeHid hid;
  Listener listener;
  HidPort port(hid.opener(), listener, "fake");
  ASSERT_TRUE(port.open());
  for (std::uint8_t n = 1; n <= 50; ++n) ASSERT_TRUE(hid.send({n}));
  EXPECT_TRUE(wait_until([&] { return listener.report_count == 50; }));
  EXPECT_EQ(listener.newest, 50);
  const int drained = listener.drained_count;
  EXPECT_TRUE(wait_until([&] { return listener.drained_count > drained; }));
}

TEST(HidPort, ADeviceThatFloodsIsStillDrainedNowAndThen) {
  FakeHid hid;
  Listener listener;
  HidPort port(hid.opener(), listener, "fake");
  ASSERT_TRUE(port.open());
  std::atomic<bool> ends = false;
  std::thread flood([&] {
    while (!ends) hid.send({1});
  });
  EXPECT_TRUE(wait_until([&] { return listener.report_count > 2000 && listener.drained_count > 3; }));
  ends = true;
  flood.join();
}

// Each report is one byte more than the one before, and the next one is always there.
struct EndlessTransport final : HidTransport {
  const HidDescription& description() const noexcept override { return described; }
  HidRead read(std::span<std::uint8_t> into, int) noexcept override {
    into[0] = ++newest;
    return {HidIo::done, 1};
  }
  bool write(std::span<const std::uint8_t>) noexcept override { return true; }
  Result<std::size_t> get_feature(std::span<std::uint8_t>) override { return fail("no such feature report"); }

  HidDescription described;
  std::uint8_t newest = 0;
};

TEST(HidPort, BringsEveryReportOfADeviceThatFloodsAndPausesAfterTheSameNumber) {
  struct Counter final : HidListener {
    Result<void> on_opened(HidTransport&) override { return {}; }
    void on_report(std::span<const std::uint8_t> report, std::int64_t) noexcept override {
      const auto expected = static_cast<std::uint8_t>(newest + 1);
      lost_count += report[0] == expected ? 0 : 1;
      newest = report[0];
      ++since_drained;
    }
    void on_drained(std::int64_t) noexcept override {
      wrong_count += since_drained == 256 ? 0 : 1;
      since_drained = 0;
      ++drained_count;
    }
    void on_gone() noexcept override {}

    std::uint8_t newest = 0;
    int since_drained = 0;
    std::atomic<int> drained_count = 0, lost_count = 0, wrong_count = 0;
  } counter;
  HidPort port([]() -> Result<std::unique_ptr<HidTransport>> { return std::make_unique<EndlessTransport>(); }, counter, "fake");
  ASSERT_TRUE(port.open());
  EXPECT_TRUE(wait_until([&] { return counter.drained_count > 10; }));
  port.close();
  EXPECT_EQ(counter.lost_count, 0);
  EXPECT_EQ(counter.wrong_count, 0);
}

TEST(HidPort, UnpluggedItIsLookedForAndOpenedAgain) {
  FakeHid hid;
  Listener listener;
  HidPort port(hid.opener(), listener, "fake");
  ASSERT_TRUE(port.open());
  for (int round = 1; round <= 3; ++round) {
    hid.unplug();
    EXPECT_TRUE(wait_until([&] { return listener.gone_count == round && port.transport() == nullptr; }));
    hid.plug_in();
    EXPECT_TRUE(wait_until([&] { return listener.opened_count == 1 + round && port.transport() != nullptr; }));
    hid.send({static_cast<std::uint8_t>(round)});
    EXPECT_TRUE(wait_until([&] { return listener.newest == round; }));
  }
}

TEST(HidPort, PulledAndPluggedInBetweenTwoLooksItIsReopened) {
  FakeHid hid;
  Listener listener;
  HidPort port(hid.opener(), listener, "fake");
  ASSERT_TRUE(port.open());
  hid.unplug();
  hid.plug_in();
  EXPECT_TRUE(wait_until([&] { return listener.gone_count == 1 && hid.openings() == 2; }));
}

TEST(HidPort, AnUnusableDeviceIsTriedAgainLater) {
  FakeHid hid;
  Listener listener;
  HidPort port(hid.opener(), listener, "fake");
  ASSERT_TRUE(port.open());
  listener.is_unusable = true;
  hid.unplug();
  hid.plug_in();
  EXPECT_TRUE(wait_until([&] { return listener.opened_count >= 3; }));
  EXPECT_EQ(port.transport(), nullptr);
  listener.is_unusable = false;
  EXPECT_TRUE(wait_until([&] { return port.transport() != nullptr; }));
}

TEST(HidPort, AFailedWriteClosesAndReopensTheDevice) {
  FakeHid hid;
  Listener listener;
  HidPort port(hid.opener(), listener, "fake");
  ASSERT_TRUE(port.open());
  port.report_write_failure();
  EXPECT_TRUE(wait_until([&] { return listener.gone_count == 1 && hid.openings() == 2; }));
  EXPECT_TRUE(wait_until([&] {
    hid.send({7});
    return listener.newest == 7;
  })) << "the failure belongs to the earlier opening";
  EXPECT_EQ(listener.gone_count, 1);
}

// The port looks for the device four times a second, possibly for hours.
TEST(HidPort, SaysOnceForEachReasonWhyItIsNotFound) {
  start_log("test");
  testing::internal::CaptureStderr();
  {
    std::atomic<int> attempts = 0;
    Listener listener;
    const auto opener = [&]() -> Result<std::unique_ptr<HidTransport>> {
      if (attempts++ < 3) return fail("no such device");
      return fail("no permission");
    };
    HidPort port(opener, listener, "fake");
    port.start();
    EXPECT_TRUE(wait_until([&] { return attempts >= 6; }));
  }
  const std::string log = testing::internal::GetCapturedStderr();
  const auto count = [&](const std::string& words) {
    int times = 0;
    for (std::size_t at = log.find(words); at != std::string::npos; at = log.find(words, at + 1)) ++times;
    return times;
  };
  EXPECT_EQ(count("fake: searching: no such device"), 1) << log;
  EXPECT_EQ(count("fake: searching: no permission"), 1) << log;
}

TEST(HidPort, AUserOfTheTransportMayContinueAfterItHasGone) {
  FakeHid hid;
  Listener listener;
  HidPort port(hid.opener(), listener, "fake");
  ASSERT_TRUE(port.open());
  const auto transport = port.transport();
  hid.unplug();
  EXPECT_TRUE(wait_until([&] { return port.transport() == nullptr; }));
  EXPECT_FALSE(transport->write(std::vector<std::uint8_t>{0, 1}));
}

}  // namespace
}  // namespace hapton
