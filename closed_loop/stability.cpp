#include "closed_loop/stability.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "closed_loop/largest_value.h"
#include "core/effects/smooth_velocity.h"
#include "core/math/dense_matrix.h"
#include "core/math/find_zero.h"

namespace hapton {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

// Between two angles that are evaluated, 1/L turns by at most kMaxTurn and its magnitude changes by at most kMaxGrowth (natural logarithm),
// so little that its imaginary part changes sign at most once.
constexpr double kMaxTurn = 0.1;
constexpr double kMaxGrowth = 0.2;
// Points whose |s| exceeds the least limit found so far by this factor are not refined.
constexpr double kFarAbove = 1.5;
// The angle over the whole delay of the loop, in rad, at which the search begins: no oscillation is so slow.
constexpr double kFirstTurn = 1e-6;

// (1 - 1/z) / T: velocity of a position by finite difference.
Complex difference(double angle, double period_s) {
  const double half = std::sin(0.5 * angle);
  return Complex(2.0 * half * half, std::sin(angle)) / period_s;
}

// Velocity of a position by SmoothVelocity.
Complex smooth_difference(double angle, double period_s) {
  constexpr int kDifferences = static_cast<int>(SmoothVelocity::kSamples);
  const Complex back = std::polar(1.0, -angle);
  Complex mean;
  for (int i = kDifferences - 1; i >= 0; --i) mean = mean * back + Complex(kDifferences - i);
  mean /= 0.5 * kDifferences * (kDifferences + 1);
  return mean * difference(angle, period_s);
}

// Minus the force of a virtual mass of 1 kg divided by the position, as MassEffect computes it with the velocity of SmoothVelocity.
Complex acceleration(double angle, double period_s, double filter_s) {
  const double share = -std::expm1(-period_s / filter_s);
  return share / (1.0 - (1.0 - share) * std::polar(1.0, -angle)) * smooth_difference(angle, period_s) * difference(angle, period_s);
}

// Solves 1 + (fixed + s * direction) L = 0 for s. Of `fixed` and s, one is the stiffness and the other the damping of the wall; or s is a
// viscosity or a virtual mass, and `fixed` is 0.
class Boundary {
 public:
  enum class Along { stiffness, damping, viscosity, mass };

  Boundary(const SampledPlant& plant, Along along, double fixed, double filter_s = 0.0)
      : plant_(plant), along_(along), fixed_(fixed), filter_s_(filter_s) {}

  struct Point {
    double angle = 0.0;
    Complex inverse;  // 1/L without the turn by the delay's whole periods
    Complex direction;
    Complex s;
    double min_abs_s = 0.0;  // lower bound of |s|, whatever the turn by whole periods
  };

  Point at(double angle) const {
    Point point{.angle = angle, .inverse = 1.0 / plant_.response(angle), .direction = 1.0, .s = {}};
    const Complex turn = std::polar(1.0, std::remainder(angle * plant_.whole_periods(), 2.0 * std::numbers::pi));
    const Complex velocity = difference(angle, plant_.period_s());
    if (along_ == Along::damping) point.direction = velocity;
    if (along_ == Along::viscosity) point.direction = smooth_difference(angle, plant_.period_s());
    if (along_ == Along::mass) point.direction = acceleration(angle, plant_.period_s(), filter_s_);
    const Complex fixed = along_ == Along::stiffness ? fixed_ * velocity : Complex(fixed_);
    point.s = -(point.inverse * turn + fixed) / point.direction;
    point.min_abs_s = std::fabs(std::abs(point.inverse) - std::abs(fixed)) / std::abs(point.direction);
    return point;
  }

  StabilityLimit find_first() const {
    StabilityLimit lowest{kUnlimited, 0.0};
    const double periods = plant_.whole_periods() + 1.5;
    Point here = at(kFirstTurn / periods);
    double step = here.angle;
    while (here.angle < std::numbers::pi) {
      const Point next = at(std::min(here.angle + step, std::numbers::pi));
      const double share = share_of_permitted_change(here, next, lowest.value);
      if (share > 1.0 && step > 1e-12 * here.angle) {
        step *= 0.5;
        continue;
      }
      note_crossing(here, next, lowest);
      if (share < 0.5) step *= 1.5;
      here = next;
    }
    note_end(here, lowest);
    return lowest;
  }

 private:
  // The difference between two neighbouring points, as a share of what is permitted.
  double share_of_permitted_change(const Point& here, const Point& next, double lowest_value) const {
    Complex ratio = next.inverse / here.inverse;
    // A filter in the direction turns, too; a plain difference only turns by half of the angle.
    if (along_ == Along::mass || along_ == Along::viscosity) ratio /= next.direction / here.direction;
    const double own_turn = std::fabs(std::arg(ratio));
    const double growth = std::fabs(std::log(std::abs(ratio)));
    const bool is_far = std::min(here.min_abs_s, next.min_abs_s) > kFarAbove * lowest_value;
    const double turn = is_far ? own_turn : own_turn + (next.angle - here.angle) * plant_.whole_periods();
    return std::max(turn / kMaxTurn, growth / kMaxGrowth);
  }

