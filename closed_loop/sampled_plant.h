#pragma once

#include <Eigen/Core>
#include <complex>

#include "closed_loop/axis_plant.h"

namespace hapton {

// The axis between two samples, exactly: what is commanded for a sample reaches the motors after a delay and is held until the next
// command does (zero-order hold). A delay that is not a multiple of the period splits it: the older command holds for the first part.
//
//   delay = whole_periods T + rest
//   x[k+1] = transition x[k] + older u[k - whole_periods - 1] + newer u[k - whole_periods]
//
// Source: K. J. Åström and B. Wittenmark, Computer-Controlled Systems, "sampling a system with time delay". Units s. RT: no.
class SampledPlant {
 public:
  using Matrix = AxisPlant::Matrix;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, AxisPlant::kMaxStates, 1>;

  // Pre: period_s > 0, delay_s >= 0.
  SampledPlant(const AxisPlant& plant, double period_s, double delay_s);

  double period_s() const noexcept { return period_s_; }
  double delay_s() const noexcept { return delay_s_; }
  // From the command's sample to the position read, at z = e^(j angle); 0 < angle <= pi. Position over force, without whole_periods().
  std::complex<double> response(double angle) const;
  const Matrix& transition() const noexcept { return transition_; }
  const Vector& newer() const noexcept { return newer_; }
  const Vector& older() const noexcept { return older_; }
  int whole_periods() const noexcept { return whole_periods_; }
  // Without a wall every motion dies out; one that coasts may stay.
  bool is_stable_alone() const noexcept { return is_stable_alone_; }

 private:
  double period_s_;
  double delay_s_;
  int whole_periods_;
  bool is_stable_alone_;
  Matrix transition_;
  Vector newer_;
  Vector older_;
};

}  // namespace hapton
