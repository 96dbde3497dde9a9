#include "core/force/reference/half_space_projection.h"

#include <bit>
#include <limits>

namespace hapton {
namespace {

using Wide = Eigen::Matrix<long double, 3, 1>;

struct Basis {
  Wide point;
  std::array<std::size_t, 3> planes{};
  std::array<long double, 3> multiplier{};
  int count = 0;
};

Wide normal_of(const HalfSpace& half_space) { return half_space.normal.cast<long double>(); }

// The point nearest to `goal` on all of one, two or three planes. False if there is none: parallel planes or a zero normal.
bool meet_planes(const Wide& goal, std::span<const HalfSpace> all, Basis& basis) {
  const HalfSpace& first = all[basis.planes[0]];
  const Wide n1 = normal_of(first);
  if (basis.count == 1) {
    const long double length2 = n1.squaredNorm();
    if (!(length2 > 0.0L)) return false;
    basis.multiplier[0] = (first.gap - n1.dot(goal)) / length2;
    basis.point = goal + basis.multiplier[0] * n1;
    return true;
  }
  const HalfSpace& second = all[basis.planes[1]];
  const Wide n2 = normal_of(second);
  const Wide along = n1.cross(n2);
  if (basis.count == 2) {
    const long double along2 = along.squaredNorm();
    if (!(along2 > 0.0L)) return false;
    basis.point = (along.dot(goal) * along + first.gap * n2.cross(along) + second.gap * along.cross(n1)) / along2;
    const Wide correction = basis.point - goal;
    basis.multiplier[0] = correction.cross(n2).dot(along) / along2;
    basis.multiplier[1] = n1.cross(correction).dot(along) / along2;
    return true;
  }
  const HalfSpace& third = all[basis.planes[2]];
  const Wide n3 = normal_of(third);
  const Wide c1 = n2.cross(n3);
  const Wide c2 = n3.cross(n1);
  const long double volume = along.dot(n3);
  if (volume == 0.0L) return false;
  basis.point = (first.gap * c1 + second.gap * c2 + third.gap * along) / volume;
  const Wide correction = basis.point - goal;
  basis.multiplier = {correction.dot(c1) / volume, correction.dot(c2) / volume, correction.dot(along) / volume};
  return true;
}

bool is_optimal(const Basis& basis, std::span<const HalfSpace> all, const std::array<std::size_t, 4>& candidates, int count,
                long double tolerance) {
  for (int i = 0; i < basis.count; ++i) {
    if (!(basis.multiplier[i] >= -tolerance)) return false;
  }
  for (int i = 0; i < count; ++i) {
    if (!(normal_of(all[candidates[i]]).dot(basis.point) - all[candidates[i]].gap >= -tolerance)) return false;
  }
  return true;
}

// The best basis from the old one's planes and the newcomer. The newcomer is always in it, because the old optimum violates it.
bool exchange(const Wide& goal, std::span<const HalfSpace> all, std::size_t newcomer, long double tolerance, Basis& basis) {
  std::array<std::size_t, 4> candidates{};
  const int old = basis.count;
  for (int i = 0; i < old; ++i) candidates[i] = basis.planes[i];
  candidates[old] = newcomer;
  Basis best;
  long double best2 = std::numeric_limits<long double>::infinity();
  for (int subset = 0; subset < (1 << old); ++subset) {
    if (std::popcount(static_cast<unsigned>(subset)) > 2) continue;  // three planes at most
    Basis trial;
    trial.planes[trial.count++] = newcomer;
    for (int i = 0; i < old; ++i) {
      if ((subset >> i & 1) != 0) trial.planes[trial.count++] = candidates[i];
    }
    if (!meet_planes(goal, all, trial) || !is_optimal(trial, all, candidates, old + 1, tolerance)) continue;
    const long double distance2 = (trial.point - goal).squaredNorm();
    if (distance2 < best2) {
      best2 = distance2;
      best = trial;
    }
  }
  if (best.count == 0) return false;
  basis = best;
  return true;
}

}  // namespace

HalfSpaceProjection project_onto_half_spaces(const Vec3& goal, std::span<const HalfSpace> half_spaces, double tolerance) noexcept {
  const Wide target = goal.cast<long double>();
  Basis basis;
  basis.point = target;
  HalfSpaceProjection result;
  // Each exchange increases the distance; the limit guards against rounding that makes two bases alternate.
  const std::size_t most_rounds = 16 + 8 * half_spaces.size();
  for (std::size_t round = 0; round < most_rounds; ++round) {
    long double worst = -static_cast<long double>(tolerance);
    std::size_t violated = half_spaces.size();
    for (std::size_t i = 0; i < half_spaces.size(); ++i) {
      const long double slack = normal_of(half_spaces[i]).dot(basis.point) - half_spaces[i].gap;
      if (slack < worst) {
        worst = slack;
        violated = i;
      }
    }
    if (violated == half_spaces.size()) {
      result.feasible = true;
      break;
    }
    if (!exchange(target, half_spaces, violated, tolerance / 4, basis)) break;
  }
  result.point = basis.count == 0 ? goal : Vec3(basis.point.cast<double>());
  result.count = basis.count;
  for (int i = 0; i < basis.count; ++i) {
    result.active[i] = basis.planes[i];
    result.multiplier[i] = static_cast<double>(basis.multiplier[i]);
  }
  return result;
}

}  // namespace hapton
