#pragma once

#include <cstdint>

#include "core/math/types.h"
#include "hid/space_mouse_reader.h"

namespace hapton {

// A speed that the cap of a SpaceMouse sets: along each axis it grows with the square of the deflection, for fine work. Times:
// CLOCK_MONOTONIC, ns. RT: no.
class SpaceMouseRate {
 public:
  // axes: SpaceMouseState's push or turn; full_per_s: the speed at full deflection. Begins to look for a SpaceMouse; there need not be one,
  // now or at any time. The log says when it comes and goes.
  SpaceMouseRate(HidOpener opener, Vec3 SpaceMouseState::*axes, double full_per_s);

  // The movement at that speed since the last call; of a time longer than 0.1 s, only 0.1 s count.
  Vec3 take(std::int64_t now_ns);

 private:
  SpaceMouseReader reader_;
  Vec3 SpaceMouseState::*axes_;
  double full_per_s_;
  std::int64_t last_take_ns_ = -1;
};

}  // namespace hapton
