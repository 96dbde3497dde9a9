#pragma once

#include "core/math/types.h"

namespace hapton {

// Whether the device point has left the surface of its last contact on the outer side: it is beyond the plane through the proxy of that
// contact. Contact must then not be resumed: it would hold the device from the wrong side of the surface.
// p_P: the proxy of the last contact. outward: proxy minus device point at that time, of any length; zero, when only effects acted, gives
// false. p_D: the device point now.
// Frames: any, one for all. Units: any, one for all. RT: yes.
inline bool has_left_contact(const Vec3& p_P, const Vec3& outward, const Vec3& p_D) noexcept {
  return !outward.isZero(0.0) && !((p_P - p_D).dot(outward) > 0.0);
}

}  // namespace hapton
