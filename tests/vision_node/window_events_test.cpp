#include <chrono>
#include <cstring>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "tests/vision_node/made_views.h"

// Last: its macros (None, Success, Bool ...) break other headers.
#include <X11/Xlib.h>
#include <X11/keysym.h>

namespace hapton {
namespace {

using Kind = WindowEvent::Kind;
using Button = WindowEvent::Button;

// Another X client: someone who types, clicks and resizes.
class Person {
 public:
  Person() : display_(XOpenDisplay(nullptr), XCloseDisplay) { window_ = find_window(DefaultRootWindow(display_.get())); }

  bool found() const { return window_ != 0; }

  void press_key(KeySym symbol, unsigned state = 0) {
    XKeyEvent key = {};
    key.type = KeyPress;
    key.window = window_;
    key.root = DefaultRootWindow(display_.get());
    key.keycode = XKeysymToKeycode(display_.get(), symbol);
    key.state = state;
    key.same_screen = True;
    send(key, KeyPressMask);
  }

  void button(int type, unsigned number, int x, int y) {
    XButtonEvent event = {};
    event.type = type;
    event.window = window_;
    event.root = DefaultRootWindow(display_.get());
    event.button = number;
    event.x = x;
    event.y = y;
    event.same_screen = True;
    send(event, type == ButtonPress ? ButtonPressMask : ButtonReleaseMask);
  }

  // The real pointer: VTK asks for it rather than believe the event.
  void move(int x, int y) {
    XWarpPointer(display_.get(), None, window_, 0, 0, 0, 0, x, y);
    XSync(display_.get(), False);
  }

  void close() {
    XClientMessageEvent event = {};
    event.type = ClientMessage;
    event.window = window_;
    event.message_type = XInternAtom(display_.get(), "WM_PROTOCOLS", False);
    event.format = 32;
    event.data.l[0] = static_cast<long>(XInternAtom(display_.get(), "WM_DELETE_WINDOW", False));
    send(event, NoEventMask);
  }

  void resize(unsigned width, unsigned height) {
    XResizeWindow(display_.get(), window_, width, height);
    XSync(display_.get(), False);
  }

 private:
  template <class Event>
  void send(Event event, long mask) {
    XEvent any = {};
    std::memcpy(&any, &event, sizeof event);
    XSendEvent(display_.get(), window_, False, mask, &any);
    XSync(display_.get(), False);
  }

  ::Window find_window(::Window from) {
    char* name = nullptr;
    if (XFetchName(display_.get(), from, &name) != 0 && name != nullptr) {
      const bool ours = std::strcmp(name, "Hapton") == 0;
      XFree(name);
      if (ours) return from;
    }
    ::Window root = 0, parent = 0;
    ::Window* children = nullptr;
    unsigned count = 0;
    ::Window found = 0;
    if (XQueryTree(display_.get(), from, &root, &parent, &children, &count) != 0 && children != nullptr) {
      for (unsigned i = 0; i < count && found == 0; ++i) found = find_window(children[i]);
      XFree(children);
    }
    return found;
  }

  std::unique_ptr<Display, int (*)(Display*)> display_;
  ::Window window_ = 0;
};

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
    ASSERT_TRUE(person_->found());
  }

  // All that is heard until `count` events have come or a second has passed.
  std::vector<WindowEvent> hear(std::size_t count) {
    std::vector<WindowEvent> heard;
    for (int i = 0; i < 100 && heard.size() < count; ++i) {
      for (const auto& event : view_->poll_events()) heard.push_back(event);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return heard;
  }

  std::unique_ptr<StereoView> view_;
  std::unique_ptr<Person> person_;
};

TEST_F(WindowEvents, KeysArriveWithTheirCase) {
  person_->press_key(XK_y);
  person_->press_key(XK_y, ShiftMask);
  person_->press_key(XK_0);
  const auto heard = hear(3);
  ASSERT_EQ(heard.size(), 3u);
  for (const auto& event : heard) EXPECT_EQ(event.kind, Kind::key);
  EXPECT_EQ(heard[0].key, 'y');
  EXPECT_EQ(heard[1].key, 'Y');
  EXPECT_EQ(heard[2].key, '0');
}

TEST_F(WindowEvents, NoKeyEndsTheProgramBehindOurBack) {
  for (const KeySym symbol : {XK_q, XK_e, XK_w, XK_p, XK_r, XK_3, XK_space, XK_Escape, XK_F1}) person_->press_key(symbol);
  hear(9);
  view_->draw();
  EXPECT_TRUE(centroid(view_->read_picture(), 0, 0, 320));
}

TEST_F(WindowEvents, DragArrivesInPixelsFromTheLowerLeft) {
  person_->button(ButtonPress, Button1, 100, 50);
  auto heard = hear(1);
  person_->move(130, 60);
  for (const auto& event : hear(1)) heard.push_back(event);
  person_->button(ButtonRelease, Button1, 130, 60);
  for (const auto& event : hear(1)) heard.push_back(event);
  ASSERT_EQ(heard.size(), 3u);
  EXPECT_EQ(heard[0].kind, Kind::press);
  EXPECT_EQ(heard[0].button, Button::left);
  EXPECT_EQ(heard[0].x_px, 100);
  EXPECT_EQ(heard[0].y_px, 360 - 50 - 1);
  EXPECT_EQ(heard[1].kind, Kind::move);
  EXPECT_EQ(heard[1].y_px, 360 - 60 - 1);
  EXPECT_EQ(heard[2].kind, Kind::release);
}

TEST_F(WindowEvents, RightButtonAndWheel) {
  person_->button(ButtonPress, Button3, 5, 5);
  person_->button(ButtonPress, Button4, 5, 5);
  person_->button(ButtonPress, Button5, 5, 5);
  const auto heard = hear(3);
  ASSERT_EQ(heard.size(), 3u);
  EXPECT_EQ(heard[0].button, Button::right);
  EXPECT_EQ(heard[1].kind, Kind::wheel);
  EXPECT_EQ(heard[1].wheel, 1);
  EXPECT_EQ(heard[2].wheel, -1);
}

TEST_F(WindowEvents, ResizeMakesThePictureStaleAndKeepsItsShape) {
  view_->take_stale();
  person_->resize(800, 300);
  bool stale = false;
  for (int i = 0; i < 100 && !stale; ++i) {
    view_->poll_events();
    stale = view_->take_stale();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(stale);
  view_->draw();
  EXPECT_EQ(view_->picture_size(), (PictureSize{400, 300}));
  const auto left = centroid(view_->read_picture(), 0, 0, 400);
  ASSERT_TRUE(left);
  EXPECT_NEAR(left->x(), 200.0, 0.6);
  EXPECT_NEAR(left->y(), 150.0, 0.6);
}

TEST_F(WindowEvents, ClosingIsAWishNotAnAbort) {
  person_->close();
  const auto heard = hear(1);
  ASSERT_FALSE(heard.empty());
  EXPECT_EQ(heard.back().kind, Kind::close);
}

}  // namespace
}  // namespace hapton
