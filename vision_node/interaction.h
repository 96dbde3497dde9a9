#pragma once

#include <cstdint>
#include <optional>

#include "link/messages.h"
#include "vision_node/camera_view.h"
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
struct UserRequests {
  bool quit = false;
  bool screenshot = false;
  bool toggle_cull = false;
  bool toggle_help = false;
  bool toggle_depth_cues = false;
  bool next_stereo = false;
  bool swap_eyes = false;
  bool look_at_scene = false;
};

// Turns keys and mouse into dials, the camera, the hand's target and requests. Only the dials turn what is felt.
// Left drag (or any motion while the hand is held with h) leads the hand: over the surface that is seen under the pointer, a little within
// it, so that it is felt; beside the scene in the screen's plane. The wheel then presses deeper or lifts the hand off. A right drag goes
// round the scene, with shift, or with the middle button, the picture is moved; the wheel without a hand zooms.
// RT: no.
class Interaction {
 public:
  struct View {
    StereoScreen screen;
    PictureSize picture;       // one eye's
    Vec3 p_WD = Vec3::Zero();  // where the device is now
    std::optional<Vec3> p_WQ;  // the surface of the scene that is seen under the pointer
  };

  void handle(const WindowEvent& event, const View& view);

  Dials& dials() { return dials_; }
  const Dials& dials() const { return dials_; }
  CameraView& camera() { return camera_; }
  const CameraView& camera() const { return camera_; }
  bool hand_active() const { return hand_.active; }

  // What has been requested since the last call.
  UserRequests take_requests();

  // The hand's target when it is to be sent: whenever it moved, again every 100 ms while held, and a few times after it was let go,
  // since one datagram may be lost.
  std::optional<HandTarget> take_hand(std::int64_t now_ns);

 private:
  void press_key(char key, const View& view);
  void take_hold(const View& view);
  void let_go();
  void drag(const WindowEvent& event, const View& view);
  void turn_wheel(int notches, const View& view);
  // The hand to the surface under the pointer; else by so many pixels in the screen's plane.
  void lead(const View& view, const Vec2& moved_px);

  Dials dials_;
  CameraView camera_;
  UserRequests requests_;
  HandTarget hand_;
  WindowEvent::Button held_ = WindowEvent::Button::none;
  bool latched_ = false;      // h was pressed: the hand follows the mouse without a button
  double press_ = 0.0;        // how far within the surface, as a share of the picture's smaller side
  std::optional<Vec3> p_WQ_;  // the surface that the hand was led to last
  int x_px_ = 0;
  int y_px_ = 0;
  bool hand_changed_ = false;
  int farewells_ = 0;
  std::int64_t hand_sent_ns_ = 0;
};

}  // namespace hapton
