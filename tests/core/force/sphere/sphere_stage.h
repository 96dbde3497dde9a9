#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "core/force/sphere/sphere_follower.h"
#include "core/math/straight_motion.h"
#include "tests/support/made_meshes.h"

namespace hapton {

using Outcome = SphereFollower::Outcome;

// A mesh in its local frame, a follower of that offset (in the mesh's unit) on it, and the device.
struct Stage {
  Stage(const TriangleMesh& mesh, double offset_m, const Material& material = {})
      : geometry({&mesh}),
        offset(offset_m / geometry.unit_m()),
        materials{material},
        follower(std::make_unique<SphereFollower>(geometry, materials, offset)) {}

  void put(const Vec3& p_S) {
    device = geometry.to_local(p_S);
    follower->start_free(device);
  }
  Outcome move(const Vec3& p_S) { return move_local(geometry.to_local(p_S)); }
  Outcome move_local(const Vec3& to) {
    double time = 0.0;
    const Outcome outcome = follower->follow(device, to, time);
    device = outcome == Outcome::exhausted ? on_path(device, to, time) : to;
    return outcome;
  }
  // Repeats the motion until its work limit no longer ends it, 100 times at most.
  Outcome finish(const Vec3& to) {
    Outcome outcome = move_local(to);
    for (int i = 0; i < 100 && outcome == Outcome::exhausted; ++i) outcome = move_local(to);
    return outcome;
  }
  Vec3 centre() const { return geometry.to_scene(follower->centre()); }
  double unit() const { return geometry.unit_m(); }

  // The distance to the nearest of all triangles, found without a search structure.
  double distance_to_nearest() const {
    double least = std::numeric_limits<double>::infinity();
    const auto count = static_cast<std::uint32_t>(geometry.triangle_count());
    for (std::uint32_t t = 0; t < count; ++t) least = std::min(least, geometry.separation(t, follower->centre()).distance);
    return least;
  }
  // How far the multipliers and normals are from summing up to centre - device.
  double imbalance() const {
    Vec3 sum = device - follower->centre();
    for (const OffsetContact& contact : follower->contacts()) {
      EXPECT_GE(contact.multiplier, 0.0);
      sum += contact.multiplier * contact.proximity(follower->centre()).normal;
    }
    return sum.norm();
  }

  TouchGeometry geometry;
  double offset;
  std::vector<Material> materials;
  std::unique_ptr<SphereFollower> follower;
  Vec3 device = Vec3::Zero();
};

constexpr double kStageOffset = 0.1;
constexpr double kCentreTolerance = 1e-11;  // larger than the slop and than the shift of borders
constexpr double kSlop = 0x1p-40;

inline void expect_centre(const Stage& stage, const Vec3& expected) {
  EXPECT_LT((stage.centre() - expected).norm(), kCentreTolerance) << stage.centre().transpose() << " not " << expected.transpose();
  EXPECT_GE(stage.distance_to_nearest(), stage.offset - kSlop);
  EXPECT_LT(stage.imbalance(), kCentreTolerance);
}

// Follows the motion in 37 parts. Returns false if one of them does not settle.
inline bool follow_in_parts(SphereFollower& follower, const Vec3& from, const Vec3& to) {
  constexpr int kParts = 37;
  Vec3 before = from;
  for (int k = 1; k <= kParts; ++k) {
    const Vec3 part = k == kParts ? to : Vec3(from + (to - from) * k / kParts);
    Outcome outcome = Outcome::exhausted;
    for (int i = 0; i < 100 && outcome == Outcome::exhausted; ++i) {
      double time = 0.0;
      outcome = follower.follow(before, part, time);
      before = outcome == Outcome::exhausted ? on_path(before, part, time) : part;
    }
    if (outcome != Outcome::settled) return false;
  }
  return true;
}

// A device that wanders at the surface of a bumpy sphere of radius 0.4, mostly inside.
class Wanderer {
 public:
  explicit Wanderer(std::uint64_t seed) : random_(seed) {}
  Vec3 next(double stride) {
    direction_ = (direction_ + stride * vector()).normalized();
    return 0.4 * (0.96 + 0.12 * unit_(random_)) * direction_;
  }

 private:
  Vec3 vector() {
    const double x = unit_(random_);
    const double y = unit_(random_);
    return {x, y, unit_(random_)};
  }
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> unit_{-1.0, 1.0};
  Vec3 direction_ = Vec3(0.3, 0.5, 0.7).normalized();
};

}  // namespace hapton
