#pragma once

#include "vision_node/visible_depth.h"

namespace hapton {

// A led hand, frame W.
struct LedTip {
  Vec3 p_WP = Vec3::Zero();      // the tip as it is drawn
  Vec3 offset_m = Vec3::Zero();  // from the device point to the tip, in contact; zero in free space
};

// The point to which a led hand is to be pulled next, so that it reaches its goal on the visible side of the scene: the goal itself if
// nothing is in between; otherwise first towards the viewer, then over the obstacle; from behind an object, first sideways until nothing
// hides the tip. Call it again as the hand moves. Frame W. p_WG: the goal, on the surface or slightly inside. RT: no.
Vec3 route_hand(const VisibleDepth& visible, const LedTip& tip, const Vec3& p_WG);

}  // namespace hapton
