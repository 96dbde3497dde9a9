#include "vision_node/hud_text.h"

#include <fmt/format.h>

namespace hapton {

std::string compose_hud(const HudFacts& facts) {
  const ProbeState& s = facts.state;
  std::string text;
  if (facts.connected) {
    text +=
        fmt::format("servo {:.0f} Hz   round trip p50 {:.0f}  p99 {:.0f} us\n", s.servo_rate_hz, s.round_trip_p50_us, s.round_trip_p99_us);
    text += fmt::format("force {:4.2f} N   {}{}\n", s.force_n.allFinite() ? s.force_n.norm() : 0.0, s.contact ? "touching" : "free",
                        facts.hand_held ? ", hand on the mouse" : "");
  } else {
    text += "waiting for the hub ...\n\n";
  }
  text += fmt::format("{:.0f} frames/s   {}{}   dials {:.0f} {:.0f} {:.0f}", facts.frame_rate_hz, facts.stereo,
                      facts.cull ? "" : ", no cull", facts.dials_degrees.x(), facts.dials_degrees.y(), facts.dials_degrees.z());
  if (facts.detail_progress < 1.0) text += fmt::format("   preparing detail {:.0f} %", 100.0 * facts.detail_progress);
  return text;
}

std::string_view keys_help() {
  return "x X y Y z Z knob box   0 home   b cull   h hand   s screenshot   k help   q quit\n"
         "wheel + - zoom   m stereo   e swap eyes   f frame   r reset view   g ground\n"
         "left drag: hand, wheel: press   right drag: look round, with shift: move";
}

}  // namespace hapton
