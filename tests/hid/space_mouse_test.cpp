#include "hid/space_mouse.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace hapton {
namespace {

constexpr std::int64_t kNowNs = 5'000'000'000;

std::vector<std::uint8_t> report(std::uint8_t id, const std::vector<int>& axes) {
  std::vector<std::uint8_t> bytes = {id};
  for (const int axis : axes) {
    bytes.push_back(static_cast<std::uint8_t>(axis));
    bytes.push_back(static_cast<std::uint8_t>(axis >> 8));
  }
  return bytes;
}

// Debian's eigen prints badly in failures: compare by distance.
void expect_near(const Vec3& a, const Vec3& b) { EXPECT_LT((a - b).norm(), 1e-12) << a.transpose() << " is not " << b.transpose(); }

TEST(SpaceMouseDecoder, OlderDevicesReportThreeAxesAtATime) {
  SpaceMouseDecoder decoder;
  EXPECT_TRUE(decoder.take(report(1, {350, 0, 0}), kNowNs));
  EXPECT_TRUE(decoder.take(report(2, {0, 0, -350}), kNowNs));
  expect_near(decoder.state(kNowNs).push, Vec3(1, 0, 0));
  expect_near(decoder.state(kNowNs).turn, Vec3(0, 1, 0));
}

TEST(SpaceMouseDecoder, NewerDevicesReportAllSixAxesInOneReport) {
  SpaceMouseDecoder decoder;
  EXPECT_TRUE(decoder.take(report(1, {0, 350, 0, 350, 0, 0}), kNowNs));
  expect_near(decoder.state(kNowNs).push, Vec3(0, 0, 1));
  expect_near(decoder.state(kNowNs).turn, Vec3(1, 0, 0));
}

// Axes of the device: x to the right, y towards the person, z down towards the desk.
TEST(SpaceMouseDecoder, UpIsUpAndTowardsThePersonIsZ) {
  SpaceMouseDecoder decoder;
  decoder.take(report(1, {0, 0, -350}), kNowNs);
  expect_near(decoder.state(kNowNs).push, Vec3(0, 1, 0));
  decoder.take(report(1, {0, -350, 0}), kNowNs);
  expect_near(decoder.state(kNowNs).push, Vec3(0, 0, -1));
  decoder.take(report(2, {0, -350, 0}), kNowNs);
  expect_near(decoder.state(kNowNs).turn, Vec3(0, 0, -1));
}

TEST(SpaceMouseDecoder, TheDeadBandIsZeroAndContinuousAtItsEdge) {
  SpaceMouseDecoder decoder;
  decoder.take(report(1, {10, -10, 3}), kNowNs);
  EXPECT_TRUE(decoder.state(kNowNs).is_at_rest());
  decoder.take(report(1, {11, 0, 0}), kNowNs);
  EXPECT_NEAR(decoder.state(kNowNs).push.x(), 1.0 / 340.0, 1e-12);
  decoder.take(report(1, {32767, -32768, 0}), kNowNs);
  expect_near(decoder.state(kNowNs).push, Vec3(1, 0, -1));
}

TEST(SpaceMouseDecoder, ACapWithoutReportsIsAtRestAfterAWhileEachHalfForItself) {
  SpaceMouseDecoder decoder;
  decoder.take(report(1, {350, 0, 0}), kNowNs);
  decoder.take(report(2, {350, 0, 0}), kNowNs + SpaceMouseDecoder::kStaleNs);
  expect_near(decoder.state(kNowNs + SpaceMouseDecoder::kStaleNs).push, Vec3(1, 0, 0));
  EXPECT_TRUE(decoder.state(kNowNs + SpaceMouseDecoder::kStaleNs + 1).push.isZero());
  EXPECT_FALSE(decoder.state(kNowNs + SpaceMouseDecoder::kStaleNs + 1).turn.isZero());
  EXPECT_FALSE(decoder.state(kNowNs + 2 * SpaceMouseDecoder::kStaleNs).turn.isZero());
  EXPECT_TRUE(decoder.state(kNowNs + 2 * SpaceMouseDecoder::kStaleNs + 1).turn.isZero());
}

TEST(SpaceMouseDecoder, ButtonsAreBitsOfOneToFourBytesAndDoNotGoStale) {
  SpaceMouseDecoder decoder;
  EXPECT_TRUE(decoder.take(std::vector<std::uint8_t>{3, 2}, kNowNs));
  EXPECT_EQ(decoder.state(kNowNs + 10'000'000'000).buttons, 2U);
  decoder.take(std::vector<std::uint8_t>{3, 1, 0, 0, 0x80, 0xff, 0xff}, kNowNs);
  EXPECT_EQ(decoder.state(kNowNs).buttons, 0x80000001U);
  decoder.take(std::vector<std::uint8_t>{3, 0}, kNowNs);
  EXPECT_EQ(decoder.state(kNowNs).buttons, 0U);
}

TEST(SpaceMouseDecoder, BatteriesUnknownAndShortReportsChangeNothing) {
  SpaceMouseDecoder decoder;
  for (const auto& bytes :
       std::vector<std::vector<std::uint8_t>>{{}, {1}, {1, 2, 3, 4, 5, 6}, {2, 1}, {3}, {0x17, 99}, {0x1c, 1, 2, 3, 4, 5, 6, 7}}) {
    EXPECT_FALSE(decoder.take(bytes, kNowNs));
  }
  EXPECT_TRUE(decoder.state(kNowNs).is_at_rest());
}

TEST(SpaceMouseDecoder, AnyBytesLeavePushAndTurnWithinOne) {
  std::mt19937_64 random(2);
  SpaceMouseDecoder decoder;
  for (int trial = 0; trial < 100'000; ++trial) {
    std::vector<std::uint8_t> bytes(random() % 20);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    if (!bytes.empty()) bytes[0] %= 5;
    decoder.take(bytes, kNowNs);
    const SpaceMouseState state = decoder.state(kNowNs);
    ASSERT_TRUE(state.push.cwiseAbs().maxCoeff() <= 1.0 && state.turn.cwiseAbs().maxCoeff() <= 1.0);
  }
}

}  // namespace
}  // namespace hapton
