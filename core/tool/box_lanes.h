#pragma once

#include <cmath>
#include <cstring>

#include "core/geometry/triangle_distance.h"
#include "core/math/types.h"

namespace hapton {

// Vectors of three numbers in four SIMD lanes, for the boxes of an ObbTree. The fourth lane has no meaning. RT: yes.

inline Lanes4 lanes_of(const Vec3& v) { return Lanes4{v.x(), v.y(), v.z(), 0.0}; }

// The first three floats are the vector. Pre: four floats can be read.
inline Lanes4 lanes_at(const float* from) {
  using Floats4 = float __attribute__((vector_size(16)));
  Floats4 four;
  std::memcpy(&four, from, sizeof(four));
  return __builtin_convertvector(four, Lanes4);
}

inline Lanes4 absolute(const Lanes4& x) { return detail::lane_max(x, -x); }

// The dot products of v with three axes. axes[i]: coordinate i of each axis.
inline Lanes4 along(const Lanes4 (&axes)[3], const Vec3& v) { return v.x() * axes[0] + v.y() * axes[1] + v.z() * axes[2]; }

// A lower and an upper bound of x in single precision, which differ from x by about 2^-22 of it. For distances that are kept as float.
inline float float_at_most(double x) { return static_cast<float>(x - std::fabs(x) * 0x1p-22 - 0x1p-100); }
inline float float_at_least(double x) { return -float_at_most(-x); }

}  // namespace hapton
