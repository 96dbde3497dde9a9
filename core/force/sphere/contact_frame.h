#pragma once

#include <array>
#include <cmath>

#include "core/math/exact_cross.h"
#include "core/math/types.h"

namespace hapton {

// Up to three unit normals and the vectors dual to them: dual i has the product 1 with normal i, 0 with the others, and lies in their span.
// A vector v in the span is the sum of (dual i . v) normal i; the least motion that raises normal i by g i is the sum of g i dual i.
// RT: yes.
struct ContactFrame {
  std::array<Vec3, 3> normal;
  std::array<Vec3, 3> dual;
  Vec3 along = Vec3::Zero();  // of two: unit, square to both
  int count = 0;

  // False where they are parallel, or three in one plane, as far as rounding can tell.
  bool prepare() noexcept {
    constexpr double kParallel = 0x1p-48;
    if (count == 1) dual[0] = normal[0];
    if (count == 2) {
      const Vec3 line = accurate_cross(normal[0], normal[1]);
      const double squared = line.squaredNorm();
      if (!(squared > kParallel * kParallel)) return false;
      dual[0] = normal[1].cross(line) / squared;
      dual[1] = line.cross(normal[0]) / squared;
      along = line / std::sqrt(squared);
    }
    if (count == 3) {
      const Vec3 c0 = accurate_cross(normal[1], normal[2]);
      const Vec3 c1 = accurate_cross(normal[2], normal[0]);
      const Vec3 c2 = accurate_cross(normal[0], normal[1]);
      const double volume = normal[0].dot(c0);
      if (!(std::fabs(volume) > kParallel)) return false;
      dual = {c0 / volume, c1 / volume, c2 / volume};
    }
    return true;
  }
};

}  // namespace hapton
