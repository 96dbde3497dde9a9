#include "recording/recording_shape_collector.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "tests/recording/made_entries.h"

namespace hapton {
namespace {

constexpr std::uint32_t kCollectedVertices = 100;  // sent in two parts

struct ShapeCollectorTest : testing::Test {
  void receive(const Message& message) {
    SessionEntry entry;
    entry.kind = SessionEntry::Kind::received;
    entry.time_ns = kCyclesStartNs + ++time_ms * 1'000'000;
    const Datagram datagram{{.session = 1, .sender = 2}, message};
    collector.add(entry, &datagram, take);
  }
  void receive_part(std::uint32_t serial, std::uint32_t first, std::uint32_t source = 5, std::int32_t object = 0) {
    ObjectShape shape{.source = source, .serial = serial, .object = object};
    shape.part = {.total = kCollectedVertices, .first = first};
    shape.part.displacements_m.fill({1e-3F * static_cast<float>(serial), 0.0F, static_cast<float>(first)});
    receive(shape);
  }
  void receive_start(std::uint32_t serial, std::uint32_t source = 5, std::int32_t object = 0) {
    receive(ShapeStart{.source = source, .serial = serial, .before = serial - 1, .object = object, .total = kCollectedVertices});
  }

  std::int64_t time_ms = 0;
  // "process.serial" of each shape that was handed on, with a question mark if it has no vertices.
  std::vector<std::string> collected;
  std::vector<double> times_s;
  RecordingShapeCollector::Take take = [this](const RecordedShape& shape) {
    collected.push_back(std::to_string(shape.process) + "." + std::to_string(shape.start.serial) +
                        (shape.displacements_m.empty() ? "?" : ""));
    times_s.push_back(shape.t_s);
    if (shape.displacements_m.empty()) return;
    ASSERT_EQ(shape.displacements_m.size(), kCollectedVertices);
    for (std::size_t v = 0; v < kCollectedVertices; ++v) {
      const std::array<float, 3> expected = {1e-3F * static_cast<float>(shape.start.serial), 0.0F, v < 64 ? 0.0F : 64.0F};
      EXPECT_EQ(shape.displacements_m[v], expected) << v;
    }
  };
  RecordingShapeCollector collector{kCyclesStartNs};
};

TEST_F(ShapeCollectorTest, EachShapeIsHandedOnOnceItIsThere) {
  receive_part(1, 64);
  receive_part(1, 0);
  EXPECT_TRUE(collected.empty()) << "it has not begun";
  receive_start(1);
  ASSERT_EQ(collected, std::vector<std::string>({"0.1"}));
  EXPECT_NEAR(times_s[0], 0.003, 1e-9);
  receive_start(1);
  receive_part(1, 0);
  receive_part(1, 64);
  collector.finish(take);
  EXPECT_EQ(collected.size(), 1U) << "repetitions add nothing";
}

// As for a shape from before the recording, whose parts the hub requests.
TEST_F(ShapeCollectorTest, PartsMayComeAfterTheStart) {
  receive_start(4);
  receive_part(4, 0);
  receive_part(5, 0);
  receive_part(5, 64);
  receive_start(5);
  EXPECT_TRUE(collected.empty());
  receive_part(4, 64);
  EXPECT_EQ(collected, std::vector<std::string>({"0.4", "0.5"})) << "in their order";
}

TEST_F(ShapeCollectorTest, WithoutAPartAShapeHasNoVertices) {
  receive_part(1, 0);
  receive_start(1);
  receive_part(2, 0);
  receive_part(2, 64);
  receive_start(2);
  receive_part(3, 0);
  receive_part(3, 64);
  collector.finish(take);
  EXPECT_EQ(collected, std::vector<std::string>({"0.1?", "0.2"})) << "the third one was never applied";
}

TEST_F(ShapeCollectorTest, AnotherProcessBeginsWithItsObjectsAtRest) {
  receive_part(7, 0);
  receive_part(7, 64);
  receive_start(7);
  receive_start(0, 6);
  receive_part(1, 0, 6);
  receive_part(1, 64, 6);
  receive_start(1, 6);
  EXPECT_EQ(collected, std::vector<std::string>({"0.7", "1.1"}));
}

// The tables of moves and carves have the same numbers.
TEST_F(ShapeCollectorTest, AProcessOfWhichOnlyMovesAreRecordedCountsToo) {
  receive(ObjectMove{.source = 4, .serial = 1});
  receive_part(1, 0);
  receive_part(1, 64);
  receive_start(1);
  receive(Carves{.source = 6, .newest = 1, .first = 1, .count = 1});
  receive_start(0, 7);
  receive_part(1, 0, 7);
  receive_part(1, 64, 7);
  receive_start(1, 7);
  EXPECT_EQ(collected, std::vector<std::string>({"1.1", "3.1"}));
}

TEST_F(ShapeCollectorTest, AFileWithAnyNumberOfPartsTakesLittleMemory) {
  for (std::uint32_t serial = 1; serial <= 1000; ++serial) receive_part(serial, 0, 5, static_cast<std::int32_t>(serial % 8));
  receive_start(1000, 5, 0);
  collector.finish(take);
  EXPECT_EQ(collected, std::vector<std::string>({"0.1000?"}));
}

// The hub sends shapes on to vision nodes, and receives what cannot be read.
TEST_F(ShapeCollectorTest, OnlyReadableDatagramsThatTheHubReceivedCount) {
  SessionEntry entry;
  entry.kind = SessionEntry::Kind::sent;
  const Datagram part_1{{.session = 1, .sender = 0}, ObjectShape{.source = 5, .serial = 1, .part = {.total = 3}}};
  const Datagram start_1{{.session = 1, .sender = 0}, ShapeStart{.source = 5, .serial = 1, .total = 3}};
  collector.add(entry, &part_1, take);
  collector.add(entry, &start_1, take);
  entry.kind = SessionEntry::Kind::received;
  collector.add(entry, nullptr, take);
  collector.finish(take);
  EXPECT_TRUE(collected.empty());
}

// A hub requests parts again for a picture that begins later, long after the shape was handed on.
TEST_F(ShapeCollectorTest, PartsThatAreSentAgainDelayNoLaterShape) {
  for (const std::uint32_t serial : {1U, 2U}) {
    receive_part(serial, 0);
    receive_part(serial, 64);
    receive_start(serial);
    receive_part(serial, 0);
  }
  EXPECT_EQ(collected, std::vector<std::string>({"0.1", "0.2"}));
}

TEST_F(ShapeCollectorTest, PartsOfAnotherNumberOfVerticesAreNotThoseOfTheShape) {
  receive_part(1, 0);
  receive_part(1, 64);
  receive(ShapeStart{.source = 5, .serial = 1, .total = kCollectedVertices + 1});
  collector.finish(take);
  EXPECT_EQ(collected, std::vector<std::string>({"0.1?"}));
}

// An export has one array for each object and process, with as many vertices as the first shape in it.
TEST_F(ShapeCollectorTest, CountsTheShapesThatAnExportHasTheVerticesOf) {
  std::vector<std::string> rows;  // "process.object.serial row"
  take = [&](const RecordedShape& shape) {
    const std::string row = shape.row ? std::to_string(*shape.row) : "none";
    rows.push_back(fmt::format("{}.{}.{} {}", shape.process, shape.start.object, shape.start.serial, row));
    EXPECT_EQ(std::isnan(shape_columns().back().of(shape)), !shape.row);
  };
  const auto receive_shape = [&](std::uint32_t serial, std::uint32_t source, std::int32_t object, std::uint32_t vertices) {
    receive(ObjectShape{.source = source, .serial = serial, .object = object, .part = {.total = vertices}});
    receive(ShapeStart{.source = source, .serial = serial, .before = serial - 1, .object = object, .total = vertices});
  };
  receive_shape(1, 5, 0, 3);
  receive_shape(1, 5, 1, 7);
  receive_shape(2, 5, 0, 4);  // another number of vertices: the object of another scene
  receive_shape(3, 5, 0, 3);
  receive_start(4);
  receive_start(1, 6);
  receive_shape(2, 6, 0, 4);
  receive_shape(3, 6, 0, 4);
  collector.finish(take);
  EXPECT_EQ(rows,
            std::vector<std::string>({"0.0.1 0", "0.1.1 0", "0.0.2 none", "0.0.3 1", "0.0.4 none", "1.0.1 none", "1.0.2 0", "1.0.3 1"}));
}

}  // namespace
}  // namespace hapton
