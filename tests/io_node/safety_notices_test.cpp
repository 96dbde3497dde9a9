#include "io_node/safety_notices.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

class Tap final : public ServoTap {
 public:
  void on_sent(const Address&, std::span<const std::byte>, std::int64_t) noexcept override {}
  void on_received(const Address&, std::span<const std::byte>, std::int64_t) noexcept override {}
  void on_cycle(const CycleNote& note, std::int64_t) noexcept override {
    cycles.push_back(note.sample);
    written_n.push_back(note.written_n);
  }
  void on_fault(SessionFault fault, std::int64_t) noexcept override { faults.push_back(fault); }
  bool is_recording() const noexcept override { return true; }
  MarkerStatus on_marker(const MarkerNote&, std::int64_t) noexcept override { return MarkerStatus::recorded; }
  std::vector<std::uint64_t> cycles;
  std::vector<SessionFault> faults;
  std::vector<Vec3> written_n;
};

struct SafetyNoticesTest : testing::Test {
  EventRing events;
  Tap tap;
  SafetyNotices notices{events, &tap};
  DeviceSide side;
  DeviceCycle cycle;
  std::int64_t now_ns = 0;

  void check(bool is_missed = true) {
    now_ns += kMs;
    ++cycle.number;
    notices.check(side, cycle, is_missed, now_ns);
  }
  std::vector<ServoEvent::Kind> reported() {
    std::vector<ServoEvent::Kind> kinds;
    for (ServoEvent event; events.pop(event);) kinds.push_back(event.kind);
    return kinds;
  }
};

TEST_F(SafetyNoticesTest, ALatchedFaultAndItsResetAreReportedOnce) {
  check();
  side.governor.fault = SafetyFault::jump;
  ++side.governor.counters.latched;
  check();
  check();
  EXPECT_EQ(reported(), std::vector{ServoEvent::Kind::latched});
  EXPECT_EQ(tap.faults.size(), 1U);
  ++side.governor.counters.resets_rejected;
  check();
  EXPECT_EQ(reported(), std::vector{ServoEvent::Kind::reset_rejected});
  side.governor.fault = SafetyFault::none;
  ++side.governor.counters.resets;
  check();
  check();
  EXPECT_EQ(reported(), std::vector{ServoEvent::Kind::reset});
  EXPECT_EQ(tap.cycles.size(), 6U);
}

// A stalled network side records all at once what was on the motors cycle by cycle.
TEST_F(SafetyNoticesTest, AnOvertakenCycleHasTheForceOfItsOwnEnd) {
  side.written.force_n = Vec3(0, 0, 3);
  cycle.written.force_n = Vec3(0, 0, 1);
  notices.note_overtaken(cycle, now_ns);
  check();
  EXPECT_EQ(tap.written_n, (std::vector<Vec3>{Vec3(0, 0, 1), Vec3(0, 0, 3)}));
  SafetyNotices untapped(events, nullptr);
  untapped.note_overtaken(cycle, now_ns);
}

TEST_F(SafetyNoticesTest, ADeviceIsAwayWhenItStaysAway) {
  check();
  side.status = DeviceStatus::away;
  for (int n = 0; n < 50; ++n) check();
  side.status = DeviceStatus::ready;
  check();
  EXPECT_TRUE(reported().empty());
  side.status = DeviceStatus::away;
  for (int n = 0; n < 200; ++n) check();
  EXPECT_EQ(reported(), std::vector{ServoEvent::Kind::away});
  side.status = DeviceStatus::ready;
  for (int n = 0; n < 200; ++n) check();
  EXPECT_EQ(reported(), std::vector{ServoEvent::Kind::back});
}

TEST_F(SafetyNoticesTest, AShortGapIsNoFaultAndACommandTimeoutIs) {
  check();
  ++side.governor.counters.command_timeouts;
  check(false);
  EXPECT_TRUE(tap.faults.empty());
  for (int n = 0; n < 3; ++n) {
    ++side.governor.counters.command_timeouts;
    check();
  }
  EXPECT_EQ(tap.faults, std::vector{SessionFault::command_timeout});
  cycle.late_ns = kCommandTimeoutNs;
  check();
  EXPECT_EQ(tap.faults.back(), SessionFault::stalled);
}

}  // namespace
}  // namespace hapton
