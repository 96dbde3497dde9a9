#include "tools/session/session_mcap.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <iterator>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "link/codec.h"
#include "link/message_payload.h"
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

// A datagram that the hub received from the haptics node, or passed on.
SessionEntry datagram_of(SessionEntry::Kind kind, const Message& message, std::span<std::byte> into) {
  Codec codec;
  const std::size_t size = codec.encode({{.session = 1, .sender = 2, .sequence = 3}, message}, into);
  SessionEntry entry;
  entry.kind = kind;
  entry.time_ns = kMcapStartNs;
  entry.datagram = into.first(size);
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

// An independent reader checks the contents: tests/python/mcap_test.py.
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
  EXPECT_EQ(written->messages, 9U + 4U) << "the gap at sample 5 is an event, too";
}

// The copies that the hub sends to vision nodes are not messages of the file.
TEST_F(McapRecordings, EachMoveOfAnObjectThatWasReceivedIsAMessage) {
  std::array<std::byte, kMaxDatagramBytes> datagram;
  const ObjectMove move{.source = 5, .serial = 1, .object = 2, .start_ns = 3, .end_ns = 4, .to_p_m = Vec3(0.1, 0.2, 0.3)};
  codec.append(datagram_of(SessionEntry::Kind::received, move, datagram), bytes);
  for (int n = 0; n < 2; ++n) codec.append(datagram_of(SessionEntry::Kind::sent, move, datagram), bytes);
  const auto written = write();
  ASSERT_TRUE(written) << written.error().what;
  EXPECT_EQ(written->messages, 1U);
  std::ifstream in(scratch.path() / "session.mcap", std::ios::binary);
  const std::string file{std::istreambuf_iterator<char>(in), {}};
  const std::string_view payload = find_message_payload(datagram_of(SessionEntry::Kind::received, move, datagram).datagram);
  ASSERT_GT(payload.size(), 50U);
  EXPECT_NE(file.find(payload), std::string::npos) << "unchanged";
  EXPECT_NE(file.find("/hapton/move"), std::string::npos);
}

TEST_F(McapRecordings, ANameOfAnObjectIsWholeHoweverLong) {
  auto reader = SessionReader::open(scratch.write("session.hapton", bytes));
  ASSERT_TRUE(reader) << reader.error().what;
  const std::string name(60, 'n');
  const std::vector<ObjectName> names = {{name, "tin"}};
  const auto written = write_mcap(*reader, scratch.path() / "session.mcap", names);
  ASSERT_TRUE(written) << written.error().what;
  std::ifstream in(scratch.path() / "session.mcap", std::ios::binary);
  const std::string file{std::istreambuf_iterator<char>(in), {}};
  EXPECT_NE(file.find(name), std::string::npos);
}

TEST_F(McapRecordings, CarvesAreMessages) {
  std::array<std::byte, kMaxDatagramBytes> datagram;
  Carves carves{.source = 5, .newest = 1, .first = 1, .count = 1};
  carves.carves[0] = {.object = 2, .from_m = {0.1F, 0.2F, 0.3F}, .to_m = {0.1F, 0.2F, 0.3F}, .radius_m = 0.01F};
  codec.append(datagram_of(SessionEntry::Kind::received, carves, datagram), bytes);
  codec.append(datagram_of(SessionEntry::Kind::sent, carves, datagram), bytes);
  codec.append(datagram_of(SessionEntry::Kind::received, CarveStatus{.source = 5}, datagram), bytes);
  const auto written = write();
  ASSERT_TRUE(written) << written.error().what;
  EXPECT_EQ(written->messages, 1U) << "neither the hub's copies nor requests";
  std::ifstream in(scratch.path() / "session.mcap", std::ios::binary);
  const std::string file{std::istreambuf_iterator<char>(in), {}};
  EXPECT_NE(file.find("/hapton/carve"), std::string::npos);
}

// One message with all vertices, not the parts in which they were sent.
TEST_F(McapRecordings, EachShapeOfAnObjectIsAMessage) {
  std::array<std::byte, kMaxDatagramBytes> datagram;
  constexpr std::uint32_t kTotal = 70;
  SessionShape expected{.process = 0, .start = {.source = 5, .serial = 1, .object = 2, .total = kTotal, .start_ns = 3, .end_ns = 4}};
  const std::vector<ShapePart::Displacement> displacements(kTotal, {0.5F, -0.25F, 0.125F});
  expected.displacements_m = displacements;
  for (const std::uint32_t first : {0U, 64U}) {
    ObjectShape part{.source = 5, .serial = 1, .object = 2, .part = {.total = kTotal, .first = first}};
    part.part.displacements_m.fill(displacements[0]);
    for (int n = 0; n < 2; ++n) codec.append(datagram_of(SessionEntry::Kind::received, part, datagram), bytes);
  }
  codec.append(datagram_of(SessionEntry::Kind::received, expected.start, datagram), bytes);
  codec.append(datagram_of(SessionEntry::Kind::sent, expected.start, datagram), bytes);
  // The vertices of the second shape were lost.
  ShapeStart second = expected.start;
  second.serial = 2;
  codec.append(datagram_of(SessionEntry::Kind::received, second, datagram), bytes);
  const auto written = write();
  ASSERT_TRUE(written) << written.error().what;
  EXPECT_EQ(written->messages, 2U);
  std::ifstream in(scratch.path() / "session.mcap", std::ios::binary);
  const std::string file{std::istreambuf_iterator<char>(in), {}};
  std::string payload;
  codec.append_alone(expected, payload);
  EXPECT_GT(payload.size(), kTotal * 3 * sizeof(float));
  EXPECT_NE(file.find(payload), std::string::npos);
  EXPECT_NE(file.find("/hapton/shape"), std::string::npos);
}

TEST_F(McapRecordings, PosesOfHeldObjectsAndMaterialsAreMessages) {
  std::array<std::byte, kMaxDatagramBytes> datagram;
  for (const Message& message : {Message(ObjectPose{.serial = 1, .object = 2, .is_held = true}), Message(MaterialState{.serial = 1})}) {
    codec.append(datagram_of(SessionEntry::Kind::received, message, datagram), bytes);
    codec.append(datagram_of(SessionEntry::Kind::sent, message, datagram), bytes);
  }
  const auto written = write();
  ASSERT_TRUE(written) << written.error().what;
  EXPECT_EQ(written->messages, 2U);
}

TEST_F(McapRecordings, ATruncatedRecordingIsWrittenUpToItsEnd) {
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
  const auto written = write();
  ASSERT_TRUE(written);
  EXPECT_EQ(written->cycles, 3U);
}

TEST_F(McapRecordings, AnEmptyRecordingGivesAValidFile) {
  const auto written = write();
  ASSERT_TRUE(written);
  EXPECT_EQ(written->messages, 0U);
}

}  // namespace
}  // namespace hapton
