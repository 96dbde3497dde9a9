#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/tool/swept_motion.h"

namespace hapton {

// Planes that separate pieces of the tool from pieces of the scene, and whether they still do after the tool has moved.
//
// A plane's normal n is fixed in the scene's frame. If the tool has since moved by a shift d and turned by w (twice the vector part of the
// quaternion), a point with arm a from the grip point has risen along n by n . d + w . (a x n), to second order of w. So the height of a
// piece of the tool above a piece of the scene is known from one product of six numbers, and falls only by what the motion does along n: a
// tool that slides along a surface keeps the planes between the two.
//
// Numbers are in single precision, and every bound allows for their rounding.
// Frame: the scene's local one. RT: all but construction. Threads: put for different pairs concurrently, the others one at a time.
class SeparatingPlanes {
 public:
  // Placements of the tool that planes may refer to. Older planes separate nothing: they have to be found again.
  static constexpr std::uint32_t kMostStarts = 64;

  struct Plane {
    Vec3 normal = Vec3::Zero();                             // unit, from the scene to the tool
    double gap = -std::numeric_limits<double>::infinity();  // of the two pieces along it, at the start of the walk; a lower bound
    Vec3 arm = Vec3::Zero();                                // from the grip point to the middle of the tool's piece
    double radius = 0.0;                                    // of the tool's piece about its middle
  };

  // most: of pairs. radius: the largest distance of a point of the tool from the grip point.
  SeparatingPlanes(std::size_t most, double radius);

  // The next calls are about this motion: whether pairs stay farther apart than `distance` over all of it.
  void begin(const SweptMotion& motion, double distance) noexcept;
  // True if the pair's plane, held fixed, separates it over the motion; `gap` is then a lower bound of its distance at the start. Pre: i <
  // most.
  bool separates(std::size_t i, float& gap) noexcept;
  // The pair's plane at the start of the motion; the default separates nothing.
  void put(std::size_t i, const Plane& plane) noexcept;

 private:
  using Terms = float __attribute__((vector_size(32)));

  using Half = float __attribute__((vector_size(16)));

  // A placement that planes refer to, and the motion seen from there.
  struct Start {
    Placement placement;
    std::uint64_t walk = 0;  // of the motion
    Terms from{};            // what the terms are multiplied by: shift, 1; turn, -|turn|
    Terms to{};
    float slack_from = 0.0F;  // a sum less this is a lower bound of the gap
    float slack_to = 0.0F;
  };

  void see_from(Start& start) noexcept;

  double radius_;
  std::vector<Terms> terms_;             // of each plane: normal, gap; arm x normal, radius
  std::vector<std::uint32_t> start_of_;  // that it refers to
  std::array<Start, kMostStarts> starts_;
  std::uint32_t start_ = kMostStarts;  // counts up; planes of 0 are too old
  std::uint64_t walk_ = 0;
  Placement from_;
  Placement to_;
  float least_ = 0.0F;  // gap at both ends: the distance, and the sagitta of the motion's paths
};

inline bool SeparatingPlanes::separates(std::size_t i, float& gap) noexcept {
  const std::uint32_t number = start_of_[i];
  if (start_ - number >= kMostStarts) return false;
  Start& start = starts_[number % kMostStarts];
  if (start.walk != walk_) see_from(start);
  const Terms from = terms_[i] * start.from;
  const Terms to = terms_[i] * start.to;
  const Half of_from = __builtin_shufflevector(from, from, 0, 1, 2, 3) + __builtin_shufflevector(from, from, 4, 5, 6, 7);
  const Half of_to = __builtin_shufflevector(to, to, 0, 1, 2, 3) + __builtin_shufflevector(to, to, 4, 5, 6, 7);
  const Half both = __builtin_shufflevector(of_from, of_to, 0, 1, 4, 5) + __builtin_shufflevector(of_from, of_to, 2, 3, 6, 7);
  gap = both[0] + both[1] - start.slack_from;
  return gap > least_ && both[2] + both[3] - start.slack_to > least_;
}

}  // namespace hapton