  void note_crossing(const Point& here, const Point& next, StabilityLimit& lowest) const {
    if (std::min(here.min_abs_s, next.min_abs_s) > kFarAbove * lowest.value) return;
    if ((here.s.imag() > 0.0) == (next.s.imag() > 0.0)) return;
    const double sign = here.s.imag() > 0.0 ? 1.0 : -1.0;
    const double angle = find_zero(here.angle, sign * here.s.imag(), next.angle, sign * next.s.imag(), 0.0,
                                   [&](double trial) { return sign * at(trial).s.imag(); });
    note(at(angle), lowest);
  }

  // At half the sampling rate everything is real, so no crossing is needed.
  void note_end(const Point& end, StabilityLimit& lowest) const { note(end, lowest); }

  void note(const Point& point, StabilityLimit& lowest) const {
    const double value = point.s.real();
    if (value <= 0.0 || value >= lowest.value) return;
    lowest = {value, point.angle / (2.0 * std::numbers::pi * plant_.period_s())};
  }

  const SampledPlant& plant_;
  Along along_;
  double fixed_;
  double filter_s_;
};

Eigen::MatrixXd make_loop_matrix(const SampledPlant& plant, const WallGains& wall) {
  const Eigen::Index n = plant.transition().rows();
  const Eigen::Index held_commands = plant.whole_periods() + 1;
  const double difference_gain = wall.damping_ns_per_m / plant.period_s();
  // States: the plant's, the commands of the last `held_commands` samples, the last position.
  const Eigen::Index position_row = n + held_commands;
  Eigen::MatrixXd loop = Eigen::MatrixXd::Zero(position_row + 1, position_row + 1);
  loop.topLeftCorner(n, n) = plant.transition();
  const auto add_command = [&](Eigen::Index row, Eigen::Index rows, const Eigen::VectorXd& gain, Eigen::Index age) {
    if (age > 0) {
      loop.block(row, n + age - 1, rows, 1) += gain;
      return;
    }
    loop.block(row, 0, rows, 1) -= (wall.stiffness_n_per_m + difference_gain) * gain;
    loop.block(row, position_row, rows, 1) += difference_gain * gain;
  };
  add_command(0, n, plant.newer_response(), plant.whole_periods());
  add_command(0, n, plant.older_response(), plant.whole_periods() + 1);
  add_command(n, 1, Eigen::VectorXd::Ones(1), 0);
  for (Eigen::Index i = 1; i < held_commands; ++i) loop(n + i, n + i - 1) = 1.0;
  loop(position_row, 0) = 1.0;
  return loop;
}

}  // namespace

StabilityLimit find_stable_stiffness(const SampledPlant& plant, double damping_ns_per_m) {
  if (!plant.is_stable_alone()) return {};
  if (damping_ns_per_m > 0.0 && damping_ns_per_m >= Boundary(plant, Boundary::Along::damping, 0.0).find_first().value) return {};
  return Boundary(plant, Boundary::Along::stiffness, damping_ns_per_m).find_first();
}

StabilityLimit find_stable_damping(const SampledPlant& plant, double stiffness_n_per_m) {
  if (!plant.is_stable_alone()) return {};
  if (stiffness_n_per_m > 0.0 && stiffness_n_per_m >= Boundary(plant, Boundary::Along::stiffness, 0.0).find_first().value) return {};
  return Boundary(plant, Boundary::Along::damping, stiffness_n_per_m).find_first();
}

StabilityLimit find_stable_viscosity(const SampledPlant& plant) {
  if (!plant.is_stable_alone()) return {};
  return Boundary(plant, Boundary::Along::viscosity, 0.0).find_first();
}

StabilityLimit find_stable_mass(const SampledPlant& plant, double filter_s) {
  if (!plant.is_stable_alone()) return {};
  return Boundary(plant, Boundary::Along::mass, 0.0, filter_s).find_first();
}

double compute_spectral_radius(const SampledPlant& plant, const WallGains& wall) {
  return compute_eigenvalues(make_loop_matrix(plant, wall)).cwiseAbs().maxCoeff();
}

double find_stable_stiffness_by_eigenvalues(const SampledPlant& plant, double damping_ns_per_m, double start_n_per_m, double growth) {
  const auto is_stable = [&](double stiffness) { return compute_spectral_radius(plant, {stiffness, damping_ns_per_m}) < 1.0; };
  double low = 0.0;
  double high = start_n_per_m;
  for (; is_stable(high); high *= growth) {
    low = high;
    if (!std::isfinite(high)) return high;
  }
  constexpr double kFine = 1e-9;  // relative width at which the search ends
  return bisect(low, high, kFine, is_stable);
}

}  // namespace hapton
