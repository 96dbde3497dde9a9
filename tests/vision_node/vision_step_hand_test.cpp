// The hand that the mouse leads begins at the device point; the probe that the hub reports decides how it is led.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/time_units.h"
#include "tests/vision_node/made_surface.h"
#include "tests/vision_node/vision_step_fixture.h"

namespace hapton {
namespace {

WindowEvent left_button(WindowEvent::Kind kind) {
  WindowEvent event;
  event.kind = kind;
  event.button = WindowEvent::Button::left;
  event.x_px = 350;
  event.y_px = 360;
  return event;
}

TEST_F(VisionStepTest, TheHandIsLedFromWhereTheDeviceIs) {
  VisionStep step(settings());
  step.note_join();
  ProbeState state = state_at(0.0, 1);
  state.p_WD = Vec3(0.03, 0.01, -0.02);
  step.receive(state);
  step.handle(left_button(WindowEvent::Kind::press), screen_);
  auto hands = take_all<HandTarget>(step, 0);
  ASSERT_EQ(hands.size(), 1u);
  EXPECT_TRUE(hands[0].active);
  EXPECT_EQ(hands[0].p_WH, state.p_WD);
  step.handle(left_button(WindowEvent::Kind::release), screen_);
  take_all<HandTarget>(step, kMs);
  state.p_WD = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  step.receive(state);
  step.handle(left_button(WindowEvent::Kind::press), screen_);
  hands = take_all<HandTarget>(step, 2 * kMs);
  ASSERT_EQ(hands.size(), 1u);
  EXPECT_TRUE(hands[0].p_WH.allFinite()) << "no hand is sent to nowhere";
}

// The back of the sheet is as far away as its front: only the visual offset of a contact tells that the hand touches the back.
TEST_F(VisionStepTest, ALedHandThatTouchesTheBackOfASheetComesOutBesideItFirst) {
  const double sheet_m = screen_.screen.distance_m;
  const auto is_on_sheet = [](double x, double y) { return std::hypot(x - 320.0, y - 360.0) < 80.0; };
  const VisibleDepth seen = make_visible_depth(screen_.screen, screen_.picture, [&](double x, double y) {
    return is_on_sheet(x, y) ? sheet_m : std::numeric_limits<double>::infinity();
  });
  VisionStep step(settings());
  step.note_join();
  ProbeState state = state_at(0.0, 1);
  state.visual_offset_m = Vec3(0.0, 0.0, -0.003);
  state.p_WD = seen.place({310.0, 365.0}, sheet_m) - state.visual_offset_m;
  state.contact = true;
  step.receive(state);
  step.handle(left_button(WindowEvent::Kind::press), screen_, seen.find({350.0, 360.0}));
  const auto goal = take_all<HandTarget>(step, 0);
  ASSERT_EQ(goal.size(), 1u);
  step.lead_hand(&seen);
  const auto out = take_all<HandTarget>(step, kMs);
  ASSERT_EQ(out.size(), 1u);
  const Vec2 pixel = seen.pixel_of(out[0].p_WH);
  EXPECT_FALSE(is_on_sheet(pixel.x(), pixel.y())) << pixel.transpose();
  state.contact = false;
  step.receive(state);
  step.lead_hand(&seen);
  const auto straight = take_all<HandTarget>(step, 2 * kMs);
  ASSERT_EQ(straight.size(), 1u);
  EXPECT_EQ(straight[0].p_WH, goal[0].p_WH) << "without contact the tip is on the front";
}

}  // namespace
}  // namespace hapton
