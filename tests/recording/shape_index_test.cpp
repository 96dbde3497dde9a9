#include "recording/shape_index.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <vector>

#include "recording/recording_index.h"
#include "recording/recording_shapes.h"
#include "tests/recording/made_recording.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

constexpr double kLookAheadS = 0.2;  // before its message, a shape is found by this time

ShapeStart shape_start(std::uint32_t serial, std::int64_t start_ms, std::int32_t object = 0, std::uint32_t source = 5) {
  return {.source = source,
          .serial = serial,
          .before = serial > 0 ? serial - 1 : 0,
          .object = object,
          .total = 200,
          .start_ns = start_ms * 1'000'000,
          .end_ns = (start_ms + 30) * 1'000'000};
}

ObjectShape shape_part(std::uint32_t serial, std::uint32_t first, std::uint32_t source = 5) {
  ObjectShape part{.source = source, .serial = serial, .part = {.total = 200, .first = first}};
  part.part.displacements_m.fill({static_cast<float>(serial), static_cast<float>(first), 0.0F});
  return part;
}

std::uint32_t serial_at(const ShapeIndex& index, double t_s, std::int32_t object = 0) {
  const IndexedShape* shape = index.find(object, t_s, kLookAheadS, std::llround(1e9 * t_s));
  return shape != nullptr ? shape->start.serial : 0;
}

