#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <memory>

#include "core/collision/touch_geometry.h"
#include "core/geometry/contact_triangle.h"
#include "core/math/float8.h"

namespace hapton {

// All triangles within a distance of a centre, each with a lower bound of its distance from any point.
//
// A triangle lies behind the plane through its point closest to the centre, with the normal from that point to the centre. The distance
// from this plane is a lower bound everywhere, and tight near the centre. Six vector instructions bound four triangles, so few triangles
// need the exact query.
//
// Frame: TouchGeometry's local one. RT: yes, fixed capacity. Pre: the geometry outlives this object.
class NearTriangles {
 public:
  static constexpr int kCapacity = 6144;                   // a sphere at a vertex reaches all triangles of its fan
  static constexpr int kMaxOutsideFans = 1024;             // triangles that are in no large fan (SurfaceAdjacency)
  static constexpr int kMaxVisited = 1280;                 // most of these whose boxes are near; only a few are near themselves
  static constexpr int kMaxVisitedInFans = 2 * kCapacity;  // slivers that are not along an axis have large boxes

  // Collects all triangles at most `within` from the centre, give or take rounding (2^-44). False, and then empty, if there are more than
  // `most` (<= kCapacity) of them, or more than kMaxOutsideFans in no large fan, or if more triangles were visited, because their boxes are
  // that near, than kMaxVisited in no large fan or kMaxVisitedInFans in large fans, counted once per batch. `queried`: is raised by the
  // number of triangles visited.
  bool gather(const TouchGeometry& geometry, const Vec3& centre, double within, int& queried, int most = kCapacity) noexcept;
  void clear() {
    count_ = 0;
    radius_ = -1.0;
  }

  // Whether every triangle within `distance` of p was collected.
  bool covers(const Vec3& p, double distance) const { return (p - centre_).norm() + distance <= radius_; }
  // How many of the triangles that the last gather() visited are in large fans: these are neighbours in memory.
  int queried_in_fans() const { return queried_in_fans_; }
  // The distance from p within which every triangle was collected. Negative: p is outside.
  double covered_radius_at(const Vec3& p) const { return radius_ - (p - centre_).norm(); }
  // Whether p is within half the ball's radius of its centre. Farther out, bounds of triangles on the other side of the centre are weak.
  bool is_central(const Vec3& p) const { return (p - centre_).norm() <= 0.5 * radius_; }
  int count() const { return count_; }
  std::uint32_t triangle(int slot) const { return triangle_[slot]; }

  // The triangle in a slot; prepared by the first call for it. The reference is valid until a call for another slot, or a gather().
  const ContactTriangle& shape(int slot) noexcept {
    const auto place = static_cast<std::size_t>(slot % kPrepared);
    if (prepared_[place] != slot) {
      const ObjectGeometry::Corners corners = geometry_->corners(triangle_[slot]);
      std::construct_at(&shapes_[place], corners.a, corners.b, corners.c);
      prepared_[place] = slot;
    }
    return shapes_[place];
  }

  // A lower bound of the triangle's distance from p.
  double distance_bound(int slot, const Vec3& p) const {
    const Vec3 off = p - centre_;
    const double distance = distance_[slot] + normal_[0][slot] * off[0] + normal_[1][slot] * off[1] + normal_[2][slot] * off[2];
    return distance - rounding(off.norm());
  }

  // Of the triangles that the last gather() collected before it ended or gave up, the share within `distance` of the ball's centre.
  double share_within(double distance) const {
    const auto end = distance_.begin() + gathered_;
    return static_cast<double>(std::count_if(distance_.begin(), end, [&](double d) { return d <= distance; })) / std::max(gathered_, 1);
  }

  // Calls visit(slot) for every triangle within `distance` of the segment from p to q, and for some others.
  // Pre: covers(p, distance) and covers(q, distance).
  template <class Visit>
  void visit_near(const Vec3& p, const Vec3& q, double distance, Visit&& visit) const {
    const Vec3 from = p - centre_;
    const Vec3 to = q - centre_;
    const Double4 limit = Double4(distance + rounding(std::max(from.norm(), to.norm())));
    Double4 a[3];
    Double4 b[3];
    for (int k = 0; k < 3; ++k) {
      a[k] = Double4(from[k]);
      b[k] = Double4(to[k]);
    }
    for (int i = 0; i < count_; i += 4) {
      Double4 at_a = Double4::load(distance_.data() + i);
      Double4 at_b = at_a;
      for (int k = 0; k < 3; ++k) {
        const Double4 n = Double4::load(normal_[k].data() + i);
        at_a = at_a + n * a[k];
        at_b = at_b + n * b[k];
      }
      auto mask = sign_bits(min(at_a, at_b) <= limit);
      for (; mask != 0; mask &= mask - 1) visit(i + std::countr_zero(mask));
    }
  }

 private:
  static constexpr int kBatch = 64;       // triangles whose corners are prefetched together
  static constexpr int kPrepared = 1024;  // triangles that are kept prepared: that of a slot at slot % kPrepared
  using Batch = std::array<std::uint32_t, kBatch>;
  // The corners of four triangles, coordinate by coordinate, one triangle in each lane.
  struct Corners {
    std::array<Double4, 3> a, b, c;
  };
  struct alignas(32) Bounds {
    double distance[4], normal[3][4];
  };
  // How far rounding may move the bound for a point that is `off` away from the centre.
  static double rounding(double off) { return 0x1p-44 + 0x1p-40 * off; }
  static void bound(const Corners& corners, const Vec3& centre, Bounds& bounds) noexcept;
  bool add(const Batch& batch, int count, int most) noexcept;

  const TouchGeometry* geometry_ = nullptr;
  Vec3 centre_ = Vec3::Zero();
  double radius_ = -1.0;
  int count_ = 0;
  int outside_fans_ = 0;  // how many of these are in no large fan
  int queried_in_fans_ = 0;
  int gathered_ = 0;  // collected by the last gather(), even if they were too many
  // Unused lanes of the last four hold an infinite distance.
  alignas(32) std::array<double, kCapacity> distance_;
  alignas(32) std::array<std::array<double, kCapacity>, 3> normal_;
  std::array<std::uint32_t, kCapacity> triangle_;
  std::array<int, kPrepared> prepared_;  // the slot of each shape in shapes_; -1: none
  std::array<ContactTriangle, kPrepared> shapes_;
};

}  // namespace hapton
