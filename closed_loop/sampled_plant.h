#pragma once

#include <Eigen/Core>
#include <complex>

#include "closed_loop/axis_plant.h"

namespace hapton {

// The exact motion of the axis from sample to sample: the command for a sample reaches the motors after a delay and is held until the next
// one arrives (zero-order hold). A delay that is not a multiple of the period splits it: the older command holds for the first part.
//
//   delay = whole_periods T + remainder
//   x[k+1] = transition x[k] + older_response u[k - whole_periods - 1] + newer_response u[k - whole_periods]
//
// Source: K. J. Åström and B. Wittenmark, Computer-Controlled Systems, "sampling a system with time delay". Units SI. RT: no.
class SampledPlant {
 public:
  using Matrix = AxisPlant::Matrix;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, AxisPlant::kMaxStates, 1>;

  // Pre: period_s > 0, delay_s >= 0.
  SampledPlant(const AxisPlant& plant, double period_s, double delay_s);

  double period_s() const noexcept { return period_s_; }
  double delay_s() const noexcept { return delay_s_; }
  // The response of the read position to the force, at z = e^(j angle), without the delay of whole_periods(). Pre: 0 < angle <= pi.
  std::complex<double> response(double angle) const;
  const Matrix& transition() const noexcept { return transition_; }
  const Vector& newer_response() const noexcept { return newer_response_; }
  const Vector& older_response() const noexcept { return older_response_; }
  int whole_periods() const noexcept { return whole_periods_; }
  // True if without a wall every motion dies out; where a free device comes to rest does not matter.
  bool is_stable_alone() const noexcept { return is_stable_alone_; }

 private:
  double period_s_;
  double delay_s_;
  int whole_periods_;
  bool is_stable_alone_;
  Matrix transition_;
  Vector newer_response_;
  Vector older_response_;
};

}  // namespace hapton
