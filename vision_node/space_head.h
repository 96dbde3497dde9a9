#pragma once

#include <cstdint>
#include <utility>

#include "vision_node/space_mouse_rate.h"

namespace hapton {

// Moves the viewer's head by a SpaceMouse: pushing its cap right, up and towards the person moves the head that way. Turns do nothing.
// Frame R (see Head). RT: no.
class SpaceHead {
 public:
  static constexpr double kFullMPerS = 0.3;  // at full deflection: as fast as a person moves the head; a choice

  explicit SpaceHead(HidOpener opener) : rate_(std::move(opener), &SpaceMouseState::push, kFullMPerS) {}

  // How far the head has moved since the last call, m.
  Vec3 take_move_m(std::int64_t now_ns) { return rate_.take(now_ns); }

 private:
  SpaceMouseRate rate_;
};

}  // namespace hapton
