#pragma once

#include <cstdint>
#include <optional>

#include "link/messages.h"
#include "vision_node/camera_view.h"
#include "vision_node/hand_route.h"
#include "vision_node/knob_box.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// A window system's event, independent of any window system. Pixels from the window's lower left corner.
struct WindowEvent {
  enum class Kind { key, press, release, move, wheel, close };
  enum class Button { none, left, middle, right };
  // Keys that have no character.
  enum class NavigationKey { none, left, right, up, down, page_up, page_down, home };
  Kind kind = Kind::key;
  char key = 0;
  NavigationKey navigation_key = NavigationKey::none;
  Button button = Button::none;
  int x_px = 0;
  int y_px = 0;
  int wheel = 0;  // notches: +1 away from the person, -1 towards the person
  bool shift = false;
  bool control = false;
};

// The user's requests, collected from events.
struct UserRequests {
  bool quit = false;
  bool screenshot = false;
  bool toggle_cull = false;
  bool toggle_help = false;
  bool toggle_depth_cues = false;
  bool toggle_plots = false;
  bool next_stereo = false;
  bool swap_eyes = false;
  bool look_at_scene = false;
  bool mark = false;
  bool draw = false;  // moves the pen down, or up again
  bool measure = false;
  bool undo = false;
  bool redo = false;
  bool save = false;
  bool export_work = false;
  bool menu = false;
  bool next_teach = false;            // shows the next teaching view
  bool next_level = false;            // shows the next level of that view's tree
  Vec3 head_motion_m = Vec3::Zero();  // how far the viewer's head is to move, frame R
  bool reset_head = false;
};

// Turns keys and mouse into dials, the camera, the hand's target and requests. Only the dials turn the haptic scene. A left drag (or any
// motion after the key h has latched the hand) leads the hand: along the visible surface under the pointer, slightly inside it, so that
// there is a force; beside the scene, in the screen's plane; never through visible objects (hand_route.h). The wheel then presses deeper or
// lifts the hand off. With control, a left drag turns the stylus, and the wheel rolls it about its axis, or with shift yaws it. Each of the
// keys 1 to 4 presses its button of the stylus, or releases it again; p does so with the first. A right drag orbits the scene; with shift,
// or with the middle button, it pans; without a hand the wheel zooms. The arrows, page up and page down move the viewer's head in front of
// the screen by a centimetre; home moves it back. RT: no.
class Interaction {
 public:
  struct View {
    StereoScreen screen;
    PictureSize picture;       // size of one eye's picture
    Vec3 p_WD = Vec3::Zero();  // where the device point is now
    std::optional<Vec3> p_WQ;  // the visible point of the scene under the pointer; none: the pointer is beside the scene
  };

  void handle(const WindowEvent& event, const View& view);
  // Call it while the hand is led, with what is seen now: moves the hand on towards its goal under the pointer, on the visible side of the
  // scene.
  void follow(const VisibleDepth& visible, const LedTip& tip);

  Dials& dials() { return dials_; }
  const Dials& dials() const { return dials_; }
  CameraView& camera() { return camera_; }
  const CameraView& camera() const { return camera_; }
  bool is_hand_led() const { return hand_.active; }

  // The requests since the last call. They are then cleared.
  UserRequests take_requests();

  // The hand's target if it must be sent: whenever it moved, again every 100 ms while led, and a few times after its release, because a
  // datagram may be lost.
  std::optional<HandTarget> take_hand(std::int64_t now_ns);

 private:
  void press_key(char key, const View& view);
  void press_navigation_key(WindowEvent::NavigationKey key);
  void begin_leading(const View& view);
  void release_hand();
  // Releases the button if it is pressed. number: from 1.
  void toggle_hand_button(int number);
  void drag(const WindowEvent& event, const View& view);
  void turn_wheel(int notches, const View& view);
  // Turns the stylus further: yaw, pitch, roll.
  void turn_hand(const Vec3& by_rad);
  // Moves the hand's goal to the surface under the pointer; if there is none, by these pixels in the screen's plane.
  void lead(const View& view, const Vec2& moved_px);
  void set_goal(const Vec3& p_WG);

  Dials dials_;
  CameraView camera_;
  UserRequests requests_;
  HandTarget hand_;
  Vec3 p_WG_ = Vec3::Zero();  // the goal under the pointer; the hand may be sent to a point on the path to it
  WindowEvent::Button held_button_ = WindowEvent::Button::none;
  bool is_hand_latched_ = false;  // h was pressed: the hand follows the mouse without a button
  double press_share_ = 0.0;      // depth inside the surface, as a share of the picture's smaller side; negative: off the surface
  std::optional<Vec3> p_WQ_;      // the surface point that the hand was led to last
  int x_px_ = 0;
  int y_px_ = 0;
  bool has_hand_changed_ = false;
  int release_messages_left_ = 0;  // how often the release of the hand is still to be sent
  std::int64_t hand_sent_ns_ = 0;
};

}  // namespace hapton
