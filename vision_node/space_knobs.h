#pragma once

#include <cstdint>
#include <utility>

#include "vision_node/space_mouse_rate.h"

namespace hapton {

// A SpaceMouse as the memo's knob box: turning its cap about x, y or z turns the dial of that axis. Translations do nothing. RT: no.
class SpaceKnobs {
 public:
  static constexpr double kFullDegreesPerS = 120.0;  // at full deflection of the cap: a turn in three seconds

  explicit SpaceKnobs(HidOpener opener) : rate_(std::move(opener), &SpaceMouseState::turn, kFullDegreesPerS) {}

  // How far the three dials were turned since the last call, degrees.
  Vec3 take_turn_degrees(std::int64_t now_ns) { return rate_.take(now_ns); }

 private:
  SpaceMouseRate rate_;
};

}  // namespace hapton
