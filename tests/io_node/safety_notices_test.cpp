#include "io_node/safety_notices.h"

#include <gtest/gtest.h>

#include <utility>
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
    notes.push_back(note);
  }
  void on_fault(SessionFault fault, std::int64_t) noexcept override { faults.push_back(fault); }
  bool is_recording() const noexcept override { return true; }
  MarkerStatus on_marker(const MarkerNote&, std::int64_t) noexcept override { return MarkerStatus::recorded; }
  std::vector<std::uint64_t> cycles;
  std::vector<SessionFault> faults;
  std::vector<Vec3> written_n;
  std::vector<CycleNote> notes;
};

struct SafetyNoticesTest : testing::Test {
  EventRing events;
  Tap tap;
  SafetyNotices notices{events, &tap};
  DeviceSide side;
  DeviceCycle cycle;
  std::int64_t now_ns = 0;

  // Latches a fault as the governor does.
  void latch(SafetyFault fault) {
    side.governor.fault = fault;
    ++side.governor.counters.latched;
    ++side.governor.counters.faults[static_cast<std::size_t>(fault)];
  }
  void reset() {
    side.governor.fault = SafetyFault::none;
    ++side.governor.counters.resets;
  }
  void check(bool is_timeout_fault = true) {
    now_ns += kMs;
    ++cycle.number;
    notices.check(side, cycle, is_timeout_fault, now_ns);
  }
  std::vector<ServoEvent::Kind> take_event_kinds() {
    std::vector<ServoEvent::Kind> kinds;
    for (ServoEvent event; events.pop(event);) kinds.push_back(event.kind);
    return kinds;
  }
};

TEST_F(SafetyNoticesTest, ALatchedFaultAndItsResetAreReportedOnce) {
  check();
  latch(SafetyFault::jump);
  check();
  check();
  EXPECT_EQ(take_event_kinds(), std::vector{ServoEvent::Kind::latched});
  EXPECT_EQ(tap.faults.size(), 1U);
  ++side.governor.counters.resets_rejected;
  check();
  EXPECT_EQ(take_event_kinds(), std::vector{ServoEvent::Kind::reset_rejected});
  side.governor.fault = SafetyFault::none;
  ++side.governor.counters.resets;
  check();
  check();
  EXPECT_EQ(take_event_kinds(), std::vector{ServoEvent::Kind::reset});
  EXPECT_EQ(tap.cycles.size(), 6U);
}

// Whoever saves the latched fault for the next start goes by the last event, which must report what is latched now.
TEST_F(SafetyNoticesTest, AFaultThatFollowsAResetAtOnceIsReportedAfterIt) {
  check();
  latch(SafetyFault::jump);
  check();
  (void)take_event_kinds();
  reset();
  latch(SafetyFault::speed);
  check();
  EXPECT_EQ(take_event_kinds(), (std::vector{ServoEvent::Kind::reset, ServoEvent::Kind::latched}));
  reset();
  latch(SafetyFault::jump);
  reset();
  check();
  EXPECT_EQ(take_event_kinds(), (std::vector{ServoEvent::Kind::latched, ServoEvent::Kind::reset})) << "the fault is over";
}

// This happens when the network side is late. Without it, people and the recording would get a fault without a name.
TEST_F(SafetyNoticesTest, AFaultThatIsResetBeforeTheNextCheckIsReportedByItsName) {
  const auto take_faults_of_events = [&] {
    std::vector<std::pair<ServoEvent::Kind, SafetyFault>> all;
    for (ServoEvent event; events.pop(event);) all.emplace_back(event.kind, event.fault);
    return all;
  };
  using Kind = ServoEvent::Kind;
  check();
  latch(SafetyFault::speed);
  reset();
  check();
  EXPECT_EQ(take_faults_of_events(),
            (std::vector{std::pair(Kind::latched, SafetyFault::speed), std::pair(Kind::reset, SafetyFault::speed)}));
  EXPECT_EQ(tap.faults, std::vector{SessionFault::speed});
  latch(SafetyFault::jump);
  reset();
  latch(SafetyFault::thermal);
  check();
  EXPECT_EQ(take_faults_of_events(), (std::vector{std::pair(Kind::latched, SafetyFault::jump), std::pair(Kind::reset, SafetyFault::jump),
                                                  std::pair(Kind::latched, SafetyFault::thermal)}));
  EXPECT_EQ(tap.faults, (std::vector{SessionFault::speed, SessionFault::jump, SessionFault::thermal}));
  reset();
  latch(SafetyFault::thermal);
  check();
  EXPECT_EQ(take_faults_of_events(),
            (std::vector{std::pair(Kind::reset, SafetyFault::thermal), std::pair(Kind::latched, SafetyFault::thermal)}));
  check();
  EXPECT_TRUE(take_faults_of_events().empty());
}

// A stalled network side records several cycles at once: each with the force that was on the motors in that cycle.
TEST_F(SafetyNoticesTest, AnOvertakenCycleHasTheForceOfItsOwnEnd) {
  side.written.force_n = Vec3(0, 0, 3);
  cycle.written.force_n = Vec3(0, 0, 1);
  notices.note_overtaken(cycle, now_ns);
  check();
  EXPECT_EQ(tap.written_n, (std::vector<Vec3>{Vec3(0, 0, 1), Vec3(0, 0, 3)}));
  SafetyNotices untapped(events, nullptr);
  untapped.note_overtaken(cycle, now_ns);
}

