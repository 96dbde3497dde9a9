#pragma once

#include <numbers>

#include "core/math/types.h"

namespace hapton {

// The rotation by these angles about the fixed x axis, then the fixed y axis, then the fixed z axis (`rotation_deg` of scenes). RT: yes.
inline Quat turn_by_degrees(const Vec3& degrees) noexcept {
  Quat q = Quat::Identity();
  for (int axis = 0; axis < 3; ++axis) {
    q = Eigen::AngleAxisd(degrees[axis] * std::numbers::pi / 180.0, Vec3::Unit(axis)) * q;
  }
  return q;
}

}  // namespace hapton