TEST(ShapeIndex, AMomentHasTheMotionThatBeganLast) {
  ShapeIndex index;
  index.add(ForceCommand{.scene_time_ns = 0});
  for (std::uint32_t n = 1; n <= 40; ++n) {
    ShapeStart start = shape_start(n, 1000 + 30 * n, n % 2 == 0 ? 1 : 0);
    start.before = n > 2 ? n - 2 : 0;
    index.add(start, 1.0 + 0.03 * n + 0.004);
    index.add(start, 1.0 + 0.03 * n + 0.1);                 // repeated
    index.add(shape_start(0, 0, 2), 1.0 + 0.03 * n + 0.1);  // an object at rest
  }
  EXPECT_EQ(index.all().size(), 40U);
  EXPECT_EQ(serial_at(index, 1.0), 0U);
  EXPECT_EQ(serial_at(index, 1.031), 1U) << "before it was recorded";
  EXPECT_EQ(serial_at(index, 1.031, 1), 0U);
  EXPECT_EQ(serial_at(index, 1.93), 29U) << "where it begins, it is where the one before has ended";
  EXPECT_EQ(serial_at(index, 1.931), 31U);
  EXPECT_EQ(serial_at(index, 1.931, 1), 30U);
  EXPECT_EQ(serial_at(index, 9.0), 39U);
  EXPECT_EQ(serial_at(index, 9.0, 2), 0U);
  const IndexedShape* last = index.find(1, 9.0, kLookAheadS, 9'000'000'000);
  ASSERT_NE(last, nullptr);
  const IndexedShape* before = index.find_before(last->start);
  ASSERT_NE(before, nullptr);
  EXPECT_EQ(before->start.serial, 38U);
  EXPECT_EQ(index.find_before(shape_start(1, 0)), nullptr) << "from rest";
}

TEST(ShapeIndex, AnotherProcessBeginsAtRest) {
  ShapeIndex index;
  index.add(ForceCommand{.scene_time_ns = 0});
  index.add(shape_start(7, 1000), 1.0);
  index.add(shape_start(0, 0, 0, 6), 2.0);
  index.add(shape_start(0, 0, 0, 6), 2.5);
  index.add(shape_start(1, 1500, 0, 6), 3.0);
  ASSERT_EQ(index.all().size(), 3U);
  EXPECT_EQ(serial_at(index, 1.9), 7U) << "the other one has not come, though it is known soon";
  EXPECT_EQ(serial_at(index, 2.1), 0U);
  EXPECT_EQ(serial_at(index, 3.1), 1U);
  EXPECT_EQ(index.find(0, 3.1, kLookAheadS, 1'400'000'000), nullptr) << "in its own scene time";
}

// Before the first shape was recorded, the one that comes first counts, though another process follows within the time ahead.
TEST(ShapeIndex, BeforeAllShapesTheFirstProcessCounts) {
  ShapeIndex index;
  index.add(ForceCommand{.scene_time_ns = 0});
  index.add(shape_start(7, 800), 1.0);
  EXPECT_EQ(serial_at(index, 0.9), 7U) << "the only one";
  index.add(shape_start(0, 0, 0, 6), 1.05);
  index.add(shape_start(1, 850, 0, 6), 1.08);
  ASSERT_EQ(index.all().size(), 3U);
  EXPECT_EQ(serial_at(index, 0.9), 7U);
  EXPECT_EQ(serial_at(index, 0.7), 0U) << "farther ahead than that";
}

// The start of a shape is repeated, and its parts come on request.
TEST(ShapeIndex, AShapeFromBeforeTheRecordingIsThereFromItsBeginning) {
  ShapeIndex index;
  index.add(ForceCommand{.scene_time_ns = 5'000'000'000});
  index.add(shape_start(3, 100), 0.7);
  index.add(shape_part(3, 0), 700);
  index.add(shape_part(3, 64), 710);
  index.add(shape_start(4, 5800), 0.8);
  ASSERT_EQ(index.all().size(), 2U);
  const IndexedShape* shape = index.find(0, 0.0, kLookAheadS, 5'000'000'000);
  ASSERT_NE(shape, nullptr);
  EXPECT_EQ(shape->start.serial, 3U);
  EXPECT_EQ(shape->first_position, 700U);
  EXPECT_EQ(shape->last_position, 710U);
}

// The scene time of a later process begins at 0 again, below the first scene time of the recording.
TEST(ShapeIndex, AShapeOfALaterProcessIsNotThereFromTheBeginning) {
  ShapeIndex index;
  index.add(ForceCommand{.scene_time_ns = 5'000'000'000});
  index.add(shape_start(1, 5200), 0.2);
  index.add(shape_start(0, 0, 0, 6), 2.0);
  index.add(shape_start(1, 100, 1, 6), 2.1);
  ASSERT_EQ(index.all().size(), 3U);
  EXPECT_EQ(index.all().front().message.start.source, 5U);
  EXPECT_EQ(index.all().back().t_s, 2.1);
  EXPECT_EQ(index.find(1, 1.0, kLookAheadS, 6'000'000'000), nullptr);
}

TEST(ShapeIndex, PartsThatAreSentAgainAreLeftOut) {
  ShapeIndex index;
  for (const std::uint32_t first : {0U, 64U, 128U}) index.add(shape_part(1, first), 100 + first);
  index.add(shape_start(1, 1000), 1.0);
  index.add(shape_part(1, 64), 900);
  index.add(shape_part(2, 0), 950);
  EXPECT_EQ(index.all()[0].message.first_position, 100U);
  EXPECT_EQ(index.all()[0].message.last_position, 228U);
  index.add(shape_part(1, 192), 1000);
  EXPECT_EQ(index.all()[0].message.last_position, 1000U) << "the one that was lost at first";
  for (std::uint32_t serial = 3; serial < 200; ++serial) index.add(shape_part(serial, 0), 1000 + serial);
  index.add(shape_part(1, 0), 5000);
  EXPECT_EQ(index.all()[0].message.first_position, 100U);
  EXPECT_EQ(index.all()[0].message.last_position, 1000U);
}

// The parts are recorded among the samples, with the parts of another shape between them.
TEST(RecordingShapes, ReadsThePartsOfAShapeWhereTheyAre) {
  const ScratchFolder scratch;
  MadeRecording recording;
  recording.also = [&](std::uint64_t sample) {
    if (sample >= 1000 && sample < 1004) {
      recording.receive(MadeRecording::kHaptics, shape_part(1, static_cast<std::uint32_t>(sample - 1000) * 64), sample);
      recording.receive(MadeRecording::kHaptics, shape_part(2, static_cast<std::uint32_t>(sample - 1000) * 64), sample);
    }
    if (sample == 1004) recording.receive(MadeRecording::kHaptics, shape_start(1, 1004), sample);
    if (sample == 1100) recording.receive(MadeRecording::kHaptics, shape_start(2, 1100), sample);
    if (sample == 1200) recording.receive(MadeRecording::kHaptics, shape_start(3, 1200), sample);
  };
  const auto file = recording.write(scratch);
  auto reader = SessionReader::open(file);
  const auto index = RecordingIndex::read(*reader);
  ASSERT_TRUE(index) << index.error().what;
  ASSERT_EQ(index->shapes().all().size(), 3U);
  auto shapes = RecordingShapes::open(file);
  ASSERT_TRUE(shapes) << shapes.error().what;
  for (const std::size_t n : {1U, 0U, 1U}) {
    const IndexedShape& shape = index->shapes().all()[n].message;
    const auto parts = shapes->read(shape);
    ASSERT_EQ(parts.size(), 4U);
    for (std::size_t p = 0; p < 4; ++p) {
      EXPECT_EQ(parts[p].serial, n + 1);
      EXPECT_EQ(parts[p].part.first, 64 * p);
      EXPECT_EQ(parts[p].part.displacements_m[3][1], 64.0F * static_cast<float>(p));
    }
    EXPECT_LT(shape.last_position - *shape.first_position, 40'000U) << "only the entries of these milliseconds are read";
  }
  EXPECT_TRUE(shapes->read(index->shapes().all()[2].message).empty()) << "none of its parts was recorded";
  EXPECT_FALSE(RecordingShapes::open(scratch.path() / "nowhere.hapton"));
}

}  // namespace
}  // namespace hapton
