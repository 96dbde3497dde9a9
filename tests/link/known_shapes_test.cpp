#include "link/known_shapes.h"

#include <gtest/gtest.h>

#include <vector>

namespace hapton {
namespace {

constexpr std::uint32_t kTotal = 100;  // vertices: two parts
constexpr std::size_t kSkin = 1;       // index of the object that programs deform
constexpr std::int64_t kOneMs = 1'000'000;

// A part of a shape in which each vertex is displaced by as many mm as its serial says.
ObjectShape part_of(std::uint32_t serial, std::uint32_t first, std::uint32_t source = 5) {
  ObjectShape shape{.source = source, .serial = serial, .object = kSkin, .part = {.total = kTotal, .first = first}};
  shape.part.displacements_m.fill({1e-3F * static_cast<float>(serial), 0.0F, 0.0F});
  return shape;
}
ShapeStart start_of(std::uint32_t serial, std::uint32_t before, std::int64_t start_ns, std::int64_t end_ns, std::uint32_t source = 5) {
  return {.source = source, .serial = serial, .before = before, .object = kSkin, .total = kTotal, .start_ns = start_ns, .end_ns = end_ns};
}

class KnownShapesTest : public testing::Test {
 protected:
  void deliver_shape(std::uint32_t serial, std::uint32_t source = 5) {
    for (const std::uint32_t first : {0U, 64U}) known_.take(part_of(serial, first, source), Arrival::newest);
  }
  void deliver_start(std::uint32_t serial, std::uint32_t before, std::int64_t start_ns, std::int64_t end_ns) {
    known_.take(start_of(serial, before, start_ns, end_ns), Arrival::newest);
  }
  // The displacement at this scene time, in mm; -1: it is not known.
  float displaced_mm(std::int64_t at_ns) const {
    const auto place = known_.find(kSkin, at_ns);
    if (!place) return -1.0F;
    const auto all = known_.displacements_m(kSkin, *place);
    EXPECT_EQ(all.size(), kTotal);
    EXPECT_EQ(all.front(), all.back());
    return 1e3F * all.front()[0];
  }

