#include "core/tool/least_motion.h"

#include <cmath>
#include <limits>

namespace hapton {
namespace {

// The active rows as Q R: Q has orthonormal columns, R is upper triangular. At most six columns, so both are made again if one is dropped.
class ActiveRows {
 public:
  // Coordinates of `row` along the active rows' span, and what is left of it.
  void split(const Vec6& row, Vec6& along, Vec6& residual) const {
    along.setZero();
    residual = row;
    for (int pass = 0; pass < 2; ++pass) {  // after the second pass, `residual` is orthogonal to them within rounding (Kahan & Parlett)
      for (int k = 0; k < count_; ++k) {
        const double share = q_.col(k).dot(residual);
        along[k] += share;
        residual -= share * q_.col(k);
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
  void add(const Vec6& along, const Vec6& residual) {
    const double length = residual.norm();
    r_.col(count_) = along;
    r_(count_, count_) = length;
    q_.col(count_) = residual / length;
    ++count_;
  }
  void clear() { count_ = 0; }

 private:
  Eigen::Matrix<double, 6, 6> q_;
  Eigen::Matrix<double, 6, 6> r_;
  int count_ = 0;
};

// The bound that y misses by the most, if by more than the tolerance; -1 if there is none.
int find_worst(std::span<const MotionBound> bounds, const Vec6& y, double tolerance) {
  int worst = -1;
  double most = tolerance;
  for (int i = 0; i < static_cast<int>(bounds.size()); ++i) {
    const double missing = bounds[i].least - bounds[i].row.dot(y);
    if (missing > most) {
      most = missing;
      worst = i;
    }
  }
  return worst;
}

// The active bound whose multiplier reaches zero first when they change by -step * r, and at which step; -1 and infinity if there is none.
int find_blocking(const LeastMotion& found, const Vec6& r, double& step) {
  int blocking = -1;
  step = std::numeric_limits<double>::infinity();
  for (int k = 0; k < found.active_count; ++k) {
    if (r[k] > 0.0 && found.multipliers[k] < step * r[k]) {
      step = found.multipliers[k] / r[k];
      blocking = k;
    }
  }
  return blocking;
}

// Releases the bound, and factorizes the others again without it.
void release(int blocking, std::span<const MotionBound> bounds, LeastMotion& found, ActiveRows& rows) {
  --found.active_count;
  for (int k = blocking; k < found.active_count; ++k) {
    found.active[k] = found.active[k + 1];
    found.multipliers[k] = found.multipliers[k + 1];
  }
  found.active[found.active_count] = -1;
  found.multipliers[found.active_count] = 0.0;
  rows.clear();
  for (int k = 0; k < found.active_count; ++k) {
    Vec6 along;
    Vec6 residual;
    rows.split(bounds[found.active[k]].row, along, residual);
    rows.add(along, residual);
  }
}

}  // namespace

LeastMotion find_least_motion(const Vec6& goal, std::span<const MotionBound> bounds, double tolerance) noexcept {
  // Share of a row's length: if no more of the row is left beside the span of the active rows, it is rounding: the row is in the span.
  constexpr double kDependent = 0x1p-40;
  // Each bound is added a few times at most in practice; the limit only ends repetitions that rounding could cause.
  constexpr int kMaxRounds = 200;
  LeastMotion found;
  found.y = goal;
  ActiveRows rows;
  int round = 0;
  while (true) {
    const int worst = find_worst(bounds, found.y, tolerance);
    if (worst < 0) return found;

    const Vec6& row = bounds[worst].row;
    double multiplier = 0.0;
    for (bool is_added = false; !is_added;) {
      if (++round > kMaxRounds) {
        found.solved = false;
        return found;
      }
      Vec6 along;
      Vec6 residual;
      rows.split(row, along, residual);
      const Vec6 r = rows.solve(along);
      double step = 0.0;
      int blocking = find_blocking(found, r, step);
      const bool is_dependent = residual.squaredNorm() <= kDependent * kDependent * row.squaredNorm();
      const double full_step =
          is_dependent ? std::numeric_limits<double>::infinity() : (bounds[worst].least - row.dot(found.y)) / residual.squaredNorm();
      if (!is_dependent && full_step <= step) {
        blocking = -1;
        step = full_step;
      }
      if (!std::isfinite(step)) {
        found.solved = false;
        return found;
      }
      if (!is_dependent) found.y += step * residual;
      for (int k = 0; k < found.active_count; ++k) found.multipliers[k] -= step * r[k];
      multiplier += step;
      is_added = blocking < 0;
      if (!is_added) {
        release(blocking, bounds, found, rows);
        continue;
      }
      rows.add(along, residual);
      found.active[found.active_count] = worst;
      found.multipliers[found.active_count++] = multiplier;
    }
  }
}

}  // namespace hapton
