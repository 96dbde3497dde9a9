#include "vision_node/interaction.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <utility>

#include "core/base/button_bit.h"

namespace hapton {
namespace {

// How far a key, a pixel of the mouse or a notch of the wheel turns or moves something: choices.
constexpr double kDialKeyDegrees = 5.0;
constexpr double kOrbitRadiansPerPixel = 0.4 * std::numbers::pi / 180.0;
constexpr double kTurnRadiansPerPixel = 0.5 * std::numbers::pi / 180.0;  // of the stylus: over a hand's width the mouse turns it a quarter
constexpr double kWheelTurnRadians = 10.0 * std::numbers::pi / 180.0;    // of the stylus, for each notch; a free choice
constexpr double kZoomPerNotch = 1.1;                                    // factor, also of the keys + and -; a free choice
constexpr double kHeadStepM = 0.01;  // of the viewer's head, for each press of an arrow key; a free choice
// Shares of the picture's smaller side: how deep inside the surface the hand is led at first (3 mm in a picture of 300 mm: a newton or two
// with the softest of the shipped materials), the step of one notch of the wheel, and how deep and how far off the hand may be moved.
constexpr double kPressShare = 0.01;
constexpr double kWheelShare = 0.005;
constexpr double kMaxPressShare = 0.1;
constexpr double kMinPressShare = -0.5;
constexpr std::int64_t kHandResendNs = 100'000'000;    // interval at which a target is sent again, as a datagram may be lost
constexpr std::int64_t kReleasePeriodNs = 30'000'000;  // between the messages that end the motion of the hand
constexpr int kReleaseMessages = 4;                    // number of those messages: one may be lost

// Keys of requests that the caller carries out.
constexpr std::array<std::pair<char, bool UserRequests::*>, 19> kRequestKeys = {{
    {'f', &UserRequests::look_at_scene},
    {'m', &UserRequests::next_stereo},
    {'e', &UserRequests::swap_eyes},
    {'b', &UserRequests::toggle_cull},
    {'g', &UserRequests::toggle_depth_cues},
    {'c', &UserRequests::toggle_plots},
    {'s', &UserRequests::screenshot},
    {'n', &UserRequests::mark},
    {'d', &UserRequests::draw},
    {'l', &UserRequests::measure},
    {'u', &UserRequests::undo},
    {'U', &UserRequests::redo},
    {'w', &UserRequests::save},
    {'o', &UserRequests::export_work},
    {'t', &UserRequests::menu},
    {'v', &UserRequests::next_teach},
    {'V', &UserRequests::next_level},
    {'k', &UserRequests::toggle_help},
    {'q', &UserRequests::quit},
}};

}  // namespace

void Interaction::handle(const WindowEvent& event, const View& view) {
  using Kind = WindowEvent::Kind;
  switch (event.kind) {
    case Kind::close:
      requests_.quit = true;
      break;
    case Kind::key:
      event.navigation_key == WindowEvent::NavigationKey::none ? press_key(event.key, view) : press_navigation_key(event.navigation_key);
      break;
    case Kind::press:
      held_button_ = event.button;
      if (held_button_ == WindowEvent::Button::left) begin_leading(view);
      break;
    case Kind::release:
      if (event.button == WindowEvent::Button::left && !is_hand_latched_) release_hand();
      if (event.button == held_button_) held_button_ = WindowEvent::Button::none;
      break;
    case Kind::move:
      drag(event, view);
      break;
    case Kind::wheel:
      if (event.control && hand_.active) {
        const double turn_rad = kWheelTurnRadians * event.wheel;
        turn_hand(event.shift ? Vec3(turn_rad, 0.0, 0.0) : Vec3(0.0, 0.0, turn_rad));
      } else {
        turn_wheel(event.wheel, view);
      }
      break;
  }
  if (event.kind != Kind::key && event.kind != Kind::close) {
    x_px_ = event.x_px;
    y_px_ = event.y_px;
  }
}

void Interaction::press_key(char key, const View& view) {
  for (const auto& [of, request] : kRequestKeys) {
    if (key == of) requests_.*request = true;
  }
  switch (key) {
    case 'x':
      dials_.turn(0, kDialKeyDegrees);
      break;
    case 'X':
      dials_.turn(0, -kDialKeyDegrees);
      break;
    case 'y':
      dials_.turn(1, kDialKeyDegrees);
      break;
    case 'Y':
      dials_.turn(1, -kDialKeyDegrees);
      break;
    case 'z':
      dials_.turn(2, kDialKeyDegrees);
      break;
    case 'Z':
      dials_.turn(2, -kDialKeyDegrees);
      break;
    case '0':
      dials_ = {};
      break;
    case '+':
    case '=':
      camera_.zoom_by(kZoomPerNotch);
      break;
    case '-':
      camera_.zoom_by(1.0 / kZoomPerNotch);
      break;
    case 'r':
      camera_ = {};
      break;
    case 'p':
      toggle_hand_button(1);
      break;
    case '1':
    case '2':
    case '3':
    case '4':
      toggle_hand_button(key - '0');
      break;
    case 'h':
      is_hand_latched_ = !is_hand_latched_;
      if (is_hand_latched_)
        begin_leading(view);
      else
        release_hand();
      break;
    default:
      break;
  }
}

void Interaction::press_navigation_key(WindowEvent::NavigationKey key) {
  using NavigationKey = WindowEvent::NavigationKey;
  Vec3& by_m = requests_.head_motion_m;
  switch (key) {
    case NavigationKey::left:
      by_m.x() -= kHeadStepM;
      break;
    case NavigationKey::right:
      by_m.x() += kHeadStepM;
      break;
    case NavigationKey::up:
      by_m.y() += kHeadStepM;
      break;
    case NavigationKey::down:
      by_m.y() -= kHeadStepM;
      break;
    case NavigationKey::page_up:
      by_m.z() -= kHeadStepM;
      break;
    case NavigationKey::page_down:
      by_m.z() += kHeadStepM;
      break;
    case NavigationKey::home:
      requests_.reset_head = true;
      by_m.setZero();
      break;
    case NavigationKey::none:
      break;
  }
}

void Interaction::begin_leading(const View& view) {
  if (hand_.active) return;
  hand_.active = true;
  set_goal(view.p_WD);
  press_share_ = kPressShare;
  p_WQ_.reset();
  has_hand_changed_ = true;
  if (view.p_WQ) lead(view, Vec2::Zero());
}

void Interaction::release_hand() {
  if (!hand_.active) return;
  hand_.active = false;
  hand_.buttons = 0;
  hand_.turn_rad.setZero();
  has_hand_changed_ = true;
  release_messages_left_ = kReleaseMessages;
}

void Interaction::toggle_hand_button(int number) {
  if (!hand_.active) return;
  hand_.buttons ^= button_bit(number);
  has_hand_changed_ = true;
}

void Interaction::drag(const WindowEvent& event, const View& view) {
  const Vec2 moved(event.x_px - x_px_, event.y_px - y_px_);
  if (moved.isZero()) return;
  const bool pans = held_button_ == WindowEvent::Button::middle || (held_button_ == WindowEvent::Button::right && event.shift);
  if (pans) {
    camera_.pan_m -= displace_in_screen_plane(view.screen, view.picture, moved, 0.0);
  } else if (held_button_ == WindowEvent::Button::right) {
    // The scene follows the mouse: the viewer moves the other way.
    camera_.orbit(-kOrbitRadiansPerPixel * moved.x(), -kOrbitRadiansPerPixel * moved.y());
  } else if (hand_.active && (is_hand_latched_ || held_button_ == WindowEvent::Button::left)) {
    if (event.control) {
      turn_hand(kTurnRadiansPerPixel * Vec3(moved.x(), -moved.y(), 0.0));
    } else {
      lead(view, moved);
    }
  }
}

void Interaction::turn_hand(const Vec3& by_rad) {
  hand_.turn_rad += by_rad;
  has_hand_changed_ = true;
}

void Interaction::set_goal(const Vec3& p_WG) {
  p_WG_ = p_WG;
  hand_.p_WH = p_WG;
  has_hand_changed_ = true;
}

void Interaction::follow(const VisibleDepth& visible, const LedTip& tip) {
  if (!hand_.active) return;
  const Vec3 next = route_hand(visible, tip, p_WG_);
  if (next == hand_.p_WH) return;
  hand_.p_WH = next;
  has_hand_changed_ = true;
}

void Interaction::lead(const View& view, const Vec2& moved_px) {
  if (view.p_WQ) {
    p_WQ_ = view.p_WQ;
    const Vec3 p_WE = compute_eye_position(view.screen, Eye::centre);
    const double side_m = std::min(view.screen.width_m, view.screen.height_m);
    set_goal(*p_WQ_ + press_share_ * side_m * (*p_WQ_ - p_WE).normalized());
    return;
  }
  p_WQ_.reset();
  const double z_m = (view.screen.X_WV.inverse(Eigen::Isometry) * p_WG_).z();
  set_goal(p_WG_ + displace_in_screen_plane(view.screen, view.picture, moved_px, z_m));
}

void Interaction::turn_wheel(int notches, const View& view) {
  if (!hand_.active) {
    camera_.zoom_by(notches > 0 ? kZoomPerNotch : 1.0 / kZoomPerNotch);
    return;
  }
  const double side_m = std::min(view.screen.width_m, view.screen.height_m);
  const double before = press_share_;
  press_share_ = std::clamp(press_share_ + kWheelShare * notches, kMinPressShare, kMaxPressShare);
  const Vec3 away =
      p_WQ_ ? Vec3((*p_WQ_ - compute_eye_position(view.screen, Eye::centre)).normalized()) : Vec3(-view.screen.X_WV.linear().col(2));
  set_goal(p_WG_ + (press_share_ - before) * side_m * away);
}

UserRequests Interaction::take_requests() { return std::exchange(requests_, {}); }

std::optional<HandTarget> Interaction::take_hand(std::int64_t now_ns) {
  const std::int64_t silent_ns = now_ns - hand_sent_ns_;
  const bool is_repeat_due = hand_.active ? silent_ns >= kHandResendNs : release_messages_left_ > 0 && silent_ns >= kReleasePeriodNs;
  if (!has_hand_changed_ && !is_repeat_due) return std::nullopt;
  if (!hand_.active) --release_messages_left_;
  has_hand_changed_ = false;
  hand_sent_ns_ = now_ns;
  return hand_;
}

}  // namespace hapton
