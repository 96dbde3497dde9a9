#include "core/tool/least_motion.h"

#include <cmath>
#include <limits>

namespace hapton {
namespace {

// The active rows as Q R: Q has orthonormal columns, R is upper triangular. At most six columns, so it is made again when one is dropped.
class ActiveRows {
 public:
  // Coordinates of `row` along the active rows' span, and what is left of it.
  void split(const Vec6& row, Vec6& along, Vec6& rest) const {
    along.setZero();
    rest = row;
    for (int pass = 0; pass < 2; ++pass) {  // twice: orthogonal to rounding (Kahan & Parlett)
      for (int k = 0; k < count_; ++k) {
        const double share = q_.col(k).dot(rest);
        along[k] += share;
        rest -= share * q_.col(k);
      }
    }
  }
  // Solves R r = along.
  Vec6 solve(const Vec6& along) const {
    Vec6 r = Vec6::Zero();
    for (int i = count_ - 1; i >= 0; --i) {
      double sum = along[i];
      for (int j = i + 1; j < count_; ++j) sum -= r_(i, j) * r[j];
      r[i] = sum / r_(i, i);
    }
    return r;
  }
  void add(const Vec6& along, const Vec6& rest) {
    const double length = rest.norm();
    r_.col(count_) = along;
    r_(count_, count_) = length;
    q_.col(count_) = rest / length;
    ++count_;
  }
  void clear() { count_ = 0; }

 private:
  Eigen::Matrix<double, 6, 6> q_;
  Eigen::Matrix<double, 6, 6> r_;
  int count_ = 0;
};

}  // namespace

LeastMotion find_least_motion(const Vec6& goal, std::span<const MotionBound> bounds, double tolerance) noexcept {
  // Of a row's length: what is left of a row that the active ones span is rounding.
  constexpr double kDependent = 0x1p-40;
  // Each bound is added a few times at most in practice; the limit only ends what rounding could repeat.
  constexpr int kMostRounds = 200;
  LeastMotion found;
  found.y = goal;
  ActiveRows rows;
  int round = 0;
  while (true) {
    int worst = -1;
    double most = tolerance;
    for (int i = 0; i < static_cast<int>(bounds.size()); ++i) {
      const double missing = bounds[i].least - bounds[i].row.dot(found.y);
      if (missing > most) {
        most = missing;
        worst = i;
      }
    }
    if (worst < 0) return found;

    const Vec6& row = bounds[worst].row;
    double multiplier = 0.0;
    while (true) {
      if (++round > kMostRounds) {
        found.solved = false;
        return found;
      }
      Vec6 along;
      Vec6 rest;
      rows.split(row, along, rest);
      const Vec6 r = rows.solve(along);
      int blocking = -1;
      double step = std::numeric_limits<double>::infinity();
      for (int k = 0; k < found.active_count; ++k) {
        if (r[k] > 0.0 && found.multipliers[k] < step * r[k]) {
          step = found.multipliers[k] / r[k];
          blocking = k;
        }
      }
      const bool spans = rest.squaredNorm() <= kDependent * kDependent * row.squaredNorm();
      const double full = spans ? std::numeric_limits<double>::infinity() : (bounds[worst].least - row.dot(found.y)) / rest.squaredNorm();
      if (!spans && full <= step) {
        blocking = -1;
        step = full;
      }
      if (!std::isfinite(step)) {
        found.solved = false;
        return found;
      }
      if (!spans) found.y += step * rest;
      for (int k = 0; k < found.active_count; ++k) found.multipliers[k] -= step * r[k];
      multiplier += step;
      if (blocking < 0) {
        rows.add(along, rest);
        found.active[found.active_count] = worst;
        found.multipliers[found.active_count++] = multiplier;
        break;
      }
      // The blocking bound is released, and the others are factorized again without it.
      --found.active_count;
      for (int k = blocking; k < found.active_count; ++k) {
        found.active[k] = found.active[k + 1];
        found.multipliers[k] = found.multipliers[k + 1];
      }
      found.active[found.active_count] = -1;
      found.multipliers[found.active_count] = 0.0;
      rows.clear();
      for (int k = 0; k < found.active_count; ++k) {
        rows.split(bounds[found.active[k]].row, along, rest);
        rows.add(along, rest);
      }
    }
  }
}

}  // namespace hapton
