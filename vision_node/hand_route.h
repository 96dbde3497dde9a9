#pragma once

#include "vision_node/surface_seen.h"

namespace hapton {

// A led hand, frame W.
struct LedTip {
  Vec3 p_WP = Vec3::Zero();      // the tip as it is shown
  Vec3 offset_m = Vec3::Zero();  // from the device to the tip: what the surface that is touched keeps out; zero while nothing is touched
};

// Where a led hand is to be pulled next so that it comes to its goal on the side of the scene that is seen: straight there where nothing is
// in between; else first towards the viewer and over what is in between; from behind an object first out beside it. To be asked again as
// the hand moves. p_WG: the goal, on the surface or a little within. RT: no.
Vec3 route_hand(const SurfaceSeen& seen, const LedTip& tip, const Vec3& p_WG);

}  // namespace hapton
