#include "vision_node/interaction.h"

#include <utility>

namespace hapton {
namespace {

constexpr double kDialKeyDegrees = 5.0;
constexpr double kDialDragDegreesPerPixel = 0.5;
// One notch of the wheel, as a share of the picture's smaller side.
constexpr double kWheelShare = 0.01;
constexpr std::int64_t kHandResendNs = 100'000'000;
constexpr std::int64_t kFarewellNs = 30'000'000;
constexpr int kFarewells = 4;

}  // namespace

void Interaction::handle(const WindowEvent& event, const View& view) {
  using Kind = WindowEvent::Kind;
  switch (event.kind) {
    case Kind::close:
      wishes_.quit = true;
      break;
    case Kind::key:
      press_key(event.key, view);
      break;
    case Kind::press:
      held_ = event.button;
      if (held_ == WindowEvent::Button::left) take_hold(view);
      break;
    case Kind::release:
      if (event.button == WindowEvent::Button::left && !latched_) let_go();
      if (event.button == held_) held_ = WindowEvent::Button::none;
      break;
    case Kind::move:
      drag(event, view);
      break;
    case Kind::wheel:
      if (!hand_.active) break;
      hand_.p_WH -= view.screen.X_WV.linear().col(2) * (event.wheel * kWheelShare * std::min(view.screen.width_m, view.screen.height_m));
      hand_changed_ = true;
      break;
  }
  if (event.kind != Kind::key && event.kind != Kind::close) {
    x_px_ = event.x_px;
    y_px_ = event.y_px;
  }
}

void Interaction::press_key(char key, const View& view) {
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
    case 'b':
      wishes_.toggle_cull = true;
      break;
    case 's':
      wishes_.screenshot = true;
      break;
    case 'k':
      wishes_.toggle_help = true;
      break;
    case 'q':
      wishes_.quit = true;
      break;
    case 'h':
      latched_ = !latched_;
      if (latched_)
        take_hold(view);
      else
        let_go();
      break;
    default:
      break;
  }
}

void Interaction::take_hold(const View& view) {
  if (hand_.active) return;
  hand_.active = true;
  hand_.p_WH = view.p_WD;
  hand_changed_ = true;
}

void Interaction::let_go() {
  if (!hand_.active) return;
  hand_.active = false;
  hand_changed_ = true;
  farewells_ = kFarewells;
}

void Interaction::drag(const WindowEvent& event, const View& view) {
  const Vec2 moved(event.x_px - x_px_, event.y_px - y_px_);
  if (held_ == WindowEvent::Button::right) {
    if (event.shift) {
      dials_.turn(2, -kDialDragDegreesPerPixel * moved.x());
    } else {
      dials_.turn(1, kDialDragDegreesPerPixel * moved.x());
      dials_.turn(0, -kDialDragDegreesPerPixel * moved.y());
    }
  } else if (hand_.active && (latched_ || held_ == WindowEvent::Button::left) && !moved.isZero()) {
    const double z_m = (view.screen.X_WV.inverse(Eigen::Isometry) * hand_.p_WH).z();
    hand_.p_WH += displace_in_screen_plane(view.screen, view.picture, moved, z_m);
    hand_changed_ = true;
  }
}

Wishes Interaction::take_wishes() { return std::exchange(wishes_, {}); }

std::optional<HandTarget> Interaction::take_hand(std::int64_t now_ns) {
  const std::int64_t silent_ns = now_ns - hand_sent_ns_;
  const bool again = hand_.active ? silent_ns >= kHandResendNs : farewells_ > 0 && silent_ns >= kFarewellNs;
  if (!hand_changed_ && !again) return std::nullopt;
  if (!hand_.active) --farewells_;
  hand_changed_ = false;
  hand_sent_ns_ = now_ns;
  return hand_;
}

}  // namespace hapton