  KnownShapes known_{{0, kTotal}};
};

TEST_F(KnownShapesTest, AtRestUntilAShapeIsAnnounced) {
  EXPECT_EQ(displaced_mm(7), 0.0F);
  deliver_shape(1);
  EXPECT_EQ(displaced_mm(7), 0.0F) << "its start has not come";
  EXPECT_FALSE(known_.find(0, 7)) << "programs do not deform that object";
}

TEST_F(KnownShapesTest, MovesStraightFromShapeToShape) {
  deliver_shape(1);
  deliver_start(1, 0, 100 * kOneMs, 200 * kOneMs);
  deliver_shape(3);
  deliver_start(3, 1, 300 * kOneMs, 400 * kOneMs);
  EXPECT_EQ(displaced_mm(50 * kOneMs), 0.0F);
  EXPECT_FLOAT_EQ(displaced_mm(150 * kOneMs), 0.5F);
  EXPECT_FLOAT_EQ(displaced_mm(250 * kOneMs), 1.0F) << "stays there";
  EXPECT_FLOAT_EQ(displaced_mm(350 * kOneMs), 2.0F);
  EXPECT_FLOAT_EQ(displaced_mm(900 * kOneMs), 3.0F);
  EXPECT_FLOAT_EQ(displaced_mm(150 * kOneMs), 0.5F) << "an earlier sample";
}

// The motion to this shape takes no time.
TEST_F(KnownShapesTest, AShapeMayBeThereAtOnce) {
  deliver_shape(1);
  deliver_start(1, 0, 100 * kOneMs, 100 * kOneMs);
  EXPECT_EQ(displaced_mm(100 * kOneMs), 0.0F);
  EXPECT_FLOAT_EQ(displaced_mm(100 * kOneMs + 1), 1.0F);
}

TEST_F(KnownShapesTest, WhatCameInAnotherOrderIsTheSame) {
  deliver_start(3, 1, 300 * kOneMs, 400 * kOneMs);
  deliver_shape(3);
  deliver_start(1, 0, 100 * kOneMs, 200 * kOneMs);
  deliver_shape(1);
  EXPECT_FLOAT_EQ(displaced_mm(150 * kOneMs), 0.5F);
  EXPECT_FLOAT_EQ(displaced_mm(350 * kOneMs), 2.0F);
}

// A program that joins late learns which shape is the newest. It has no part of that shape, and does not have the shape before.
TEST_F(KnownShapesTest, AMissingShapeIsRequestedAndThenShown) {
  deliver_start(9, 8, 100 * kOneMs, 200 * kOneMs);
  EXPECT_EQ(displaced_mm(150 * kOneMs), -1.0F);
  EXPECT_FALSE(known_.take_request(0)) << "it may be on its way";
  EXPECT_FALSE(known_.take_request(59 * kOneMs));
  const auto request = known_.take_request(60 * kOneMs);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->source, 5U);
  EXPECT_EQ(request->serial, 9U);
  EXPECT_EQ(request->object, static_cast<std::int32_t>(kSkin));
  EXPECT_EQ(request->first, 0U);
  EXPECT_FALSE(known_.take_request(61 * kOneMs)) << "not without pause";
  known_.take(part_of(9, 0), Arrival::newest);
  const auto rest = known_.take_request(400 * kOneMs);
  ASSERT_TRUE(rest);
  EXPECT_EQ(rest->first, 64U);
  known_.take(part_of(9, 64), Arrival::newest);
  EXPECT_FALSE(known_.take_request(900 * kOneMs));
  EXPECT_FLOAT_EQ(displaced_mm(150 * kOneMs), 9.0F) << "in that shape, although the motion to it is not known";
}

// For a program that prepares the next shape: the first one whose motion has not ended, else the newest.
TEST_F(KnownShapesTest, TheNextShapeThatIsWholeIsFound) {
  EXPECT_EQ(known_.newest_start(kSkin), nullptr);
  EXPECT_EQ(known_.find_next(kSkin, 0, 0), nullptr);
  deliver_start(1, 0, 100 * kOneMs, 200 * kOneMs);
  ASSERT_NE(known_.newest_start(kSkin), nullptr);
  EXPECT_EQ(known_.newest_start(kSkin)->serial, 1U);
  EXPECT_EQ(known_.find_next(kSkin, 0, 0), nullptr) << "not whole";
  for (const std::uint32_t serial : {2U, 4U, 5U}) {
    deliver_shape(serial);
    deliver_start(serial, serial - 1, serial * 100 * kOneMs, (serial + 1) * 100 * kOneMs);
  }
  const auto next = [&](std::uint32_t after, std::int64_t at_ns) {
    const ShapeStart* found = known_.find_next(kSkin, after, at_ns);
    return found != nullptr ? found->serial : 0;
  };
  EXPECT_EQ(next(0, 0), 2U);
  EXPECT_EQ(next(0, 299 * kOneMs), 2U);
  EXPECT_EQ(next(0, 300 * kOneMs), 4U) << "2 is over, 3 did not come";
  EXPECT_EQ(next(2, 0), 4U);
  EXPECT_EQ(next(2, 9000 * kOneMs), 5U) << "all are over";
  EXPECT_EQ(next(5, 0), 0U);
  EXPECT_EQ(known_.find_start(kSkin, 4)->start_ns, 400 * kOneMs);
  EXPECT_EQ(known_.find_start(kSkin, 3), nullptr);
  EXPECT_EQ(known_.find_next(kSkin + 1, 0, 0), nullptr) << "no such object";
}

// Each announced shape is requested once: one request for each run of missing parts.
TEST_F(KnownShapesTest, MissingPartsAreRequestedAhead) {
  constexpr std::uint32_t kParts = 40;
  KnownShapes known({kParts * ShapePart::kVerticesPerPart - 3});
  const auto take_part = [&](std::uint32_t serial, std::uint32_t part) {
    known.take(ObjectShape{.source = 5, .serial = serial, .part = {.total = kParts * 64 - 3, .first = part * 64}}, Arrival::newest);
  };
  const auto announce = [&](std::uint32_t serial) {
    known.take(ShapeStart{.source = 5, .serial = serial, .before = serial - 1, .total = kParts * 64 - 3, .end_ns = 1}, Arrival::newest);
  };
  const auto requests_at = [&](std::int64_t now_ns) {
    std::vector<ShapeStatus> all;
    known.take_requests_ahead(now_ns, all);
    return all;
  };
  for (std::uint32_t part = 0; part < kParts; ++part) {
    take_part(1, part);
    if (part != 3 && part != 7 && part != 8 && part != 39) take_part(2, part);
    if (part % 3 == 0) take_part(3, part);
  }
  announce(1);
  announce(2);
  EXPECT_TRUE(requests_at(0).empty()) << "they may be on their way";
  EXPECT_TRUE(requests_at(24 * kOneMs).empty());
  announce(3);
  announce(4);
  const auto requests_for_2 = requests_at(25 * kOneMs);
  ASSERT_EQ(requests_for_2.size(), 3U);
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> runs = {{3 * 64, 64}, {7 * 64, 128}, {39 * 64, 64}};
  for (std::size_t n = 0; n < runs.size(); ++n) {
    EXPECT_EQ(requests_for_2[n].serial, 2U);
    EXPECT_EQ(requests_for_2[n].source, 5U);
    EXPECT_EQ(std::pair(requests_for_2[n].first, requests_for_2[n].count), runs[n]) << n;
  }
  const auto later = requests_at(50 * kOneMs);
  ASSERT_EQ(later.size(), 9U);
  for (std::size_t n = 0; n < 8; ++n) {
    EXPECT_EQ(later[n].serial, 3U);
    EXPECT_EQ(later[n].first, (3 * n + 1) * 64);
    EXPECT_EQ(later[n].count, n < 7 ? 128U : (kParts - 22) * 64) << "the last run goes to the end";
  }
  EXPECT_EQ(std::pair(later[8].serial, later[8].count), std::pair(4U, kParts * 64)) << "nothing of it has come";
  EXPECT_TRUE(requests_at(900 * kOneMs).empty()) << "once";
}

TEST_F(KnownShapesTest, AnObjectMayBeAddedLater) {
  KnownShapes known;
  known.take(start_of(1, 0, 0, 1), Arrival::newest);
  EXPECT_FALSE(known.find(kSkin, 5)) << "nothing is known of it";
  known.add_object(kSkin, kTotal);
  EXPECT_TRUE(known.find(kSkin, 5));
  known.take(start_of(1, 0, 0, 1), Arrival::newest);
  EXPECT_EQ(known.find(kSkin, 5), KnownShapes::Place{}) << "its shape is missing";
  EXPECT_NE(known.newest_start(kSkin), nullptr);
  known.add_object(kSkin, kTotal);
  EXPECT_NE(known.newest_start(kSkin), nullptr) << "as before";
  known.add_object(kSkin, kTotal + 1);
  EXPECT_EQ(known.newest_start(kSkin), nullptr) << "another mesh";
}

TEST_F(KnownShapesTest, ForgetsTheObjectsThatAreNotKept) {
  deliver_start(1, 0, 0, 1);
  known_.add_object(3, 7);
  known_.add_object(4, 7);
  EXPECT_EQ(known_.count_objects(), 3U);
  known_.keep_objects({kSkin, 4, 9});
  EXPECT_EQ(known_.count_objects(), 2U);
  EXPECT_NE(known_.newest_start(kSkin), nullptr);
  EXPECT_FALSE(known_.find(3, 5));
  EXPECT_TRUE(known_.find(4, 5));
}

// As many shapes wait for their start as a surface can have (StreamedGeometry), and the picture still shows an earlier one.
TEST_F(KnownShapesTest, ShapesThatWaitDoNotHideThePresentOne) {
  for (std::uint32_t serial = 1; serial <= 10; ++serial) {
    deliver_shape(serial);
    deliver_start(serial, serial - 1, serial * 100 * kOneMs, (serial + 1) * 100 * kOneMs);
  }
  EXPECT_FLOAT_EQ(displaced_mm(150 * kOneMs), 0.5F);
}

TEST_F(KnownShapesTest, ALostShapeIsLeftOut) {
  deliver_shape(1);
  deliver_start(1, 0, 100 * kOneMs, 200 * kOneMs);
  deliver_start(2, 1, 200 * kOneMs, 300 * kOneMs);
  EXPECT_FLOAT_EQ(displaced_mm(250 * kOneMs), 1.0F);
  deliver_shape(3);
  deliver_start(3, 2, 300 * kOneMs, 400 * kOneMs);
  EXPECT_FLOAT_EQ(displaced_mm(350 * kOneMs), 3.0F);
}

TEST_F(KnownShapesTest, AnotherProcessBeginsAtRest) {
  deliver_shape(1);
  deliver_start(1, 0, 100 * kOneMs, 200 * kOneMs);
  known_.take(ShapeStart{.source = 7, .object = kSkin, .total = kTotal}, Arrival::newest);
  EXPECT_EQ(displaced_mm(900 * kOneMs), 0.0F);
  known_.take(start_of(2, 1, 100 * kOneMs, 200 * kOneMs, 5), Arrival::reordered);
  EXPECT_EQ(displaced_mm(900 * kOneMs), 0.0F) << "of the process that was replaced";
}

TEST_F(KnownShapesTest, AShapeOfAnotherSceneIsIgnored) {
  ShapeStart start = start_of(1, 0, 1, 2);
  for (const std::int32_t object : {0, 2, -1}) {
    start.object = object;
    known_.take(start, Arrival::newest);
  }
  start.object = kSkin;
  start.total = kTotal + 1;
  known_.take(start, Arrival::newest);
  ObjectShape shape = part_of(1, 0);
  shape.object = 0;
  known_.take(shape, Arrival::newest);
  EXPECT_EQ(displaced_mm(900 * kOneMs), 0.0F);
  EXPECT_FALSE(known_.take_request(900 * kOneMs));
}

// However many shapes come, only as many are kept as a picture needs.
TEST_F(KnownShapesTest, ThousandsOfShapesKeepTheNewest) {
  for (std::uint32_t serial = 1; serial < 5000; ++serial) {
    deliver_shape(serial);
    deliver_start(serial, serial - 1, 10 * kOneMs * serial, 10 * kOneMs * (serial + 1));
  }
  EXPECT_FLOAT_EQ(displaced_mm(10 * kOneMs * 5001), 4999.0F);
  EXPECT_FLOAT_EQ(displaced_mm(10 * kOneMs * 4998 + 5 * kOneMs), 4997.5F) << "a sample ago";
}

TEST_F(KnownShapesTest, TheNextShapeIsGivenTimeToComeAlsoWhereTheOneBeforeIsMissing) {
  deliver_start(1, 0, 100 * kOneMs, 200 * kOneMs);
  EXPECT_FALSE(known_.take_request(0));
  const std::int64_t due_ns = 60 * kOneMs;
  ASSERT_TRUE(known_.take_request(due_ns));
  deliver_start(2, 1, 200 * kOneMs, 300 * kOneMs);
  const std::int64_t begun_ns = due_ns + 199 * kOneMs;
  EXPECT_FALSE(known_.take_request(begun_ns)) << "its parts may be on their way";
  EXPECT_FALSE(known_.take_request(begun_ns + 59 * kOneMs));
  const auto request = known_.take_request(begun_ns + 60 * kOneMs);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->serial, 2U);
}

}  // namespace
}  // namespace hapton
