#pragma once

#include "core/math/types.h"

namespace hapton {

// The matrix for which cross_matrix(v) * x is the cross product of v and x. RT: yes.
inline Mat3 cross_matrix(const Vec3& v) noexcept {
  Mat3 m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

}  // namespace hapton
