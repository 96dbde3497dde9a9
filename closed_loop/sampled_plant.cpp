#include "closed_loop/sampled_plant.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/math/dense_matrix.h"

namespace hapton {
namespace {

// A delay this near to a multiple of the period, as a share of the period, counts as that multiple.
constexpr double kSameInstant = 1e-9;

struct HeldStep {
  SampledPlant::Matrix transition;
  SampledPlant::Vector response;
};

// The transition of the state, and its response to the command, over a time in which the command is held.
HeldStep hold(const AxisPlant& plant, double duration_s) {
  const int n = plant.states();
  Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(n + 1, n + 1);
  whole.topLeftCorner(n, n) = plant.a;
  whole.topRightCorner(n, 1) = plant.b.col(AxisPlant::command);
  const Eigen::MatrixXd over = compute_exponential(whole * duration_s);
  return {over.topLeftCorner(n, n), over.topRightCorner(n, 1)};
}

// Whether every pole of the plant in continuous time has a negative real part, except for one at 0 (a free device coasts). Slow damping
// and coasting are well apart in continuous time. A pole nearer to the imaginary axis than kOnAxis times the fastest rates is on it.
bool is_damped(const AxisPlant& plant) {
  constexpr double kOnAxis = 1e-10;
  const Eigen::MatrixXd rates = plant.a;
  const double near_axis = kOnAxis * rates.norm();
  int coasting = 0;
  for (const std::complex<double>& pole : compute_eigenvalues(rates)) {
    if (pole.real() < -near_axis) continue;
    if (std::abs(pole) > near_axis || ++coasting > 1) return false;
  }
  return true;
}

}  // namespace

SampledPlant::SampledPlant(const AxisPlant& plant, double period_s, double delay_s)
    : period_s_(period_s),
      delay_s_(delay_s),
      whole_periods_(static_cast<int>(std::floor(delay_s / period_s + kSameInstant))),
      is_stable_alone_(is_damped(plant)) {
  const double remainder_s = std::max(0.0, delay_s - whole_periods_ * period_s);
  const HeldStep old_part = hold(plant, remainder_s);
  const HeldStep new_part = hold(plant, period_s - remainder_s);
  transition_ = hold(plant, period_s).transition;
  newer_response_ = new_part.response;
  older_response_ = new_part.transition * old_part.response;
}

std::complex<double> SampledPlant::response(double angle) const {
  using ComplexMatrix = Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic, 0, AxisPlant::kMaxStates, AxisPlant::kMaxStates>;
  using ComplexVector = Eigen::Matrix<Complex, Eigen::Dynamic, 1, 0, AxisPlant::kMaxStates, 1>;
  // z - 1 without the cancellation near z = 1, where positions change little from sample to sample.
  const double half = std::sin(0.5 * angle);
  const Complex z_minus_1(-2.0 * half * half, std::sin(angle));
  const Complex z = 1.0 + z_minus_1;
  const Eigen::Index n = transition_.rows();
  ComplexMatrix left = (Matrix::Identity(n, n) - transition_).cast<Complex>();
  left.diagonal().array() += z_minus_1;
  const ComplexVector right = newer_response_.cast<Complex>() + older_response_.cast<Complex>() / z;
  const ComplexVector state = left.partialPivLu().solve(right);
  return state[0];
}

}  // namespace hapton
