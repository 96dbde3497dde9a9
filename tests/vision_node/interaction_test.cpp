#include "vision_node/interaction.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

using Kind = WindowEvent::Kind;
using Button = WindowEvent::Button;
constexpr std::int64_t kMs = 1'000'000;

WindowEvent key(char c) {
  WindowEvent event;
  event.key = c;
  return event;
}

WindowEvent mouse(Kind kind, int x, int y, Button button = Button::none, bool shift = false) {
  WindowEvent event;
  event.kind = kind;
  event.x_px = x;
  event.y_px = y;
  event.button = button;
  event.shift = shift;
  return event;
}

class InteractionTest : public testing::Test {
 protected:
  InteractionTest() {
    view_.picture = {640, 720};
    view_.screen = compute_screen(frame_sphere(Vec3::Zero(), 0.12, 0.063), view_.picture);
    view_.p_WD = {0.01, 0.02, 0.03};
  }
  void give(const WindowEvent& event) { hands_.handle(event, view_); }

  Interaction hands_;
  Interaction::View view_;
};

TEST_F(InteractionTest, KeysTurnTheDialsBothWays) {
  for (const char c : {'x', 'x', 'y', 'Z'}) give(key(c));
  EXPECT_EQ(hands_.dials().degrees, Vec3(10.0, 5.0, -5.0));
  for (const char c : {'X', 'X', 'Y', 'z'}) give(key(c));
  EXPECT_EQ(hands_.dials().degrees, Vec3::Zero());
  give(key('y'));
  give(key('0'));
  EXPECT_EQ(hands_.dials().degrees, Vec3::Zero());
}

TEST_F(InteractionTest, RightDragTurnsAndShiftRolls) {
  give(mouse(Kind::press, 100, 100, Button::right));
  give(mouse(Kind::move, 110, 100));
  EXPECT_GT(hands_.dials().degrees.y(), 0.0);
  EXPECT_EQ(hands_.dials().degrees.x(), 0.0);
  give(mouse(Kind::move, 110, 120));
  EXPECT_LT(hands_.dials().degrees.x(), 0.0);
  give(mouse(Kind::move, 130, 120, Button::none, true));
  EXPECT_LT(hands_.dials().degrees.z(), 0.0);
  const Vec3 before = hands_.dials().degrees;
  give(mouse(Kind::release, 130, 120, Button::right));
  give(mouse(Kind::move, 300, 300));
  EXPECT_EQ(hands_.dials().degrees, before);
  EXPECT_FALSE(hands_.take_hand(0)) << "the right button never moves the hand";
}

TEST_F(InteractionTest, LeftDragTakesTheHandFromWhereTheProbeIsAndMovesItWithTheMouse) {
  give(mouse(Kind::press, 100, 100, Button::left));
  auto hand = hands_.take_hand(0);
  ASSERT_TRUE(hand);
  EXPECT_TRUE(hand->active);
  EXPECT_EQ(hand->p_WH, view_.p_WD);
  const Vec2 before = project_to_pixel(view_.screen, Eye::centre, view_.picture, hand->p_WH);
  give(mouse(Kind::move, 140, 90));
  hand = hands_.take_hand(kMs);
  ASSERT_TRUE(hand);
  const Vec2 after = project_to_pixel(view_.screen, Eye::centre, view_.picture, hand->p_WH);
  EXPECT_NEAR(after.x() - before.x(), 40.0, 1e-6);
  EXPECT_NEAR(after.y() - before.y(), -10.0, 1e-6);
  EXPECT_NEAR(hand->p_WH.z(), view_.p_WD.z(), 1e-12);
}

TEST_F(InteractionTest, WheelMovesTheHeldHandInDepth) {
  WindowEvent notch = mouse(Kind::wheel, 0, 0);
  notch.wheel = 1;
  give(notch);
  EXPECT_FALSE(hands_.take_hand(0)) << "no hand is held";
  give(mouse(Kind::press, 0, 0, Button::left));
  give(notch);
  const auto hand = hands_.take_hand(0);
  ASSERT_TRUE(hand);
  EXPECT_LT(hand->p_WH.z(), view_.p_WD.z()) << "away from the viewer";
}

TEST_F(InteractionTest, LettingGoIsToldAndToldAgainButNotForEver) {
  give(mouse(Kind::press, 0, 0, Button::left));
  ASSERT_TRUE(hands_.take_hand(0));
  give(mouse(Kind::release, 0, 0, Button::left));
  int told = 0;
  for (int ms = 1; ms < 5000; ++ms) {
    if (const auto hand = hands_.take_hand(ms * kMs)) {
      EXPECT_FALSE(hand->active);
      ++told;
    }
  }
  EXPECT_GE(told, 3);
  EXPECT_LE(told, 6);
}

TEST_F(InteractionTest, AHeldHandIsToldAgainWhileItRests) {
  give(mouse(Kind::press, 0, 0, Button::left));
  int told = 0;
  for (int ms = 0; ms < 1000; ++ms) told += hands_.take_hand(ms * kMs).has_value();
  EXPECT_GE(told, 9);
  EXPECT_LE(told, 12);
}

TEST_F(InteractionTest, HLatchesTheHandToTheMouse) {
  give(mouse(Kind::move, 50, 50));
  give(key('h'));
  give(mouse(Kind::move, 60, 50));
  EXPECT_TRUE(hands_.hand_active());
  const auto hand = hands_.take_hand(0);
  ASSERT_TRUE(hand);
  EXPECT_GT(hand->p_WH.x(), view_.p_WD.x());
  give(key('h'));
  EXPECT_FALSE(hands_.hand_active());
}

TEST_F(InteractionTest, WishesAreToldOnce) {
  for (const char c : {'b', 's', 'q', 'k'}) give(key(c));
  const Wishes wishes = hands_.take_wishes();
  EXPECT_TRUE(wishes.toggle_cull && wishes.screenshot && wishes.quit && wishes.toggle_help);
  EXPECT_FALSE(hands_.take_wishes().quit);
  give(mouse(Kind::close, 0, 0));
  EXPECT_TRUE(hands_.take_wishes().quit);
}

}  // namespace
}  // namespace hapton
