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
  void handle(const WindowEvent& event) { interaction_.handle(event, view_); }

  Interaction interaction_;
  Interaction::View view_;
};

TEST_F(InteractionTest, KeysTurnTheDialsBothWays) {
  for (const char c : {'x', 'x', 'y', 'Z'}) handle(key(c));
  EXPECT_EQ(interaction_.dials().degrees, Vec3(10.0, 5.0, -5.0));
  for (const char c : {'X', 'X', 'Y', 'z'}) handle(key(c));
  EXPECT_EQ(interaction_.dials().degrees, Vec3::Zero());
  handle(key('y'));
  handle(key('0'));
  EXPECT_EQ(interaction_.dials().degrees, Vec3::Zero());
}

TEST_F(InteractionTest, AKeyHoldsTheStylusButtonWhileTheHandIsLed) {
  handle(key('p'));
  EXPECT_FALSE(interaction_.take_hand(1'000'000'000)) << "nobody leads the hand";
  handle(key('h'));
  handle(key('p'));
  EXPECT_EQ(interaction_.take_hand(2'000'000'000)->buttons, 1U);
  handle(key('p'));
  EXPECT_EQ(interaction_.take_hand(3'000'000'000)->buttons, 0U);
  handle(key('p'));
  handle(key('h'));
  const auto released = interaction_.take_hand(4'000'000'000);
  EXPECT_FALSE(released->active);
  EXPECT_EQ(released->buttons, 0U);
}

TEST_F(InteractionTest, WithControlTheMouseTurnsTheStylusInPlace) {
  WindowEvent event = mouse(Kind::wheel, 320, 360);
  event.control = true;
  event.wheel = 1;
  handle(event);
  EXPECT_FALSE(interaction_.take_hand(1'000'000'000)) << "nobody leads the hand";
  handle(mouse(Kind::press, 320, 360, Button::left));
  const Vec3 led = interaction_.take_hand(2'000'000'000)->p_WH;
  event = mouse(Kind::move, 410, 360, Button::left);
  event.control = true;
  handle(event);
  const HandTarget yawed = *interaction_.take_hand(3'000'000'000);
  EXPECT_EQ(yawed.p_WH, led);
  // turn_rad: yaw, pitch, roll. The mouse turns the stylus by half a degree for each of 90 pixels.
  EXPECT_NEAR(yawed.turn_rad.x(), std::numbers::pi / 4, 1e-12);
  EXPECT_EQ(yawed.turn_rad.tail<2>(), Eigen::Vector2d::Zero());
  event = mouse(Kind::wheel, 410, 360);
  event.control = true;
  event.wheel = -1;
  handle(event);
  const HandTarget rolled = *interaction_.take_hand(4'000'000'000);
  EXPECT_EQ(rolled.p_WH, led) << "the wheel turns the stylus and does not press deeper";
  EXPECT_LT(rolled.turn_rad.z(), 0.0);
  event.shift = true;
  handle(event);
  EXPECT_LT(interaction_.take_hand(4'500'000'000)->turn_rad.x(), yawed.turn_rad.x()) << "with shift it yaws";
  handle(mouse(Kind::release, 410, 360, Button::left));
  EXPECT_EQ(interaction_.take_hand(5'000'000'000)->turn_rad, Vec3::Zero());
}

TEST_F(InteractionTest, KeysHoldEachOfTheFirstFourButtons) {
  handle(key('2'));
  EXPECT_FALSE(interaction_.take_hand(1'000'000'000)) << "nobody leads the hand";
  handle(key('h'));
  const std::pair<char, std::uint32_t> steps[] = {{'2', 0b0010}, {'4', 0b1010}, {'1', 0b1011}, {'p', 0b1010}, {'3', 0b1110}, {'2', 0b1100}};
  for (const auto& [pressed, held] : steps) {
    handle(key(pressed));
    EXPECT_EQ(interaction_.take_hand(2'000'000'000)->buttons, held) << pressed;
  }
  handle(key('5'));
  EXPECT_FALSE(interaction_.take_hand(2'000'000'000)) << "there is no fifth button";
  handle(key('h'));
  EXPECT_EQ(interaction_.take_hand(3'000'000'000)->buttons, 0U) << "released with the hand";
}

TEST_F(InteractionTest, RightDragOrbitsTheSceneWithoutTurningIt) {
  handle(mouse(Kind::press, 100, 100, Button::right));
  handle(mouse(Kind::move, 110, 100));
  EXPECT_LT(interaction_.camera().yaw_rad, 0.0) << "the picture follows the mouse";
  EXPECT_EQ(interaction_.camera().pitch_rad, 0.0);
  handle(mouse(Kind::move, 110, 90));
  EXPECT_GT(interaction_.camera().pitch_rad, 0.0);
  const CameraView before = interaction_.camera();
  handle(mouse(Kind::release, 110, 90, Button::right));
  handle(mouse(Kind::move, 300, 300));
  EXPECT_EQ(interaction_.camera(), before);
  EXPECT_EQ(interaction_.dials().degrees, Vec3::Zero());
  EXPECT_FALSE(interaction_.take_hand(0)) << "the right button never moves the hand";
}

TEST_F(InteractionTest, ShiftOrTheMiddleButtonMovesThePictureWithTheMouse) {
  for (const auto& [button, shift] : {std::pair(Button::right, true), std::pair(Button::middle, false)}) {
    interaction_.camera() = {};
    const Framing home = frame_sphere(Vec3::Zero(), 0.12, 0.063);
    handle(mouse(Kind::press, 100, 100, button, shift));
    handle(mouse(Kind::move, 130, 90, Button::none, shift));
    handle(mouse(Kind::release, 130, 90, button, shift));
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
  handle(notch);
  EXPECT_GT(interaction_.camera().zoom, 1.0);
  notch.wheel = -1;
  handle(notch);
  EXPECT_NEAR(interaction_.camera().zoom, 1.0, 1e-12);
  handle(key('+'));
  EXPECT_GT(interaction_.camera().zoom, 1.0);
  handle(key('r'));
  EXPECT_EQ(interaction_.camera(), CameraView{});
}

TEST_F(InteractionTest, TheHandIsLedSlightlyInsideTheSurfaceUnderThePointer) {
  const Vec3 p_WE = compute_eye_position(view_.screen, Eye::centre);
  view_.p_WQ = Vec3(0.02, 0.01, 0.05);
  handle(mouse(Kind::press, 100, 100, Button::left));
  const auto depth_of = [&](const HandTarget& hand) { return (hand.p_WH - *view_.p_WQ).dot((*view_.p_WQ - p_WE).normalized()); };
  auto hand = interaction_.take_hand(0);
  ASSERT_TRUE(hand);
  const double first_depth_m = depth_of(*hand);
  EXPECT_GT(first_depth_m, 0.0005);
  EXPECT_LT(first_depth_m, 0.01);
  view_.p_WQ = Vec3(0.03, 0.0, 0.02);
  handle(mouse(Kind::move, 120, 90));
  hand = interaction_.take_hand(kMs);
  ASSERT_TRUE(hand);
  EXPECT_NEAR(depth_of(*hand), first_depth_m, 1e-12) << "the same depth below the new point";
  EXPECT_LT((hand->p_WH - *view_.p_WQ).norm(), 1.001 * first_depth_m);
  WindowEvent notch = mouse(Kind::wheel, 120, 90);
  notch.wheel = 2;
  handle(notch);
  hand = interaction_.take_hand(2 * kMs);
  EXPECT_GT(depth_of(*hand), 1.5 * first_depth_m);
  notch.wheel = -10;
  handle(notch);
  hand = interaction_.take_hand(3 * kMs);
  EXPECT_LT(depth_of(*hand), 0.0) << "lifted off";
  EXPECT_EQ(interaction_.camera(), CameraView{}) << "the wheel does not zoom while the hand is led";
}

TEST_F(InteractionTest, WithThePointerBesideTheSceneTheHandKeepsItsDepth) {
  view_.p_WQ = Vec3(0.02, 0.01, 0.05);
  handle(mouse(Kind::press, 100, 100, Button::left));
  const double depth = interaction_.take_hand(0)->p_WH.z();
  view_.p_WQ.reset();
  handle(mouse(Kind::move, 150, 120));
  EXPECT_NEAR(interaction_.take_hand(kMs)->p_WH.z(), depth, 1e-12);
}

TEST_F(InteractionTest, TheHandPassesInFrontOfAWallOnTheWayToItsGoal) {
  const VisibleDepth visible = make_visible_depth(view_.screen, view_.picture, [&](double x, double) {
    return std::abs(x - 320.0) < 40.0 ? view_.screen.distance_m - 0.08 : view_.screen.distance_m;
  });
  view_.p_WQ = visible.find({100.0, 360.0});
  handle(mouse(Kind::press, 100, 360, Button::left));
  const Vec3 start = interaction_.take_hand(0)->p_WH;
  interaction_.follow(visible, {*view_.p_WQ});
  EXPECT_FALSE(interaction_.take_hand(kMs)) << "it is at its goal: nothing to send";
  const Vec3 p_WP = *view_.p_WQ;
  view_.p_WQ = visible.find({540.0, 360.0});
  handle(mouse(Kind::move, 540, 360));
  const Vec3 goal = interaction_.take_hand(2 * kMs)->p_WH;
  interaction_.follow(visible, {p_WP});
  auto hand = interaction_.take_hand(3 * kMs);
  ASSERT_TRUE(hand);
  EXPECT_LT(visible.depth_of(hand->p_WH), view_.screen.distance_m - 0.08) << "towards the viewer first";
  EXPECT_NEAR(visible.pixel_of(hand->p_WH).x(), 100.0, 1.0);
  interaction_.follow(visible, {visible.place({500.0, 360.0}, view_.screen.distance_m - 0.085)});
  hand = interaction_.take_hand(4 * kMs);
  ASSERT_TRUE(hand);
  EXPECT_EQ(hand->p_WH, goal) << "past the wall";
  EXPECT_NE(goal, start);
}

TEST_F(InteractionTest, LeftDragLeadsTheHandFromWhereTheProbeIsAndMovesItWithTheMouse) {
  handle(mouse(Kind::press, 100, 100, Button::left));
  auto hand = interaction_.take_hand(0);
  ASSERT_TRUE(hand);
  EXPECT_TRUE(hand->active);
  EXPECT_EQ(hand->p_WH, view_.p_WD);
  const Vec2 before = project_to_pixel(view_.screen, Eye::centre, view_.picture, hand->p_WH);
  handle(mouse(Kind::move, 140, 90));
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
  handle(notch);
  EXPECT_FALSE(interaction_.take_hand(0)) << "nobody leads the hand";
  interaction_.camera() = {};
  handle(mouse(Kind::press, 0, 0, Button::left));
  handle(notch);
  const auto hand = interaction_.take_hand(0);
  ASSERT_TRUE(hand);
  EXPECT_LT(hand->p_WH.z(), view_.p_WD.z()) << "away from the viewer";
}

TEST_F(InteractionTest, AReleaseIsSentRepeatedlyButNotForEver) {
  handle(mouse(Kind::press, 0, 0, Button::left));
  ASSERT_TRUE(interaction_.take_hand(0));
  handle(mouse(Kind::release, 0, 0, Button::left));
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
  handle(mouse(Kind::press, 0, 0, Button::left));
  int reported = 0;
  for (int ms = 0; ms < 1000; ++ms) reported += interaction_.take_hand(ms * kMs).has_value();
  EXPECT_GE(reported, 9);
  EXPECT_LE(reported, 12);
}

TEST_F(InteractionTest, HLatchesTheHandToTheMouse) {
  handle(mouse(Kind::move, 50, 50));
  handle(key('h'));
  handle(mouse(Kind::move, 60, 50));
  EXPECT_TRUE(interaction_.is_hand_led());
  const auto hand = interaction_.take_hand(0);
  ASSERT_TRUE(hand);
  EXPECT_GT(hand->p_WH.x(), view_.p_WD.x());
  handle(key('h'));
  EXPECT_FALSE(interaction_.is_hand_led());
}

TEST_F(InteractionTest, RequestsAreTakenOnce) {
  for (const char c : {'b', 's', 'q', 'k'}) handle(key(c));
  const UserRequests requests = interaction_.take_requests();
  EXPECT_TRUE(requests.toggle_cull && requests.screenshot && requests.quit && requests.toggle_help);
  for (const char c : {'m', 'e', 'f', 'g', 'n', 'c', 'v', 'V'}) handle(key(c));
  const UserRequests more = interaction_.take_requests();
  EXPECT_TRUE(more.toggle_plots && more.next_stereo && more.swap_eyes && more.look_at_scene && more.toggle_depth_cues && more.mark);
  EXPECT_TRUE(more.next_teach && more.next_level);
  EXPECT_FALSE(interaction_.take_requests().quit);
  handle(mouse(Kind::close, 0, 0));
  EXPECT_TRUE(interaction_.take_requests().quit);
}

TEST_F(InteractionTest, KeysForAnnotationsAndTheMenuAreTakenOnce) {
  for (const char c : {'d', 'l', 'u', 'U', 'w', 'o', 't'}) handle(key(c));
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
    handle(navigation_key(which));
    handle(navigation_key(which));
    EXPECT_EQ(interaction_.take_requests().head_motion_m, 2.0 * by_m);
    EXPECT_TRUE(interaction_.take_requests().head_motion_m.isZero(0.0)) << "once";
  }
  handle(navigation_key(NavigationKey::left));
  handle(navigation_key(NavigationKey::home));
  const UserRequests back = interaction_.take_requests();
  EXPECT_TRUE(back.reset_head && back.head_motion_m.isZero(0.0));
  EXPECT_FALSE(interaction_.take_requests().reset_head);
  EXPECT_EQ(interaction_.dials().degrees, Vec3::Zero());
}

TEST_F(InteractionTest, AClickDoesNotMoveAHandThatHLatched) {
  handle(mouse(Kind::move, 50, 50));
  handle(key('h'));
  const Vec3 p_WH_latched = interaction_.take_hand(0)->p_WH;
  view_.p_WD = Vec3(0.05, 0.0, 0.0);  // the device lags behind
  handle(mouse(Kind::press, 50, 50, Button::left));
  handle(mouse(Kind::release, 50, 50, Button::left));
  EXPECT_TRUE(interaction_.is_hand_led());
  EXPECT_EQ(interaction_.take_hand(1000 * kMs)->p_WH, p_WH_latched);
  handle(key('h'));
  EXPECT_FALSE(interaction_.is_hand_led());
}

TEST_F(InteractionTest, TheWheelPressesAndLiftsByALimitedShareOfThePicture) {
  const Vec3 p_WE = compute_eye_position(view_.screen, Eye::centre);
  const double side_m = std::min(view_.screen.width_m, view_.screen.height_m);
  view_.p_WQ = Vec3(0.02, 0.01, 0.05);
  handle(mouse(Kind::press, 100, 100, Button::left));
  WindowEvent notches = mouse(Kind::wheel, 100, 100);
  const auto depth_after = [&](int wheel) {
    notches.wheel = wheel;
    handle(notches);
    return (interaction_.take_hand(kMs)->p_WH - *view_.p_WQ).dot((*view_.p_WQ - p_WE).normalized());
  };
  EXPECT_NEAR(depth_after(1000), 0.1 * side_m, 1e-9);
  EXPECT_NEAR(depth_after(-1), 0.095 * side_m, 1e-9) << "the first notch back moves it at once";
  EXPECT_NEAR(depth_after(-1000), -0.5 * side_m, 1e-9);
}

TEST_F(InteractionTest, WithControlADragUpwardsRaisesTheRearEndOfTheStylus) {
  handle(mouse(Kind::press, 320, 360, Button::left));
  WindowEvent up = mouse(Kind::move, 320, 450, Button::left);
  up.control = true;
  handle(up);
  // Pitch is a rotation about x, which points to the right, so it is negative here.
  EXPECT_NEAR(interaction_.take_hand(0)->turn_rad.y(), -std::numbers::pi / 4, 1e-12);
}

}  // namespace
}  // namespace hapton
