#pragma once

#include <array>
#include <cmath>
#include <span>

#include "core/force/sphere/offset_surface.h"
#include "core/math/exact_cross.h"

namespace hapton {

// Up to three unit normals and their dual basis: dual i . normal i is 1, dual i . normal k is 0, and the duals lie in the normals' span.
// A vector v in the span is the sum of (dual i . v) normal i; the shortest motion that moves by g i along each normal i is the sum of
// g i dual i. RT: yes.
struct ContactFrame {
  std::array<Vec3, 3> normal;
  std::array<Vec3, 3> dual;
  Vec3 along = Vec3::Zero();  // only with two normals: unit, perpendicular to both
  int count = 0;
  std::array<double, 3> short_by;  // how much c is nearer than the offset; set by measure()

  // Sets the contacts' normals at c, and how much c is nearer to each of them than the offset. Pre: at most three contacts.
  void measure(std::span<const OffsetContact> contacts, const Vec3& c, double offset) noexcept {
    count = static_cast<int>(contacts.size());
    for (int i = 0; i < count; ++i) {
      const OffsetContact::Proximity proximity = contacts[i].proximity(c);
      normal[i] = proximity.normal;
      short_by[i] = offset - proximity.distance;
    }
  }

  // Computes the duals. False: two normals are parallel, or three are in one plane, within rounding.
  bool prepare() noexcept {
    constexpr double kParallel = 0x1p-48;  // of a sine or a volume: 16 times the rounding of a unit vector, 2^-52
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
