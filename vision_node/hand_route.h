#pragma once

#include "vision_node/visible_depth.h"

namespace hapton {

// A led hand, frame W.
struct LedTip {
  Vec3 p_WP = Vec3::Zero();      // the tip as it is shown
  Vec3 offset_m = Vec3::Zero();  // from the device to the tip, in contact; zero in free space
};

// Where to pull a led hand next so that it reaches its goal on the visible side of the scene: straight there if nothing is in between;
// otherwise first towards the viewer and over the obstacle; from behind an object first out beside it. Call again as the hand moves. p_WG:
// the goal, on the surface or slightly inside. RT: no.
Vec3 route_hand(const VisibleDepth& seen, const LedTip& tip, const Vec3& p_WG);

}  // namespace hapton
