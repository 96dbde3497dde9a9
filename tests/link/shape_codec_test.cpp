// What datagrams may contain about the shapes of objects that programs deform.
#include <gtest/gtest.h>

#include <limits>

#include "tests/link/codec_fixture.h"

namespace hapton {
namespace {

constexpr std::uint32_t kPartVertices = ShapePart::kVerticesPerPart;

struct ShapeCodecTest : CodecTest {
  ShapeRequest good{.stream = 1, .shape = 2, .object = {"skin"}, .over_s = 0.03, .part = {.total = 150, .first = 128}};

  ShapeCodecTest() {
    for (std::size_t v = 0; v < good.part.count(); ++v) good.part.displacements_m[v] = {0.001F * static_cast<float>(v), -0.25F, 1e-7F};
  }
  template <class Change>
  DecodeStatus with(Change&& change) {
    ShapeRequest changed = good;
    change(changed);
    return round_trip(changed);
  }
};

TEST_F(ShapeCodecTest, APartComesAsItWasSent) {
  ASSERT_EQ(good.part.count(), 22U);
  ASSERT_EQ(round_trip(good), DecodeStatus::ok);
  expect_equal(std::get<ShapeRequest>(decoded_.message), good);
  for (const std::uint32_t total : {1U, kPartVertices - 1, kPartVertices, kPartVertices + 1, ShapePart::kMaxVertices}) {
    for (std::uint32_t first = 0; first < total; first += kPartVertices) {
      EXPECT_EQ(with([&](ShapeRequest& m) { m.part = {.total = total, .first = first}; }), DecodeStatus::ok) << total << " " << first;
    }
  }
}

// A decoded part keeps nothing of a longer part that the same message object held before.
TEST_F(ShapeCodecTest, AShorterPartHasNothingOfTheOneBefore) {
  ShapeRequest full = good;
  full.part = {.total = 150};
  full.part.displacements_m.fill({1, 2, 3});
  ASSERT_EQ(round_trip(full), DecodeStatus::ok);
  ASSERT_EQ(round_trip(good), DecodeStatus::ok);
  EXPECT_EQ(std::get<ShapeRequest>(decoded_.message).part.displacements_m[30], (ShapePart::Displacement{}));
}

TEST_F(ShapeCodecTest, WhatNoPartMayHaveIsABadValue) {
  EXPECT_EQ(with([](ShapeRequest& m) { m.stream = 0; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](ShapeRequest& m) { m.shape = 0; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](ShapeRequest& m) { m.number = -1; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](ShapeRequest& m) { m.part = {}; }), DecodeStatus::bad_value) << "of no vertices";
  EXPECT_EQ(with([](ShapeRequest& m) { m.part = {.total = ShapePart::kMaxVertices + 1}; }), DecodeStatus::bad_value);
  EXPECT_EQ(with([](ShapeRequest& m) { m.part = {.total = 64, .first = 64}; }), DecodeStatus::bad_value) << "beyond the end";
  EXPECT_EQ(with([](ShapeRequest& m) { m.part = {.total = 640, .first = 63}; }), DecodeStatus::bad_value) << "between two parts";
  for (const double seconds : {-1e-9, 86'401.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(with([&](ShapeRequest& m) { m.over_s = seconds; }), DecodeStatus::bad_value) << seconds;
  }
  for (const float x : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 2e9F, -2e9F}) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(with([&](ShapeRequest& m) { m.part.displacements_m[21][k] = x; }), DecodeStatus::bad_value) << x;
    }
  }
}

TEST_F(ShapeCodecTest, AStartIsAfterTheShapeBefore) {
  const ShapeStart start{.source = 1, .serial = 7, .before = 6, .object = 2, .total = 150, .start_ns = 5, .end_ns = 9};
  const auto with_start = [&](auto&& change) {
    ShapeStart other = start;
    change(other);
    return round_trip(other);
  };
  ASSERT_EQ(round_trip(start), DecodeStatus::ok);
  expect_equal(std::get<ShapeStart>(decoded_.message), start);
  EXPECT_EQ(with_start([](ShapeStart& m) { m.before = 7; }), DecodeStatus::bad_value);
  EXPECT_EQ(with_start([](ShapeStart& m) { m.serial = 0; }), DecodeStatus::bad_value) << "at rest, and yet a shape before";
  EXPECT_EQ(with_start([](ShapeStart& m) { m.serial = m.before = 0; }), DecodeStatus::ok);
  EXPECT_EQ(with_start([](ShapeStart& m) { m.source = 0; }), DecodeStatus::bad_value);
  EXPECT_EQ(with_start([](ShapeStart& m) { m.total = 0; }), DecodeStatus::bad_value);
  EXPECT_EQ(with_start([](ShapeStart& m) { m.total = ShapePart::kMaxVertices + 1; }), DecodeStatus::bad_value);
  EXPECT_EQ(with_start([](ShapeStart& m) { m.start_ns = -1; }), DecodeStatus::bad_value);
  EXPECT_EQ(with_start([](ShapeStart& m) { m.end_ns = 4; }), DecodeStatus::bad_value);
}

TEST_F(ShapeCodecTest, ARequestAndAReplyNameWhatTheyAreAbout) {
  EXPECT_EQ(round_trip(ShapeStatus{.source = 1, .serial = 1, .first = 64}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(ShapeStatus{.serial = 1}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(ShapeStatus{.source = 1}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(ShapeStatus{.source = 1, .serial = 1, .first = 1}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(ShapeStatus{.source = 1, .serial = 1, .first = 64, .count = 128}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(ShapeStatus{.source = 1, .serial = 1, .first = 64, .count = 65}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(ShapeStatus{.source = 1, .serial = 1, .first = 64, .count = 12'800}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(ShapeReply{.stream = 1, .shape = 1, .over_s = 0.5}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(ShapeReply{.shape = 1}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(ShapeReply{.stream = 1}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(ShapeReply{.stream = 1, .shape = 1, .over_s = -1.0}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(ObjectShape{.source = 1, .serial = 1, .part = {.total = 3}}), DecodeStatus::ok);
  EXPECT_EQ(round_trip(ObjectShape{.serial = 1, .part = {.total = 3}}), DecodeStatus::bad_value);
  EXPECT_EQ(round_trip(ObjectShape{.source = 1, .part = {.total = 3}}), DecodeStatus::bad_value);
}

}  // namespace
}  // namespace hapton
