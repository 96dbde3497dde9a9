#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/math/float8.h"
#include "core/tool/linearized_motion.h"
#include "core/tool/obb_tree.h"

namespace hapton {

// For each pair of boxes of a list, one of the tool and one of the scene, a plane that separated them earlier. The plane is fixed in the
// scene, and gives a lower bound of their distance wherever the tool goes: for eight pairs at a time, and without reading the boxes.
//
// The bound is the distance along the plane's normal when the plane was found, plus what the centre of the tool's box has moved along the
// normal since then, less the box's radius times the angle by which the tool has turned since then. So to first order only the turn of the
// box about its centre makes the bound too small; it is never too large. Motions are measured from a reference placement, so that rounding
// to single precision costs 2^-19 of the motion, not of the coordinates.
//
// Threads: put and clear may be called concurrently for different pairs. RT: all but construction.
class SeparatingPlanes {
 public:
  static constexpr std::size_t kTogether = 8;  // pairs

  // most: number of planes. radius: the largest distance of a point of the tool from the grip point.
  SeparatingPlanes(std::size_t most, double radius);

  // Sets a new reference placement. Each plane must be put or cleared before it is used again.
  void restart(const Placement& reference) noexcept;
  // The calls that follow are about this motion and the placement at its start. turned: upper bound of the angle, rad, from the placement
  // at the start of the last motion (the first time after restart: from the reference placement) to that at the start of this one.
  void begin(const LinearizedMotion& motion, double turned) noexcept;

  // A normal with about this direction, rounded as it is stored, not longer than 1. Pre: its squared length is finite and not zero.
  static Vec3 normal_along(const Vec3& direction) noexcept;
  // Lower bound of the gap between the boxes along a normal, which points from the scene to the tool, at the start of the motion.
  double gap_along(const Vec3& normal, const ObbTree::Node& tool, const ObbTree::Node& scene) const noexcept;
  // Stores plane i, with a normal from normal_along. gap: lower bound, at the start of the motion, of the gap along the normal between the
  // contents of the two boxes, to 2^-45 of the coordinates.
  void put(std::size_t i, const Vec3& normal, double gap, const ObbTree::Node& tool) noexcept;
  // Removes plane i: it gives no bound.
  void clear(std::size_t i) noexcept { groups_[i / kTogether].gap[i % kTogether] = -std::numeric_limits<float>::infinity(); }

  // Lower bounds of the distances; useful if positive.
  struct Gaps {
    Float8 start;  // at the start of the motion
    Float8 over;   // over the whole motion
  };
  // For the kTogether planes from kTogether * group on.
  Gaps find_gaps(std::size_t group) const noexcept;

 private:
  using Eight = std::array<float, kTogether>;
  struct alignas(32) Group {
    std::array<Eight, 3> normal = {};
    std::array<Eight, 3> arm = {};  // from the grip point to the centre of the tool's box, in the tool's axes
    Eight gap = {};                 // at the reference placement
    Eight radius = {};              // of the tool's box
  };
  // Affine map of an arm (in the tool's axes) to a displacement along the scene's axes: shift + turn * arm.
  struct Map {
    Vec3 shift = Vec3::Zero();
    Mat3 turn = Mat3::Zero();

    double size(double radius) const { return shift.cwiseAbs().sum() + 3.0 * radius * turn.norm(); }
  };
  // The same in single precision, along the normal of a plane.
  struct FloatMap {
    std::array<float, 3> shift = {};
    std::array<std::array<float, 3>, 3> turn = {};

    void set(const Map& map);
    Float8 along_normals(const Group& group) const noexcept;
  };

  double radius_;
  std::vector<Group> groups_;
  Placement reference_;
  Mat3 reference_turn_ = Mat3::Identity();
  Placement at_;  // where the motion starts
  Mat3 turn_ = Mat3::Identity();
  double turned_ = 0.0;  // rad: sum of the angles since the reference placement
  Map moved_;            // displacements since the reference placement
  FloatMap moved_float_;
  FloatMap motion_float_;
  // Rounded up:
  float turned_float_ = 0.0F;
  float angle_float_ = 0.0F;  // over the motion, a point of the box moves about the box's centre by this times its distance at most
  float start_error_ = 0.0F;
  float over_error_ = 0.0F;
};

// ---------------------------------------------------------------------------------------------------------------------

inline Float8 SeparatingPlanes::FloatMap::along_normals(const Group& group) const noexcept {
  const Float8 x = Float8::load(group.arm[0].data());
  const Float8 y = Float8::load(group.arm[1].data());
  const Float8 z = Float8::load(group.arm[2].data());
  Float8 sum(0.0F);
  for (std::size_t k = 0; k < 3; ++k) {
    const Float8 moved = fma(Float8(turn[k][0]), x, fma(Float8(turn[k][1]), y, fma(Float8(turn[k][2]), z, Float8(shift[k]))));
    sum = fma(Float8::load(group.normal[k].data()), moved, sum);
  }
  return sum;
}

inline SeparatingPlanes::Gaps SeparatingPlanes::find_gaps(std::size_t group) const noexcept {
  const Group& planes = groups_[group];
  const Float8 radius = Float8::load(planes.radius.data());
  const Float8 start = (moved_float_.along_normals(planes) + Float8::load(planes.gap.data())) - radius * Float8(turned_float_);
  const Float8 over = start + (min(motion_float_.along_normals(planes), Float8(0.0F)) - radius * Float8(angle_float_));
  constexpr float kRounded = 1.0F - 0x1p-20F;
  return {start * Float8(kRounded) - Float8(start_error_), over * Float8(kRounded) - Float8(over_error_)};
}

}  // namespace hapton
