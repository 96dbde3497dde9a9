#include "vision_node/space_head.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/support/fake_hid.h"
#include "tests/support/patience.h"

namespace hapton {
namespace {

// The report of a cap that is pushed all the way along one of the device's axes: x right, y towards the person, z down.
// 350 counts (0x015e) are the full deflection.
FakeHid::Bytes push_report(int axis) {
  FakeHid::Bytes report = {1, 0, 0, 0, 0, 0, 0};
  report[1 + 2 * static_cast<std::size_t>(axis)] = 0x5e;
  report[2 + 2 * static_cast<std::size_t>(axis)] = 0x01;
  return report;
}

class SpaceHeadTest : public testing::Test {
 protected:
  bool moves_until(SpaceHead& head, const FakeHid::Bytes& report, const std::function<bool(const Vec3&)>& holds) {
    Vec3 moved = Vec3::Zero();
    return wait_until([&] {
      if (hid_.is_drained()) hid_.send(report);
      moved += head.take_move_m(clock_.now_ns());
      return holds(moved);
    });
  }
  bool rests(SpaceHead& head) {
    return moves_until(head, {1, 0, 0, 0, 0, 0, 0}, [&](const Vec3&) { return head.take_move_m(clock_.now_ns()).isZero(); });
  }

  FakeHid hid_;
  SteadyClock clock_;
};

TEST_F(SpaceHeadTest, EachPushMovesTheHeadThatWay) {
  SpaceHead head(hid_.opener());
  EXPECT_TRUE(moves_until(head, push_report(0), [](const Vec3& moved) { return moved.x() > 0.01 && moved.y() == 0.0; }));
  EXPECT_TRUE(rests(head));
  EXPECT_TRUE(moves_until(head, push_report(1), [](const Vec3& moved) { return moved.z() > 0.01 && moved.y() == 0.0; }));
  EXPECT_TRUE(rests(head));
  EXPECT_TRUE(moves_until(head, push_report(2), [](const Vec3& moved) { return moved.y() < -0.01; }));
}

TEST_F(SpaceHeadTest, ATurnMovesNothing) {
  SpaceHead head(hid_.opener());
  FakeHid::Bytes turned = push_report(0);
  turned[0] = 2;
  for (int n = 0; n < 50; ++n) {
    hid_.send(turned);
    EXPECT_TRUE(head.take_move_m(clock_.now_ns()).isZero());
    clock_.sleep_until_ns(clock_.now_ns() + kNanosecondsPerMillisecond);
  }
  EXPECT_TRUE(moves_until(head, push_report(0), [](const Vec3& moved) { return moved.x() > 0.0; })) << "it was there";
}

// For fine work: half of the travel beyond the dead band (180 of 10 to 350 counts) gives a quarter of the speed.
TEST_F(SpaceHeadTest, TheSpeedGrowsWithTheSquareOfThePush) {
  SpaceHead head(hid_.opener());
  FakeHid::Bytes half = push_report(0);
  half[1] = 0xb4;
  half[2] = 0x00;
  Vec3 leap = Vec3::Zero();
  EXPECT_TRUE(wait_until([&] {
    hid_.send(half);
    (void)head.take_move_m(clock_.now_ns() - kNanosecondsPerSecond);
    leap = head.take_move_m(clock_.now_ns());
    return !leap.isZero();
  }));
  EXPECT_NEAR(leap.x(), 0.25 * 0.1 * SpaceHead::kFullMPerS, 1e-9) << "a frame counts for 0.1 s at most";
}

TEST_F(SpaceHeadTest, ASlowFrameDoesNotMakeTheHeadJump) {
  SpaceHead head(hid_.opener());
  EXPECT_TRUE(moves_until(head, push_report(0), [](const Vec3& moved) { return moved.x() > 0.001; }));
  Vec3 leap = Vec3::Zero();
  EXPECT_TRUE(wait_until([&] {
    hid_.send(push_report(0));
    (void)head.take_move_m(clock_.now_ns() - kNanosecondsPerSecond);
    leap = head.take_move_m(clock_.now_ns());
    return !leap.isZero();
  }));
  EXPECT_LE(leap.x(), 0.1 * SpaceHead::kFullMPerS + 1e-9);
}

}  // namespace
}  // namespace hapton
