#pragma once

#include "core/math/types.h"

namespace hapton {

// Whether a device has left the surface on which its proxy last rested, on the side that it was in contact with: beyond the plane through
// that proxy. Contact that went on from there would hold it from the other side of the surface.
// p_P: the proxy then. outward: from the device of then to it, of any length; zero, if only effects acted: false. p_D: the device now.
// Frames: one for all. RT: yes.
inline bool has_left_contact(const Vec3& p_P, const Vec3& outward, const Vec3& p_D) noexcept {
  return !outward.isZero(0.0) && !((p_P - p_D).dot(outward) > 0.0);
}

}  // namespace hapton
