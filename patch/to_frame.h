#pragma once

#include "core/math/types.h"

namespace hapton {

// A point given in frame A, in the frame B of a rigid pose X_AB. RT: yes.
inline Vec3 to_frame(const Pose& X_AB, const Vec3& p_A) noexcept { return X_AB.linear().transpose() * (p_A - X_AB.translation()); }

}  // namespace hapton
