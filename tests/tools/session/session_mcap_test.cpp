#include "tools/session/session_mcap.h"

#include <gtest/gtest.h>

#include <limits>

#include "link/session_codec.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

constexpr std::int64_t kMcapStartNs = 7'000'000'000;

SessionEntry cycle_at(std::uint64_t sample, std::int64_t time_ns) {
  SessionEntry entry;
  entry.kind = SessionEntry::Kind::cycle;
  entry.time_ns = time_ns;
  entry.cycle.sample = sample;
  entry.cycle.device = CycleSample{.time_ns = time_ns};
  return entry;
}

struct McapRecordings : testing::Test {
  ScratchFolder scratch;
  SessionCodec codec;
  std::string bytes{kSessionMagic};

  McapRecordings() {
    codec.append(
        SessionHeader{.build = "b1", .start_ns = kMcapStartNs, .start_unix_ns = 1'800'000'000'000'000'000, .settings = {{"rate", "1000"}}},
        bytes);
  }
  Result<McapCounts> write(std::string* problem = nullptr) {
    auto reader = SessionReader::open(scratch.write("session.hapton", bytes));
    if (!reader) return tl::unexpected(reader.error());
    const std::vector<ObjectName> names = {{"hood", "tin"}};
    auto written = write_mcap(*reader, scratch.path() / "session.mcap", names);
    if (problem != nullptr) *problem = reader->problem();
    return written;
  }
};

// The contents are checked by a reader of its own: tests/python/mcap_test.py.
TEST_F(McapRecordings, EveryCycleAndEveryEventIsAMessage) {
  for (std::uint64_t sample = 1; sample <= 10; ++sample) {
    if (sample != 5) codec.append(cycle_at(sample, kMcapStartNs + static_cast<std::int64_t>(sample)), bytes);
  }
  SessionEntry entry;
  entry.kind = SessionEntry::Kind::fault;
  entry.fault = SessionFault::clamped;
  codec.append(entry, bytes);
  entry.kind = SessionEntry::Kind::marker;
  entry.marker = {7, NodeRole::tool, "trial"};
  codec.append(entry, bytes);
  entry.kind = SessionEntry::Kind::dropped;
  entry.dropped = 3;
  codec.append(entry, bytes);
  const auto written = write();
  ASSERT_TRUE(written) << written.error().what;
  EXPECT_EQ(written->cycles, 9U);
  EXPECT_EQ(written->messages, 9U + 4U) << "sample 5 is an event, too";
}

TEST_F(McapRecordings, ATruncatedOneIsWrittenUpToThere) {
  codec.append(cycle_at(1, kMcapStartNs), bytes);
  codec.append(cycle_at(2, kMcapStartNs), bytes);
  bytes.resize(bytes.size() - 3);
  std::string problem;
  const auto written = write(&problem);
  ASSERT_TRUE(written);
  EXPECT_EQ(written->cycles, 1U);
  EXPECT_NE(problem.find("is cut short"), std::string::npos) << problem;
}

TEST_F(McapRecordings, TimesOfAHostileFileDoNoHarm) {
  for (const std::int64_t time_ns : {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1}, std::numeric_limits<std::int64_t>::max()})
    codec.append(cycle_at(1, time_ns), bytes);
  EXPECT_TRUE(write());
}

TEST_F(McapRecordings, AnEmptyOneIsAFile) {
  const auto written = write();
  ASSERT_TRUE(written);
  EXPECT_EQ(written->messages, 0U);
}

}  // namespace
}  // namespace hapton
