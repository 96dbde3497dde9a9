#pragma once

#include <cstdint>
#include <memory>

#include "core/math/types.h"
#include "hid/space_mouse_reader.h"

namespace hapton {

// The memo's knob box, as a SpaceMouse: turning its cap about x, y or z turns the dial of that axis, the speed growing with the square of
// the deflection, for fine work. Translations do nothing. Times: CLOCK_MONOTONIC, ns. RT: no.
class SpaceKnobs {
 public:
  static constexpr double kFullDegreesPerS = 120.0;

  // Begins to look for it; none may be there, now or at any time. The log says when it comes and goes.
  explicit SpaceKnobs(HidOpener opener);

  // How far the three dials were turned since the last call, degrees.
  Vec3 take_turn_degrees(std::int64_t now_ns);

 private:
  SpaceMouseReader reader_;
  std::int64_t taken_ns_ = -1;
};

}  // namespace hapton
