#include "tools/session/session_summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::int64_t kStartNs = 5'000'000'000;
constexpr std::int64_t kMs = 1'000'000;
const std::array<std::byte, 100> kDatagramBytes = {};

// Tests the text that `hapton session info` prints about a recording.
struct SessionSummaryTest : testing::Test {
  void add(SessionEntry::Kind kind, std::int64_t at_ms, const Message& message) {
    SessionEntry entry;
    entry.kind = kind;
    entry.time_ns = kStartNs + at_ms * kMs;
    entry.datagram = kDatagramBytes;
    const Datagram datagram{{.sender = 0xABC}, message};
    summary.add(entry, &datagram);
  }
  void add_cycle(std::int64_t at_ms, const CycleNote& cycle) {
    SessionEntry entry;
    entry.kind = SessionEntry::Kind::cycle;
    entry.time_ns = kStartNs + at_ms * kMs;
    entry.cycle = cycle;
    summary.add(entry, nullptr);
  }
  void add_fault(std::int64_t at_ms, SessionFault fault) {
    SessionEntry entry;
    entry.kind = SessionEntry::Kind::fault;
    entry.time_ns = kStartNs + at_ms * kMs;
    entry.fault = fault;
    summary.add(entry, nullptr);
  }
  void add_marker(std::int64_t at_ms, std::uint64_t sample, std::string_view text) {
    SessionEntry entry;
    entry.kind = SessionEntry::Kind::marker;
    entry.time_ns = kStartNs + at_ms * kMs;
    entry.marker = {sample, NodeRole::tool, text};
    summary.add(entry, nullptr);
  }
  std::string text() const { return summary.to_text(header); }

  SessionSummary summary;
  SessionHeader header{"0.9 of a test", kStartNs, 0, 7, "", {{"rate", "1000"}, {"device", "simulated"}}};
};

TEST_F(SessionSummaryTest, SaysWhatItIsAndHowLongItTook) {
  add(SessionEntry::Kind::sent, 100, DeviceState{});
  add(SessionEntry::Kind::sent, 1600, DeviceState{});
  add(SessionEntry::Kind::sent, 1500, DeviceState{});  // written by another thread, a little late
  EXPECT_THAT(text(), HasSubstr("session, begun 1970-01-01 00:00:00 UTC, 1.500 s, 3 entries\n"));
  EXPECT_THAT(text(), HasSubstr("hub: 0.9 of a test\nsettings: rate 1000, device simulated\n"));
  header.fault = "speed";
  EXPECT_THAT(text(), HasSubstr("flight record: speed, begun"));
}

TEST_F(SessionSummaryTest, CountsEachMessageBothWays) {
  for (int n = 0; n < 3; ++n) add(SessionEntry::Kind::sent, 10 * n, DeviceState{});
  for (int n = 0; n < 2; ++n) add(SessionEntry::Kind::received, 10 * n, ForceCommand{});
  add(SessionEntry::Kind::received, 500, ProbeState{});
  SessionEntry entry;
  entry.kind = SessionEntry::Kind::received;
  entry.time_ns = kStartNs;
  entry.datagram = kDatagramBytes;
  summary.add(entry, nullptr);
  EXPECT_THAT(text(), HasSubstr("DeviceState             0          3       0.6\n")) << "300 bytes in half a second";
  EXPECT_THAT(text(), HasSubstr("ForceCommand            2          0       0.4\n"));
  EXPECT_THAT(text(), HasSubstr("not used                1          0       0.2\n"));
}

TEST_F(SessionSummaryTest, SaysWhatWasFelt) {
  ForceCommand force;
  force.contact = true;
  force.force_n = Vec3(0, 3, 4);
  force.echo_sample_time_ns = kStartNs + 8 * kMs;
  add(SessionEntry::Kind::received, 10, force);
  force.contact = false;
  force.force_n = Vec3(0, 0, 1);
  add(SessionEntry::Kind::received, 10, force);
  force.force_n = Vec3(9, 0, 0);
  add(SessionEntry::Kind::sent, 10, force);  // a copy to a recorder, not another force
  add_cycle(10, {.sample = 1, .written_n = Vec3(2, 0, 0)});
  add_cycle(11, {.sample = 2, .written_n = Vec3(1, 0, 0)});
  EXPECT_THAT(text(), HasSubstr("forces: 1 in contact, maximum requested 5.000 N, maximum written 2.000 N\n"));
  EXPECT_THAT(text(), HasSubstr("max 2000.0 us, n 2\n")) << "from the sample to its force";
  EXPECT_THAT(text(), Not(HasSubstr("torque"))) << "there was none";
}

TEST_F(SessionSummaryTest, SaysWhichTorqueARigidToolHad) {
  ForceCommand force;
  force.torque_nm = Vec3(0.03, 0.0, 0.04);
  add(SessionEntry::Kind::received, 10, force);
  add_cycle(10, {.sample = 1, .written_nm = Vec3(0.0, 0.025, 0.0)});
  EXPECT_THAT(text(), HasSubstr("torques: maximum requested 0.0500 Nm, maximum written 0.0250 Nm\n"));
}

