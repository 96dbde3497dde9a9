#include "io_node/shape_collector.h"

#include <gtest/gtest.h>

#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

ObjectShape part_of(std::uint32_t source, std::uint32_t serial, std::uint32_t total, std::uint32_t first, std::int32_t object = 0) {
  return {.source = source, .serial = serial, .object = object, .part = {.total = total, .first = first}};
}

TEST_F(NetworkLoops, ARecordingRequestsTheShapeWithWhichItBegins) {
  RecordingTap tap;
  make({}, nullptr, &tap);
  join(kHaptics, NodeRole::haptics);
  const auto start = [this](std::uint32_t source, std::uint32_t serial, std::int32_t object = 0) {
    say(kHaptics, ShapeStart{.source = source, .serial = serial, .object = object, .total = 200});
  };
  start(7, 0, 1);
  run(300);
  EXPECT_TRUE(shape_statuses.empty()) << "object 1 is at rest";
  start(7, 5);
  run(50);
  EXPECT_TRUE(shape_statuses.empty()) << "its parts may be on their way";
  say(kHaptics, part_of(7, 5, 200, 0));
  say(kHaptics, part_of(7, 5, 128, 64));  // not of this shape: another number of vertices
  run(30);
  ASSERT_EQ(shape_statuses.size(), 1U);
  EXPECT_EQ(shape_statuses[0].first, at(kHaptics));
  EXPECT_EQ(shape_statuses[0].second.source, 7U);
  EXPECT_EQ(shape_statuses[0].second.serial, 5U);
  EXPECT_EQ(shape_statuses[0].second.object, 0);
  EXPECT_EQ(shape_statuses[0].second.first, 64U) << "the first one that is missing";
  run(410);
  EXPECT_EQ(shape_statuses.size(), 3U) << "five times a second";
  for (const std::uint32_t first : {64U, 128U, 192U}) say(kHaptics, part_of(7, 5, 200, first));
  run(300);
  EXPECT_EQ(shape_statuses.size(), 3U) << "the shape is complete";
}

TEST_F(NetworkLoops, ARecordingRequestsTheNewestShapeOfEachObjectAndProcess) {
  RecordingTap tap;
  make({}, nullptr, &tap);
  join(kHaptics, NodeRole::haptics);
  const auto start = [this](std::uint32_t source, std::uint32_t serial, std::int32_t object) {
    say(kHaptics, ShapeStart{.source = source, .serial = serial, .object = object, .total = 64});
  };
  start(7, 2, 0);
  start(7, 2, 4);
  start(7, 3, 1);
  say(kHaptics, part_of(7, 4, 64, 0, 1));  // a part of the next shape of object 1, which has not begun
  run(80);
  ASSERT_EQ(shape_statuses.size(), 2U);
  EXPECT_EQ(shape_statuses[0].second.object, 0);
  EXPECT_EQ(shape_statuses[1].second.object, 4);
  EXPECT_EQ(shape_statuses[1].second.serial, 2U);
  EXPECT_EQ(shape_statuses[1].second.first, 0U) << "nothing of it has come";
  start(7, 4, 1);
  for (const std::int32_t object : {0, 4}) say(kHaptics, part_of(7, 2, 64, 0, object));
  run(300);
  EXPECT_EQ(shape_statuses.size(), 2U) << "all is there";
  start(9, 1, 4);
  run(80);
  ASSERT_EQ(shape_statuses.size(), 3U) << "another process";
  EXPECT_EQ(shape_statuses[2].second.source, 9U);
  for (std::int32_t object = 10; object < 30; ++object) start(9, 5, object);
  run(80);
  EXPECT_EQ(shape_statuses.size(), 3U + ShapePart::kMaxObjects - 1) << "one of each new object that there is room for";
}

TEST_F(NetworkLoops, WithoutARecordingNoShapesAreRequested) {
  RecordingTap tap;
  tap.marker_status = MarkerStatus::no_recording;
  make({}, nullptr, &tap);
  join(kHaptics, NodeRole::haptics);
  say(kHaptics, ShapeStart{.source = 7, .serial = 5, .total = 200});
  run(300);
  EXPECT_TRUE(shape_statuses.empty());
}

}  // namespace
}  // namespace hapton
