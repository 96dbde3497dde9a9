#include "vision_node/space_knobs.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/support/fake_hid.h"
#include "tests/support/patience.h"

namespace hapton {
namespace {

// The report of a cap that is turned all the way about one of the device's axes: x right, y towards the person, z down.
// 350 counts (0x015e) are the full deflection.
FakeHid::Bytes turn_report(int axis) {
  FakeHid::Bytes report = {2, 0, 0, 0, 0, 0, 0};
  report[1 + 2 * static_cast<std::size_t>(axis)] = 0x5e;
  report[2 + 2 * static_cast<std::size_t>(axis)] = 0x01;
  return report;
}

class SpaceKnobsTest : public testing::Test {
 protected:
  bool turns_until(SpaceKnobs& knobs, const FakeHid::Bytes& report, const std::function<bool(const Vec3&)>& holds) {
    Vec3 degrees = Vec3::Zero();
    return wait_until([&] {
      if (hid_.is_drained()) hid_.send(report);
      degrees += knobs.take_turn_degrees(clock_.now_ns());
      return holds(degrees);
    });
  }

  FakeHid hid_;
  SteadyClock clock_;
};

TEST_F(SpaceKnobsTest, EachAxisOfTheCapTurnsItsDial) {
  SpaceKnobs knobs(hid_.opener());
  EXPECT_TRUE(turns_until(knobs, turn_report(0), [](const Vec3& degrees) { return degrees.x() > 5.0 && degrees.y() == 0.0; }));
  EXPECT_TRUE(turns_until(knobs, {2, 0, 0, 0, 0, 0, 0}, [&](const Vec3&) { return knobs.take_turn_degrees(clock_.now_ns()).isZero(); }));
  EXPECT_TRUE(turns_until(knobs, turn_report(1), [](const Vec3& degrees) { return degrees.z() > 5.0; }));
  EXPECT_TRUE(turns_until(knobs, {2, 0, 0, 0, 0, 0, 0}, [&](const Vec3&) { return knobs.take_turn_degrees(clock_.now_ns()).isZero(); }));
  EXPECT_TRUE(turns_until(knobs, turn_report(2), [](const Vec3& degrees) { return degrees.y() < -5.0; }));
}

TEST_F(SpaceKnobsTest, WithoutOneNothingTurnsUntilOneIsPluggedIn) {
  hid_.unplug();
  SpaceKnobs knobs(hid_.opener());
  EXPECT_TRUE(knobs.take_turn_degrees(clock_.now_ns()).isZero());
  EXPECT_TRUE(knobs.take_turn_degrees(clock_.now_ns()).isZero());
  hid_.plug_in();
  EXPECT_TRUE(turns_until(knobs, turn_report(0), [](const Vec3& degrees) { return degrees.x() > 1.0; }));
}

TEST_F(SpaceKnobsTest, ASlowFrameDoesNotMakeTheSceneJump) {
  SpaceKnobs knobs(hid_.opener());
  EXPECT_TRUE(turns_until(knobs, turn_report(0), [](const Vec3& degrees) { return degrees.x() > 1.0; }));
  Vec3 leap = Vec3::Zero();
  EXPECT_TRUE(wait_until([&] {
    hid_.send(turn_report(0));
    (void)knobs.take_turn_degrees(clock_.now_ns() - kNanosecondsPerSecond);
    leap = knobs.take_turn_degrees(clock_.now_ns());
    return !leap.isZero();
  }));
  EXPECT_LE(leap.x(), 0.1 * SpaceKnobs::kFullDegreesPerS + 1e-9);
}

}  // namespace
}  // namespace hapton
