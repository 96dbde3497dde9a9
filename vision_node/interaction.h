#pragma once

#include <cstdint>
#include <optional>

#include "link/messages.h"
#include "vision_node/knob_box.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// What the window system told, free of any window system. Pixels from the window's lower left corner.
struct WindowEvent {
  enum class Kind { key, press, release, move, wheel, close };
  enum class Button { none, left, middle, right };
  Kind kind = Kind::key;
  char key = 0;
  Button button = Button::none;
  int x_px = 0;
  int y_px = 0;
  int wheel = 0;  // +1 away from the person, -1 towards
  bool shift = false;
};

// What a person asked for, gathered from events.
struct Wishes {
  bool quit = false;
  bool screenshot = false;
  bool toggle_cull = false;
  bool toggle_help = false;
};

// Turns keys and mouse into dials, the hand's target and wishes.
// Left drag (or any motion while the hand is held with h) moves the hand in the screen's plane, the wheel moves it in depth, a right
// drag turns the dials: across for y, up and down for x, with shift for z. A hand begins where the probe is, so it never jumps.
// RT: no.
class Interaction {
 public:
  struct View {
    StereoScreen screen;
    PictureSize picture;       // one eye's
    Vec3 p_WD = Vec3::Zero();  // where the device is now
  };

  void handle(const WindowEvent& event, const View& view);

  Dials& dials() { return dials_; }
  const Dials& dials() const { return dials_; }
  bool hand_active() const { return hand_.active; }

  // What has been wished since the last call.
  Wishes take_wishes();

  // The hand's target when it is to be sent: whenever it moved, again every 100 ms while held, and a few times after it was let go,
  // since one datagram may be lost.
  std::optional<HandTarget> take_hand(std::int64_t now_ns);

 private:
  void press_key(char key, const View& view);
  void take_hold(const View& view);
  void let_go();
  void drag(const WindowEvent& event, const View& view);

  Dials dials_;
  Wishes wishes_;
  HandTarget hand_;
  WindowEvent::Button held_ = WindowEvent::Button::none;
  bool latched_ = false;  // h was pressed: the hand follows the mouse without a button
  int x_px_ = 0;
  int y_px_ = 0;
  bool hand_changed_ = false;
  int farewells_ = 0;
  std::int64_t hand_sent_ns_ = 0;
};

}  // namespace hapton