TEST_F(SessionSummaryTest, TimesOfAHostileFileDoNoHarm) {
  constexpr std::int64_t kEarliestNs = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kLatestNs = std::numeric_limits<std::int64_t>::max();
  for (const std::int64_t time_ns : {kEarliestNs, kLatestNs}) {
    SessionEntry entry;
    entry.kind = SessionEntry::Kind::received;
    entry.time_ns = time_ns;
    const Datagram datagram{{}, ForceCommand{.echo_sample_time_ns = -time_ns / 2 - time_ns / 3}};
    summary.add(entry, &datagram);
  }
  add_fault(0, SessionFault::clamped);
  add_marker(0, 1, "here");
  EXPECT_THAT(text(), HasSubstr("max 9223372036854776.0 us, n 2\n")) << "the longest time that 64 bits of nanoseconds can hold";
  header.start_ns = kEarliestNs;
  EXPECT_THAT(text(), HasSubstr("fault at 9223372036.854776 s"));
  EXPECT_THAT(text(), HasSubstr("marker at 9223372036.854776 s"));
}

// Forces that io_node computed are in no reply, so they are not among the forces that a replay compares.
TEST_F(SessionSummaryTest, CountsTheForcesThatIoNodeComputed) {
  add_cycle(10, {.sample = 1});
  EXPECT_THAT(text(), Not(HasSubstr("computed by io_node")));
  add_cycle(11, {.sample = 2, .local = CycleLocal{Vec3(1, 0, 0), Vec3::Zero(), 0}});
  add_cycle(12, {.sample = 3, .local = CycleLocal{Vec3::Zero(), Vec3::Zero(), -1}});
  EXPECT_THAT(text(), HasSubstr("forces computed by io_node, from parts of the scene: 2\n"));
  EXPECT_EQ(summary.local_forces(), 2U);
}

TEST_F(SessionSummaryTest, SaysWhatIsMissing) {
  add_cycle(1, {.sample = 10, .late_ns = 5000});
  add_cycle(2, {.sample = 11, .missed = 2, .cause = MissCause::late_wake_up});
  EXPECT_THAT(text(), Not(HasSubstr("missing in the recording")));
  add_cycle(5, {.sample = 14, .missed = 1, .cause = MissCause::late_wake_up});
  add_cycle(9, {.sample = 17, .missed = 4, .cause = MissCause::device_slow});
  EXPECT_THAT(text(), HasSubstr("cycles: 4, late by "));
  EXPECT_THAT(text(), HasSubstr("7 missed cycles; times by cause: late wake-up 2, device slow 1\n"));
  EXPECT_THAT(text(), HasSubstr("missing in the recording: 4 samples in 2 gaps\n"));
  EXPECT_THAT(text(), Not(HasSubstr("not recorded")));
  SessionEntry entry;
  entry.kind = SessionEntry::Kind::dropped;
  entry.dropped = 5;
  summary.add(entry, nullptr);
  entry.dropped = 7;
  summary.add(entry, nullptr);
  EXPECT_THAT(text(), HasSubstr("not recorded: 12 entries (buffer full)\n"));
}

TEST_F(SessionSummaryTest, ListsTheFirstFaultsAndMarkersAndCountsAll) {
  for (int n = 1; n <= 25; ++n) {
    add_fault(1000 + n, n == 25 ? SessionFault::clamped : SessionFault::command_timeout);
    add_marker(2000 + n, 100 + static_cast<std::uint64_t>(n), "trial " + std::to_string(n));
  }
  const std::string summary_text = text();
  const auto count = [&](const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = summary_text.find(part); at != std::string::npos; at = summary_text.find(part, at + 1)) ++found;
    return found;
  };
  EXPECT_EQ(count("fault at "), 20U);
  EXPECT_EQ(count("marker at "), 20U);
  EXPECT_THAT(summary_text, HasSubstr("fault at 1.001000 s: " + std::string(to_string(SessionFault::command_timeout)) + "\n"));
  EXPECT_THAT(summary_text, HasSubstr("marker at 2.020000 s, sample 120: trial 20\n"));
  EXPECT_THAT(summary_text, HasSubstr("faults: 24 " + std::string(to_string(SessionFault::command_timeout)) + "\n"));
  EXPECT_THAT(summary_text, HasSubstr("faults: 1 " + std::string(to_string(SessionFault::clamped)) + "\n"));
  EXPECT_THAT(summary_text, HasSubstr("markers: 25\n"));
}

TEST_F(SessionSummaryTest, NamesEachMethodAndCountsChangedMaterials) {
  HapticsSetup setup;
  setup.scene_hash = 0xBEEF;
  const auto put = [](std::string_view from, HapticsSetup::Text& into) { std::copy(from.begin(), from.end(), into.begin()); };
  put("proxy", setup.method);
  put("/a/part.stl", setup.scene);
  put("0.9", setup.build);
  add(SessionEntry::Kind::received, 1, setup);
  add(SessionEntry::Kind::received, 2, setup);  // repeated
  setup.method_serial = 1;
  put("sweep", setup.method);
  add(SessionEntry::Kind::received, 3, setup);
  add(SessionEntry::Kind::received, 3, MaterialState{});
  EXPECT_THAT(text(), Not(HasSubstr("materials changed"))) << "those of the start";
  add(SessionEntry::Kind::received, 4, MaterialState{.serial = 1});
  add(SessionEntry::Kind::received, 5, MaterialState{.serial = 2});
  EXPECT_THAT(text(), HasSubstr("haptics 0000000000000abc: proxy, scene /a/part.stl (000000000000beef), 0.9\n"
                                "haptics 0000000000000abc: sweep, scene /a/part.stl (000000000000beef), 0.9\n"));
  EXPECT_THAT(text(), HasSubstr("materials changed while running: 2\n"));
}

}  // namespace
}  // namespace hapton
