#include "vision_node/hud_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/button_bit.h"
#include "vision_node/probe_shown.h"

namespace hapton {

namespace {

constexpr float kCommandTimeoutUs = 20'000.0F;  // kCommandTimeoutNs of io_node's governor

// If there can be no force, "free, 0.00 N" would say that all is well.
bool is_without_force(ProbeStatus status) {
  return status != ProbeStatus::ok && status != ProbeStatus::out_of_reach && status != ProbeStatus::too_small &&
         status != ProbeStatus::hand_inside;
}

// Ten marks that show how much of the energy budget is used; empty while the device has given the hand no more than it took.
std::string energy_text(std::uint32_t percent) {
  constexpr std::uint32_t kMarks = 10;  // of the bar, 10 % each
  if (percent == 0) return {};
  const std::uint32_t full_marks = std::min(kMarks, (percent * kMarks + 99) / 100);
  return fmt::format("   energy given [{}{}] {} %", std::string(full_marks, '#'), std::string(kMarks - full_marks, '.'), percent);
}

// A key holds a button until it is pressed again.
std::string hand_text(const HudFacts& facts) {
  if (!facts.is_hand_led) return {};
  std::string text = ", hand on the mouse";
  for (int button = 1; button <= 4; ++button) {
    if ((facts.state.buttons & button_bit(button)) != 0) text += fmt::format(", button {}", button);
  }
  return text;
}

// Whether a held object is in contact. A force alone does not show this: it may be that of an effect in free space.
bool is_held_in_contact(const ProbeState& s) {
  constexpr double kRounding = 1e-9;  // m, rad: a pose that goes through a matrix comes back rounded
  return s.contact && !(s.visual_offset_m.norm() < kRounding && s.visual_turn.norm() < kRounding);
}

std::string force_text(const HudFacts& facts) {
  const ProbeState& state = facts.state;
  // haptics_node has joined the hub, but does not reply yet.
  if ((state.status == ProbeStatus::no_haptics || state.status == ProbeStatus::ok) && facts.preparing_s > 0.0) {
    return fmt::format("NO FORCE YET: haptics_node prepares the scene, {:.0f} s", facts.preparing_s);
  }
  // haptics_node replies, but too late.
  if (state.status == ProbeStatus::no_haptics && state.round_trip_p50_us > kCommandTimeoutUs) {
    return fmt::format("NO FORCE: replies of haptics_node take {:.0f} ms, a force lasts {:.0f} ms", 1e-3F * state.round_trip_p50_us,
                       1e-3F * kCommandTimeoutUs);
  }
  if (is_without_force(state.status)) return std::string(describe(state.status));
  const std::string contact = !facts.held_name.empty()  ? "holding " + facts.held_name + (is_held_in_contact(state) ? ", in contact" : "")
                              : !state.contact          ? "free"
                              : !touches_surface(state) ? "free, a force in space"
                              : facts.touched_name.empty() ? "touching"
                                                           : "touching " + facts.touched_name;
  const bool has_torque = state.torque_nm.allFinite() && !state.torque_nm.isZero(0.0);
  const std::string torque = has_torque ? fmt::format("  torque {:5.3f} Nm", state.torque_nm.norm()) : std::string();
  const std::uint32_t pairs = state.haptons.value_or(0);
  const std::string haptons = pairs > 0 ? fmt::format("  {} hapton{}", pairs, pairs == 1 ? "" : "s") : std::string();
  return fmt::format("force {:4.2f} N{}{}   {}{}{}{}{}", state.force_n.allFinite() ? state.force_n.norm() : 0.0, torque, haptons, contact,
                     hand_text(facts), energy_text(state.energy_percent), state.status == ProbeStatus::ok ? "" : "   ",
                     describe(state.status));
}

// In millimetres even if the scene is tiny: people compare the size with the one that they know.
std::string size_text(double length_m) {
  if (length_m >= 10.0) return fmt::format("{:.0f} m", length_m);
  if (length_m >= 1.0) return fmt::format("{:.2g} m", length_m);
  return length_m >= 0.01 ? fmt::format("{:.0f} mm", 1e3 * length_m) : fmt::format("{:.2g} mm", 1e3 * length_m);
}

}  // namespace

std::string_view describe(ProbeStatus status) {
  switch (status) {
    case ProbeStatus::ok:
      break;
    case ProbeStatus::no_haptics:
      return "NO FORCE: no haptics_node replies";
    case ProbeStatus::fault_latched:
      return "NO FORCE: a fault is latched; hapton set --reset-faults";
    case ProbeStatus::device_away:
      return "NO FORCE: the device is away";
    case ProbeStatus::calibrating:
      return "NO FORCE: the device is being calibrated";
    case ProbeStatus::out_of_reach:
      return "THE DEVICE CANNOT REACH THE SCENE: check --unit, --no-fit";
    case ProbeStatus::too_small:
      return "THE SCENE IS FAR TOO SMALL: check --unit, --no-fit";
    case ProbeStatus::hand_inside:
      return "INSIDE A BODY SINCE THE START: lead the stylus out; if it is held, start haptics_node again";
  }
  return {};
}

std::string compose_hud(const HudFacts& facts) {
  const ProbeState& state = facts.state;
  std::string text;
  if (!facts.recording.empty()) text += facts.recording + "\n";
  if (facts.is_connected) {
    text += fmt::format("servo {:.0f} Hz", state.servo_rate_hz);
    // No round trip is measured while no haptics_node replies.
    if (state.round_trip_p99_us > 0.0F)
      text += fmt::format("   round trip p50 {:.0f}  p99 {:.0f} us", state.round_trip_p50_us, state.round_trip_p99_us);
    text += "\n" + force_text(facts) + "\n";
  } else {
    text += "waiting for the hub ...\n\n";
  }
  if (facts.frame_rate_hz > 0.0) text += fmt::format("{:.0f} frames/s   ", facts.frame_rate_hz);
  text += fmt::format("{}{}", facts.stereo, facts.cull ? "" : ", no cull");
  if (facts.recording.empty()) {
    text += fmt::format("   dials {:.0f} {:.0f} {:.0f}", facts.dials_degrees.x(), facts.dials_degrees.y(), facts.dials_degrees.z());
  }
  if (facts.detail_progress < 1.0) text += fmt::format("   preparing detail {:.0f} %", 100.0 * facts.detail_progress);
  if (!facts.head.empty()) text += "   " + facts.head;
  if (!facts.head_notice.empty()) text += "\nHEAD: " + facts.head_notice;
  if (!facts.scene_problem.empty()) text += "\nSCENE FILE: " + facts.scene_problem;
  if (!facts.annotations.empty()) text += "\n" + facts.annotations;
  if (!facts.teaching.empty()) text += "\n" + facts.teaching;
  if (!facts.recent_event.empty()) text += "\n" + facts.recent_event;
  if (facts.is_other_scene && !facts.recording.empty()) {
    text += "\nTHE RECORDING HAS ANOTHER SCENE than the one shown: name the one of the recording with --scene";
  } else if (facts.is_other_scene) {
    text += "\nhaptics_node HAS ANOTHER SCENE than the one shown: start both nodes with the same --scene";
  } else if (facts.is_other_tool) {
    text += "\nhaptics_node HAS ANOTHER TOOL than the one drawn: start both nodes with the same --tool";
  }
  return text;
}

std::string compose_notice(const HudFacts& facts) {
  if (!facts.is_connected) return {};
  if (facts.is_other_scene && !facts.recording.empty()) {
    return "The recording has another scene than the one shown.\nThe file has changed since, or --scene, --unit or --no-fit differ.";
  }
  if (facts.is_other_scene) {
    return "haptics_node has another scene than the one shown.\nStart both nodes with the same --scene, --unit and --no-fit.";
  }
  if (facts.is_other_tool) {
    return "haptics_node has another tool than the one drawn.\nStart both nodes with the same --tool, --tool-unit and --tool-grip.";
  }
  if (facts.state.status == ProbeStatus::too_small) {
    return fmt::format(
        "This scene is {} across, too small to touch.\nWrong unit? Give --unit, or unit and fit_m in the scene file; leave out --no-fit.",
        size_text(facts.scene_diameter_m));
  }
  if (facts.state.status == ProbeStatus::out_of_reach) {
    return fmt::format(
        "The device cannot reach this scene: {} across, {} away.\nWrong unit? Give --unit, or unit and fit_m in the scene file; leave out "
        "--no-fit.",
        size_text(facts.scene_diameter_m), size_text(facts.scene_distance_m));
  }
  return {};
}

std::string_view keys_help() {
  return "x X y Y z Z knob box   0 reset   b cull   s screenshot   n mark   k help   q quit\n"
         "wheel + - zoom   m stereo   e swap eyes   f fit view   r reset view   g ground   c curves\n"
         "left drag: hand, wheel: press, with ctrl: turn   h hand   1 2 3 4 its buttons   p pick up\n"
         "d draw   l measure   u undo   U redo   w save   o export   t touch menu   v V teaching views\n"
         "right drag: look round, with shift: move   arrows, page keys: head, home: back";
}

std::string_view recording_keys_help() {
  return "space pause   , . one sample back, on   n N next, previous marker or fault   [ ] slower, faster   a begin\n"
         "left drag on the time line: moment   b cull   s screenshot   o export   k help   q quit\n"
         "wheel + - zoom   m stereo   e swap eyes   f fit view   r reset view   g ground   c curves\n"
         "right drag: look round, with shift: move   arrows, page keys: head, home: back   v V teaching views";
}

}  // namespace hapton
