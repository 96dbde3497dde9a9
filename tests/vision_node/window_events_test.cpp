#include <memory>

#include <gtest/gtest.h>

#include "tests/support/patience.h"
#include "tests/vision_node/made_views.h"

// Include this last: it brings X's macros, which break other headers.
#include "tests/vision_node/window_person.h"

namespace hapton {
namespace {

using Kind = WindowEvent::Kind;
using Button = WindowEvent::Button;

class WindowEvents : public testing::Test {
 protected:
  void SetUp() override {
    ViewSettings settings = plain_settings(StereoMode::side_by_side, 640, 360);
    settings.offscreen = false;
    view_ = open_or_fail(settings, {{make_marker(Vec3::Zero(), 0.02), {1, 1, 1}}});
    ASSERT_TRUE(view_);
    view_->draw();
    view_->poll_events();
    person_ = std::make_unique<Person>();
    ASSERT_TRUE(person_->has_window());
  }

  // All events received until `count` have come or half a minute has passed.
  std::vector<WindowEvent> receive(std::size_t count) {
    std::vector<WindowEvent> received;
    wait_until([&] {
      for (const auto& event : view_->poll_events()) received.push_back(event);
      return received.size() >= count;
    });
    return received;
  }

  std::unique_ptr<StereoView> view_;
  std::unique_ptr<Person> person_;
};

TEST_F(WindowEvents, KeysArriveWithTheirCase) {
  person_->press_key(XK_y);
  person_->press_key(XK_y, ShiftMask);
  person_->press_key(XK_0);
  const auto received = receive(3);
  ASSERT_EQ(received.size(), 3u);
  for (const auto& event : received) EXPECT_EQ(event.kind, Kind::key);
  EXPECT_EQ(received[0].key, 'y');
  EXPECT_EQ(received[1].key, 'Y');
  EXPECT_EQ(received[2].key, '0');
}

TEST_F(WindowEvents, ShiftArrivesWithTheButtonOfTheMouse) {
  for (const unsigned modifiers : {0U, static_cast<unsigned>(ShiftMask)}) {
    person_->send_button(ButtonPress, Button3, 100, 90, modifiers);
    const auto received = receive(1);
    ASSERT_FALSE(received.empty());
    EXPECT_EQ(received[0].kind, Kind::press);
    EXPECT_EQ(received[0].shift, modifiers != 0);
    person_->send_button(ButtonRelease, Button3, 100, 90, modifiers);
    receive(1);
  }
}

TEST_F(WindowEvents, ArrowsAndPageKeysArriveByName) {
  using NavigationKey = WindowEvent::NavigationKey;
  const std::pair<KeySym, NavigationKey> keys[] = {{XK_Left, NavigationKey::left},     {XK_Right, NavigationKey::right},
                                                   {XK_Up, NavigationKey::up},         {XK_Down, NavigationKey::down},
                                                   {XK_Prior, NavigationKey::page_up}, {XK_Next, NavigationKey::page_down},
                                                   {XK_Home, NavigationKey::home},     {XK_x, NavigationKey::none}};
  for (const auto& [symbol, key] : keys) person_->press_key(symbol);
  const auto received = receive(std::size(keys));
  ASSERT_EQ(received.size(), std::size(keys));
  for (std::size_t n = 0; n < received.size(); ++n) {
    EXPECT_EQ(received[n].kind, Kind::key) << n;
    EXPECT_EQ(received[n].navigation_key, keys[n].second) << n;
  }
}

TEST_F(WindowEvents, NoKeyOfVtkEndsTheProgram) {
  for (const KeySym symbol : {XK_q, XK_e, XK_w, XK_p, XK_r, XK_3, XK_space, XK_Escape, XK_F1}) person_->press_key(symbol);
  receive(9);
  view_->draw();
  EXPECT_TRUE(centroid(view_->read_picture(), 0, 0, 320));
}

TEST_F(WindowEvents, DragArrivesInPixelsFromTheLowerLeft) {
  person_->send_button(ButtonPress, Button1, 100, 50);
  auto received = receive(1);
  person_->move_pointer(130, 60);
  for (const auto& event : receive(1)) received.push_back(event);
  person_->send_button(ButtonRelease, Button1, 130, 60);
  for (const auto& event : receive(1)) received.push_back(event);
  ASSERT_EQ(received.size(), 3u);
  EXPECT_EQ(received[0].kind, Kind::press);
  EXPECT_EQ(received[0].button, Button::left);
  EXPECT_EQ(received[0].x_px, 100);
  EXPECT_EQ(received[0].y_px, 360 - 50 - 1);
  EXPECT_EQ(received[1].kind, Kind::move);
  EXPECT_EQ(received[1].y_px, 360 - 60 - 1);
  EXPECT_EQ(received[2].kind, Kind::release);
}

TEST_F(WindowEvents, RightButtonAndWheel) {
  person_->send_button(ButtonPress, Button3, 5, 5);
  person_->send_button(ButtonPress, Button4, 5, 5);
  person_->send_button(ButtonPress, Button5, 5, 5);
  const auto received = receive(3);
  ASSERT_EQ(received.size(), 3u);
  EXPECT_EQ(received[0].button, Button::right);
  EXPECT_EQ(received[1].kind, Kind::wheel);
  EXPECT_EQ(received[1].wheel, 1);
  EXPECT_EQ(received[2].wheel, -1);
}

TEST_F(WindowEvents, ResizeMakesThePictureStaleAndKeepsItsShape) {
  view_->take_redraw_request();
  person_->resize(800, 300);
  EXPECT_TRUE(wait_until([&] {
    view_->poll_events();
    return view_->take_redraw_request();
  }));
  view_->draw();
  EXPECT_EQ(view_->picture_size(), (PictureSize{400, 300}));
  const auto left = centroid(view_->read_picture(), 0, 0, 400);
  ASSERT_TRUE(left);
  EXPECT_NEAR(left->x(), 200.0, 0.6);
  EXPECT_NEAR(left->y(), 150.0, 0.6);
}

TEST_F(WindowEvents, ClosingIsARequestNotAnAbort) {
  person_->close();
  const auto received = receive(1);
  ASSERT_FALSE(received.empty());
  EXPECT_EQ(received.back().kind, Kind::close);
}

}  // namespace
}  // namespace hapton
