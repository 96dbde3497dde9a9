#include "vision_node/session_control.h"

#include <gtest/gtest.h>

#include "tests/recording/opened_recording.h"
#include "vision_node/time_line.h"

namespace hapton {
namespace {

constexpr PictureSize kControlledPicture{640, 360};

struct ControlledRecording : OpenedRecording {
  SessionPlayer player{index.begin_s(), index.end_s()};
  SessionControl control{index, *rows, player};

  bool key(char key) { return control.handle({.kind = WindowEvent::Kind::key, .key = key}, std::nullopt, kControlledPicture); }
  bool mouse(WindowEvent::Kind kind, int x, int y, int origin_px = 0) {
    const WindowEvent event{.kind = kind,
                            .button = kind == WindowEvent::Kind::move ? WindowEvent::Button::none : WindowEvent::Button::left,
                            .x_px = x + origin_px,
                            .y_px = y};
    return control.handle(event, std::array{x, y}, kControlledPicture);
  }
};

TEST(SessionControl, KeysPauseStepJumpAndChangeTheSpeed) {
  ControlledRecording recording;
  EXPECT_TRUE(recording.key(' '));
  EXPECT_TRUE(recording.player.is_paused());
  recording.player.seek(2.0);
  recording.key('.');
  EXPECT_DOUBLE_EQ(recording.player.moment_s(), 2.001);
  recording.key(',');
  recording.key(',');
  EXPECT_DOUBLE_EQ(recording.player.moment_s(), 1.999);
  recording.key('n');
  EXPECT_NEAR(recording.player.moment_s(), 2.5, 1e-9) << "the fault";
  recording.key('n');
  EXPECT_NEAR(recording.player.moment_s(), 3.5, 1e-9);
  recording.key('N');
  recording.key('N');
  EXPECT_NEAR(recording.player.moment_s(), 1.0, 1e-9);
  recording.key('a');
  EXPECT_EQ(recording.player.moment_s(), recording.player.begin_s());
  recording.key(']');
  EXPECT_EQ(recording.player.speed(), 2.0);
  recording.key('[');
  recording.key('[');
  EXPECT_EQ(recording.player.speed(), 0.5);
  EXPECT_TRUE(recording.control.take_changed());
  EXPECT_FALSE(recording.control.take_changed());
}

TEST(SessionControl, AStepBetweenTwoSamplesGoesToTheNearestOfThem) {
  ControlledRecording recording;
  recording.player.seek(2.0004);
  recording.key('.');
  EXPECT_DOUBLE_EQ(recording.player.moment_s(), 2.001);
  recording.player.seek(2.0004);
  recording.key(',');
  EXPECT_DOUBLE_EQ(recording.player.moment_s(), 1.999) << "2.000 was shown";
}

TEST(SessionControl, OnlyCameraAndOverlayKeysReachTheWindow) {
  ControlledRecording recording;
  for (const char key : std::string("xYz0hpdluUwt")) EXPECT_TRUE(recording.key(key)) << key;
  for (const char key : std::string("rfmebgcskq+-")) EXPECT_FALSE(recording.key(key)) << key;
  EXPECT_FALSE(recording.control.handle({.kind = WindowEvent::Kind::key, .navigation_key = WindowEvent::NavigationKey::left}, std::nullopt,
                                        kControlledPicture));
  EXPECT_FALSE(recording.control.handle({.kind = WindowEvent::Kind::close}, std::nullopt, kControlledPicture));
}

TEST(SessionControl, ADragOnTheLineSeeksAndHoldsWhileItLasts) {
  ControlledRecording recording;
  const TimeLinePlace place = place_time_line(kControlledPicture);
  const int half = kControlledPicture.width_px / 2;
  recording.player.advance(0);
  recording.mouse(WindowEvent::Kind::press, half, 5);
  EXPECT_NEAR(recording.player.moment_s(), 2.0, 0.02);
  EXPECT_FALSE(recording.player.advance(1'000'000'000));
  EXPECT_TRUE(recording.mouse(WindowEvent::Kind::move, half + half / 2, 200)) << "also when the pointer leaves the line";
  EXPECT_NEAR(recording.player.moment_s(), 1e-3 + 3.999 * place.share_at(half + half / 2), 1e-6);
  recording.mouse(WindowEvent::Kind::release, half, 5);
  EXPECT_FALSE(recording.mouse(WindowEvent::Kind::move, half, 5));
  EXPECT_TRUE(recording.player.advance(1'100'000'000)) << "it plays on";
}

// The second picture is the right half of the window, as in mode side_by_side.
TEST(SessionControl, TheLineOfASecondPictureIsDraggedAsWell) {
  ControlledRecording recording;
  recording.mouse(WindowEvent::Kind::press, 320, 5, 640);
  EXPECT_NEAR(recording.player.moment_s(), 2.0, 0.02);
  recording.mouse(WindowEvent::Kind::press, 480, 300, 640);
  EXPECT_NEAR(recording.player.moment_s(), 2.0, 0.02) << "a press on the scene leads no hand, and seeks nothing";
}

}  // namespace
}  // namespace hapton