TEST_F(SafetyNoticesTest, ACycleIsRecordedWithItsSampleAndTheForceOfItsOwnPatches) {
  cycle.sample.time_ns = 7 * kMs;
  cycle.sample.p_WD = Vec3(0.01, 0.02, 0.03);
  cycle.sample.buttons = 2;
  cycle.late_ns = 5000;
  cycle.missed = 1;
  cycle.cause = MissCause::work_long;
  cycle.local = LocalForce{.force_n = Vec3(0, 0, 2), .visual_offset_m = Vec3(0, 0, 0.002), .object = 4};
  cycle.written = {.force_n = Vec3(0, 0, 1), .torque_nm = Vec3(0, 0.1, 0)};
  side.written = {.force_n = Vec3(0, 0, 3), .torque_nm = Vec3(0, 0.3, 0)};
  check();
  ASSERT_EQ(tap.notes.size(), 1U);
  const CycleNote& note = tap.notes[0];
  EXPECT_EQ(note.written_n, Vec3(0, 0, 1)) << "not that of a later cycle";
  EXPECT_EQ(note.written_nm, Vec3(0, 0.1, 0));
  EXPECT_EQ(note.late_ns, 5000);
  EXPECT_EQ(note.missed, 1U);
  EXPECT_EQ(note.cause, MissCause::work_long);
  ASSERT_TRUE(note.device && note.local);
  EXPECT_EQ(note.device->time_ns, 7 * kMs);
  EXPECT_EQ(note.device->p_WD, Vec3(0.01, 0.02, 0.03));
  EXPECT_EQ(note.device->buttons, 2U);
  EXPECT_EQ(note.local->force_n, Vec3(0, 0, 2));
  EXPECT_EQ(note.local->visual_offset_m, Vec3(0, 0, 0.002));
  EXPECT_EQ(note.local->object, 4);
}

TEST_F(SafetyNoticesTest, ADeviceIsAwayWhenItStaysAway) {
  check();
  side.status = DeviceStatus::away;
  for (int n = 0; n < 50; ++n) check();
  side.status = DeviceStatus::ready;
  check();
  EXPECT_TRUE(take_event_kinds().empty());
  side.status = DeviceStatus::away;
  for (int n = 0; n < 200; ++n) check();
  EXPECT_EQ(take_event_kinds(), std::vector{ServoEvent::Kind::away});
  side.status = DeviceStatus::ready;
  for (int n = 0; n < 200; ++n) check();
  EXPECT_EQ(take_event_kinds(), std::vector{ServoEvent::Kind::back});
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

TEST_F(SafetyNoticesTest, ADeviceThatHasFailedAtTheEndIsRecordedOnce) {
  notices.finish(side, DeviceStatus::ready, now_ns);
  EXPECT_TRUE(tap.faults.empty());
  side.governor.fault = SafetyFault::device;  // latched by an earlier process: the counters do not have it
  check();
  notices.finish(side, DeviceStatus::fault, now_ns);
  EXPECT_EQ(tap.faults, std::vector{SessionFault::device});
  latch(SafetyFault::device);
  check();
  check();
  notices.finish(side, DeviceStatus::fault, now_ns);
  EXPECT_EQ(tap.faults, (std::vector{SessionFault::device, SessionFault::device})) << "latched, and not recorded again";
  side.governor.fault = SafetyFault::none;
  check();
  notices.finish(side, DeviceStatus::fault, now_ns);
  EXPECT_EQ(tap.faults.size(), 3U) << "another failure";
}

// Otherwise the latched fault would not be saved for the next start.
TEST_F(SafetyNoticesTest, WhatWasLatchedSinceTheLastCheckIsReportedAtTheEnd) {
  check();
  latch(SafetyFault::speed);
  notices.finish(side, DeviceStatus::ready, now_ns);
  EXPECT_EQ(take_event_kinds(), std::vector{ServoEvent::Kind::latched});
  EXPECT_EQ(tap.faults, std::vector{SessionFault::speed});
  latch(SafetyFault::device);
  notices.finish(side, DeviceStatus::fault, now_ns);
  EXPECT_EQ(tap.faults, (std::vector{SessionFault::speed, SessionFault::device})) << "once";
  SafetyNotices untapped(events, nullptr);
  untapped.finish(side, DeviceStatus::ready, now_ns);
}

TEST_F(SafetyNoticesTest, EachKindOfFaultIsRecordedWhenItBegins) {
  check();
  // Checks once; returns the faults that this adds to the recording.
  const auto record_new_faults = [&] {
    tap.faults.clear();
    check();
    return std::exchange(tap.faults, {});
  };
  EXPECT_TRUE(record_new_faults().empty());
  ++side.governor.counters.not_finite;
  EXPECT_EQ(record_new_faults(), std::vector{SessionFault::not_finite});
  ++side.governor.counters.rejected_future;
  EXPECT_EQ(record_new_faults(), std::vector{SessionFault::rejected_future});
  ++side.governor.counters.clamped;
  EXPECT_EQ(record_new_faults(), std::vector{SessionFault::clamped});
  EXPECT_TRUE(record_new_faults().empty());
  side.has_overrun = true;
  EXPECT_EQ(record_new_faults(), std::vector{SessionFault::overrun});
  EXPECT_TRUE(record_new_faults().empty()) << "it is still the same";
  for (int n = 0; n < 2; ++n) {
    side.is_energy_gone = true;
    EXPECT_EQ(record_new_faults(), std::vector{SessionFault::energy});
    EXPECT_TRUE(record_new_faults().empty()) << "it is still the same";
    side.is_energy_gone = false;
    EXPECT_TRUE(record_new_faults().empty());
  }
}

}  // namespace
}  // namespace hapton
