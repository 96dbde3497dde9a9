#include "vision_node/interaction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "tests/support/time_units.h"
#include "tests/vision_node/made_surface.h"

namespace hapton {
namespace {

using Kind = WindowEvent::Kind;
using Button = WindowEvent::Button;

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

// p_WQ is the visible point of the scene under the pointer, p_WE the eye, p_WH where the hand is to move.
class InteractionTest : public testing::Test {
 protected:
  InteractionTest() {
    view_.picture = {640, 720};
    view_.screen = compute_screen(frame_sphere(Vec3::Zero(), 0.12, 0.063), view_.picture);
    view_.p_WD = {0.01, 0.02, 0.03};
  }
  void give(const WindowEvent& event) { interaction_.handle(event, view_); }

  Interaction interaction_;
  Interaction::View view_;
};

TEST_F(InteractionTest, KeysTurnTheDialsBothWays) {
  for (const char c : {'x', 'x', 'y', 'Z'}) give(key(c));
  EXPECT_EQ(interaction_.dials().degrees, Vec3(10.0, 5.0, -5.0));
  for (const char c : {'X', 'X', 'Y', 'z'}) give(key(c));
  EXPECT_EQ(interaction_.dials().degrees, Vec3::Zero());
  give(key('y'));
  give(key('0'));
  EXPECT_EQ(interaction_.dials().degrees, Vec3::Zero());
}

TEST_F(InteractionTest, AKeyHoldsTheStylusButtonWhileTheHandIsLed) {
  give(key('p'));
  EXPECT_FALSE(interaction_.take_hand(1'000'000'000)) << "nobody leads the hand";
  give(key('h'));
  give(key('p'));
  EXPECT_EQ(interaction_.take_hand(2'000'000'000)->buttons, 1U);
  give(key('p'));
  EXPECT_EQ(interaction_.take_hand(3'000'000'000)->buttons, 0U);
  give(key('p'));
  give(key('h'));
  const auto released = interaction_.take_hand(4'000'000'000);
  EXPECT_FALSE(released->active);
  EXPECT_EQ(released->buttons, 0U);
}

TEST_F(InteractionTest, WithControlTheMouseTurnsTheStylusInPlace) {
  WindowEvent event = mouse(Kind::wheel, 320, 360);
  event.control = true;
  event.wheel = 1;
  give(event);
  EXPECT_FALSE(interaction_.take_hand(1'000'000'000)) << "nobody leads the hand";
  give(mouse(Kind::press, 320, 360, Button::left));
  const Vec3 led = interaction_.take_hand(2'000'000'000)->p_WH;
  event = mouse(Kind::move, 410, 360, Button::left);
  event.control = true;
  give(event);
  const HandTarget yawed = *interaction_.take_hand(3'000'000'000);
  EXPECT_EQ(yawed.p_WH, led);
  // turn_rad: yaw, pitch, roll.
  EXPECT_NEAR(yawed.turn_rad.x(), std::numbers::pi / 4, 1e-12);
  EXPECT_EQ(yawed.turn_rad.tail<2>(), Eigen::Vector2d::Zero());
  event = mouse(Kind::wheel, 410, 360);
  event.control = true;
  event.wheel = -1;
  give(event);
  const HandTarget rolled = *interaction_.take_hand(4'000'000'000);
  EXPECT_EQ(rolled.p_WH, led) << "the wheel turns the stylus and does not press deeper";
  EXPECT_LT(rolled.turn_rad.z(), 0.0);
  event.shift = true;
  give(event);
  EXPECT_LT(interaction_.take_hand(4'500'000'000)->turn_rad.x(), yawed.turn_rad.x()) << "with shift it yaws";
  give(mouse(Kind::release, 410, 360, Button::left));
  EXPECT_EQ(interaction_.take_hand(5'000'000'000)->turn_rad, Vec3::Zero());
}

TEST_F(InteractionTest, KeysHoldEachOfTheFirstFourButtons) {
  give(key('2'));
  EXPECT_FALSE(interaction_.take_hand(1'000'000'000)) << "nobody leads the hand";
  give(key('h'));
  const std::pair<char, std::uint32_t> steps[] = {{'2', 0b0010}, {'4', 0b1010}, {'1', 0b1011}, {'p', 0b1010}, {'3', 0b1110}, {'2', 0b1100}};
  for (const auto& [pressed, held] : steps) {
    give(key(pressed));
    EXPECT_EQ(interaction_.take_hand(2'000'000'000)->buttons, held) << pressed;
  }
  give(key('5'));
  EXPECT_FALSE(interaction_.take_hand(2'000'000'000)) << "there is no fifth button";
  give(key('h'));
  EXPECT_EQ(interaction_.take_hand(3'000'000'000)->buttons, 0U) << "released with the hand";
}

TEST_F(InteractionTest, RightDragOrbitsTheSceneWithoutTurningIt) {
  give(mouse(Kind::press, 100, 100, Button::right));
  give(mouse(Kind::move, 110, 100));
  EXPECT_LT(interaction_.camera().yaw_rad, 0.0) << "the picture follows the mouse";
  EXPECT_EQ(interaction_.camera().pitch_rad, 0.0);
  give(mouse(Kind::move, 110, 90));
  EXPECT_GT(interaction_.camera().pitch_rad, 0.0);
  const CameraView before = interaction_.camera();
  give(mouse(Kind::release, 110, 90, Button::right));
  give(mouse(Kind::move, 300, 300));
  EXPECT_EQ(interaction_.camera(), before);
  EXPECT_EQ(interaction_.dials().degrees, Vec3::Zero());
  EXPECT_FALSE(interaction_.take_hand(0)) << "the right button never moves the hand";
}

TEST_F(InteractionTest, ShiftOrTheMiddleButtonMovesThePictureWithTheMouse) {
  for (const auto& [button, shift] : {std::pair(Button::right, true), std::pair(Button::middle, false)}) {
    interaction_.camera() = {};
    const Framing home = frame_sphere(Vec3::Zero(), 0.12, 0.063);
    give(mouse(Kind::press, 100, 100, button, shift));
    give(mouse(Kind::move, 130, 90, Button::none, shift));
    give(mouse(Kind::release, 130, 90, button, shift));
    const StereoScreen moved = compute_screen(interaction_.camera().apply(home), view_.picture);
    const Vec2 moved_px = project_to_pixel(moved, Eye::centre, view_.picture, Vec3::Zero()) -
                          project_to_pixel(view_.screen, Eye::centre, view_.picture, Vec3::Zero());
    EXPECT_LT((moved_px - Vec2(30.0, -10.0)).norm(), 1e-6);
    EXPECT_EQ(interaction_.dials().degrees, Vec3::Zero());
  }
}

TEST_F(InteractionTest, TheWheelAndKeysZoomAndRResetsTheCamera) {
  WindowEvent notch = mouse(Kind::wheel, 0, 0);
  notch.wheel = 1;
  give(notch);
  EXPECT_GT(interaction_.camera().zoom, 1.0);
  notch.wheel = -1;
  give(notch);
  EXPECT_NEAR(interaction_.camera().zoom, 1.0, 1e-12);
  give(key('+'));
  EXPECT_GT(interaction_.camera().zoom, 1.0);
  give(key('r'));
  EXPECT_EQ(interaction_.camera(), CameraView{});
}

TEST_F(InteractionTest, TheHandIsLedSlightlyInsideTheSurfaceUnderThePointer) {
  const Vec3 p_WE = compute_eye_position(view_.screen, Eye::centre);
  view_.p_WQ = Vec3(0.02, 0.01, 0.05);
  give(mouse(Kind::press, 100, 100, Button::left));
  const auto depth_of = [&](const HandTarget& hand) { return (hand.p_WH - *view_.p_WQ).dot((*view_.p_WQ - p_WE).normalized()); };
  auto hand = interaction_.take_hand(0);
  ASSERT_TRUE(hand);
  const double first = depth_of(*hand);
  EXPECT_GT(first, 0.0005);
  EXPECT_LT(first, 0.01);
  view_.p_WQ = Vec3(0.03, 0.0, 0.02);
  give(mouse(Kind::move, 120, 90));
  hand = interaction_.take_hand(kMs);
  ASSERT_TRUE(hand);
  EXPECT_NEAR(depth_of(*hand), first, 1e-12) << "the same depth below the new point";
  EXPECT_LT((hand->p_WH - *view_.p_WQ).norm(), 1.001 * first);
  WindowEvent notch = mouse(Kind::wheel, 120, 90);
  notch.wheel = 2;
  give(notch);
  hand = interaction_.take_hand(2 * kMs);
  EXPECT_GT(depth_of(*hand), 1.5 * first);
  notch.wheel = -10;
  give(notch);
  hand = interaction_.take_hand(3 * kMs);
  EXPECT_LT(depth_of(*hand), 0.0) << "lifted off";
  EXPECT_EQ(interaction_.camera(), CameraView{}) << "the wheel does not zoom while the hand is led";
}

TEST_F(InteractionTest, WithThePointerBesideTheSceneTheHandKeepsItsDepth) {
  view_.p_WQ = Vec3(0.02, 0.01, 0.05);
  give(mouse(Kind::press, 100, 100, Button::left));
  const double depth = interaction_.take_hand(0)->p_WH.z();
  view_.p_WQ.reset();
  give(mouse(Kind::move, 150, 120));
  EXPECT_NEAR(interaction_.take_hand(kMs)->p_WH.z(), depth, 1e-12);
}

TEST_F(InteractionTest, TheHandPassesInFrontOfAWallOnTheWayToItsGoal) {
  const VisibleDepth seen = make_surface(view_.screen, view_.picture, [&](double x, double) {
    return std::abs(x - 320.0) < 40.0 ? view_.screen.distance_m - 0.08 : view_.screen.distance_m;
  });
  view_.p_WQ = seen.find({100.0, 360.0});
  give(mouse(Kind::press, 100, 360, Button::left));
  const Vec3 start = interaction_.take_hand(0)->p_WH;
  interaction_.follow(seen, {*view_.p_WQ});
  EXPECT_FALSE(interaction_.take_hand(kMs)) << "it is at its goal: nothing to send";
  const Vec3 p_WP = *view_.p_WQ;
  view_.p_WQ = seen.find({540.0, 360.0});
  give(mouse(Kind::move, 540, 360));
  const Vec3 goal = interaction_.take_hand(2 * kMs)->p_WH;
  interaction_.follow(seen, {p_WP});
  auto hand = interaction_.take_hand(3 * kMs);
  ASSERT_TRUE(hand);
  EXPECT_LT(seen.depth_of(hand->p_WH), view_.screen.distance_m - 0.08) << "towards the viewer first";
  EXPECT_NEAR(seen.pixel_of(hand->p_WH).x(), 100.0, 1.0);
  interaction_.follow(seen, {seen.place({500.0, 360.0}, view_.screen.distance_m - 0.085)});
  hand = interaction_.take_hand(4 * kMs);
  ASSERT_TRUE(hand);
  EXPECT_EQ(hand->p_WH, goal) << "past the wall";
  EXPECT_NE(goal, start);
}

TEST_F(InteractionTest, LeftDragTakesTheHandFromWhereTheProbeIsAndMovesItWithTheMouse) {
  give(mouse(Kind::press, 100, 100, Button::left));
  auto hand = interaction_.take_hand(0);
  ASSERT_TRUE(hand);
  EXPECT_TRUE(hand->active);
  EXPECT_EQ(hand->p_WH, view_.p_WD);
  const Vec2 before = project_to_pixel(view_.screen, Eye::centre, view_.picture, hand->p_WH);
  give(mouse(Kind::move, 140, 90));
  hand = interaction_.take_hand(kMs);
  ASSERT_TRUE(hand);
  const Vec2 after = project_to_pixel(view_.screen, Eye::centre, view_.picture, hand->p_WH);
  EXPECT_NEAR(after.x() - before.x(), 40.0, 1e-6);
  EXPECT_NEAR(after.y() - before.y(), -10.0, 1e-6);
  EXPECT_NEAR(hand->p_WH.z(), view_.p_WD.z(), 1e-12);
}

TEST_F(InteractionTest, WheelMovesTheLedHandInDepth) {
  WindowEvent notch = mouse(Kind::wheel, 0, 0);
  notch.wheel = 1;
  give(notch);
  EXPECT_FALSE(interaction_.take_hand(0)) << "nobody leads the hand";
  interaction_.camera() = {};
  give(mouse(Kind::press, 0, 0, Button::left));
  give(notch);
  const auto hand = interaction_.take_hand(0);
  ASSERT_TRUE(hand);
  EXPECT_LT(hand->p_WH.z(), view_.p_WD.z()) << "away from the viewer";
}

TEST_F(InteractionTest, AReleaseIsSentRepeatedlyButNotForEver) {
  give(mouse(Kind::press, 0, 0, Button::left));
  ASSERT_TRUE(interaction_.take_hand(0));
  give(mouse(Kind::release, 0, 0, Button::left));
  int reported = 0;
  for (int ms = 1; ms < 5000; ++ms) {
    if (const auto hand = interaction_.take_hand(ms * kMs)) {
      EXPECT_FALSE(hand->active);
      ++reported;
    }
  }
  EXPECT_GE(reported, 3);
  EXPECT_LE(reported, 6);
}

TEST_F(InteractionTest, ALedHandIsSentAgainWhileItRests) {
  give(mouse(Kind::press, 0, 0, Button::left));
  int reported = 0;
  for (int ms = 0; ms < 1000; ++ms) reported += interaction_.take_hand(ms * kMs).has_value();
  EXPECT_GE(reported, 9);
  EXPECT_LE(reported, 12);
}

TEST_F(InteractionTest, HLatchesTheHandToTheMouse) {
  give(mouse(Kind::move, 50, 50));
  give(key('h'));
  give(mouse(Kind::move, 60, 50));
  EXPECT_TRUE(interaction_.is_hand_led());
  const auto hand = interaction_.take_hand(0);
  ASSERT_TRUE(hand);
  EXPECT_GT(hand->p_WH.x(), view_.p_WD.x());
  give(key('h'));
  EXPECT_FALSE(interaction_.is_hand_led());
}

TEST_F(InteractionTest, RequestsAreTakenOnce) {
  for (const char c : {'b', 's', 'q', 'k'}) give(key(c));
  const UserRequests requests = interaction_.take_requests();
  EXPECT_TRUE(requests.toggle_cull && requests.screenshot && requests.quit && requests.toggle_help);
  for (const char c : {'m', 'e', 'f', 'g', 'n', 'c', 'v', 'V'}) give(key(c));
  const UserRequests more = interaction_.take_requests();
  EXPECT_TRUE(more.toggle_plots && more.next_stereo && more.swap_eyes && more.look_at_scene && more.toggle_depth_cues && more.mark);
  EXPECT_TRUE(more.next_teach && more.next_level);
  EXPECT_FALSE(interaction_.take_requests().quit);
  give(mouse(Kind::close, 0, 0));
  EXPECT_TRUE(interaction_.take_requests().quit);
}

TEST_F(InteractionTest, KeysForAnnotationsAndTheMenuAreTakenOnce) {
  for (const char c : {'d', 'l', 'u', 'U', 'w', 'o', 't'}) give(key(c));
  const UserRequests all = interaction_.take_requests();
  EXPECT_TRUE(all.draw && all.measure && all.undo && all.redo && all.save && all.export_work && all.menu);
  const UserRequests none = interaction_.take_requests();
  EXPECT_FALSE(none.draw || none.measure || none.undo || none.redo || none.save || none.export_work || none.menu);
  EXPECT_FALSE(interaction_.is_hand_led());
}

TEST_F(InteractionTest, ArrowsAndPageKeysMoveTheHeadByACentimetre) {
  using NavigationKey = WindowEvent::NavigationKey;
  const auto navigation_key = [](NavigationKey which) {
    WindowEvent event;
    event.navigation_key = which;
    return event;
  };
  const std::pair<NavigationKey, Vec3> moves[] = {{NavigationKey::left, {-0.01, 0, 0}},    {NavigationKey::right, {0.01, 0, 0}},
                                                  {NavigationKey::up, {0, 0.01, 0}},       {NavigationKey::down, {0, -0.01, 0}},
                                                  {NavigationKey::page_up, {0, 0, -0.01}}, {NavigationKey::page_down, {0, 0, 0.01}}};
  for (const auto& [which, by_m] : moves) {
    give(navigation_key(which));
    give(navigation_key(which));
    EXPECT_EQ(interaction_.take_requests().head_motion_m, 2.0 * by_m);
    EXPECT_TRUE(interaction_.take_requests().head_motion_m.isZero(0.0)) << "once";
  }
  give(navigation_key(NavigationKey::left));
  give(navigation_key(NavigationKey::home));
  const UserRequests back = interaction_.take_requests();
  EXPECT_TRUE(back.reset_head && back.head_motion_m.isZero(0.0));
  EXPECT_FALSE(interaction_.take_requests().reset_head);
  EXPECT_EQ(interaction_.dials().degrees, Vec3::Zero());
}

TEST_F(InteractionTest, AClickDoesNotMoveAHandThatHLatched) {
  give(mouse(Kind::move, 50, 50));
  give(key('h'));
  const Vec3 held = interaction_.take_hand(0)->p_WH;
  view_.p_WD = Vec3(0.05, 0.0, 0.0);  // the device lags behind
  give(mouse(Kind::press, 50, 50, Button::left));
  give(mouse(Kind::release, 50, 50, Button::left));
  EXPECT_TRUE(interaction_.is_hand_led());
  EXPECT_EQ(interaction_.take_hand(1000 * kMs)->p_WH, held);
  give(key('h'));
  EXPECT_FALSE(interaction_.is_hand_led());
}

TEST_F(InteractionTest, TheWheelPressesAndLiftsByALimitedShareOfThePicture) {
  const Vec3 p_WE = compute_eye_position(view_.screen, Eye::centre);
  const double side_m = std::min(view_.screen.width_m, view_.screen.height_m);
  view_.p_WQ = Vec3(0.02, 0.01, 0.05);
  give(mouse(Kind::press, 100, 100, Button::left));
  WindowEvent notches = mouse(Kind::wheel, 100, 100);
  const auto depth_after = [&](int wheel) {
    notches.wheel = wheel;
    give(notches);
    return (interaction_.take_hand(kMs)->p_WH - *view_.p_WQ).dot((*view_.p_WQ - p_WE).normalized());
  };
  EXPECT_NEAR(depth_after(1000), 0.1 * side_m, 1e-9);
  EXPECT_NEAR(depth_after(-1), 0.095 * side_m, 1e-9) << "the first notch back moves it at once";
  EXPECT_NEAR(depth_after(-1000), -0.5 * side_m, 1e-9);
}

TEST_F(InteractionTest, WithControlADragUpwardsRaisesTheRearEndOfTheStylus) {
  give(mouse(Kind::press, 320, 360, Button::left));
  WindowEvent up = mouse(Kind::move, 320, 450, Button::left);
  up.control = true;
  give(up);
  // Pitch is a rotation about x, which points to the right, so it is negative here.
  EXPECT_NEAR(interaction_.take_hand(0)->turn_rad.y(), -std::numbers::pi / 4, 1e-12);
}

}  // namespace
}  // namespace hapton
