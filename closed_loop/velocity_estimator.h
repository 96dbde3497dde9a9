#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace hapton {

// Estimates the velocity of one axis from the positions that an encoder reads. Units: SI. RT: step and reset yes. Threads: one.
class VelocityEstimator {
 public:
  virtual ~VelocityEstimator() = default;
  // Begins anew, at rest at this position.
  virtual void reset(double position_m) noexcept = 0;
  // The velocity at this position. dt_s: time since the previous position. Pre: dt_s > 0.
  virtual double step(double position_m, double dt_s) noexcept = 0;
};

// One kind of estimator and its one parameter, which trades noise for lag.
//
//   difference    the change of position since the last sample, divided by the time between
//   first_order   this difference after a first-order low-pass; parameter: cutoff, Hz
//   adaptive      the longest window whose end-to-end line passes all positions within an encoder step; parameter: longest window, samples.
//                 Source: Janabi-Sharifi, Hayward, Chen 2000, "Discrete-time adaptive windowing for velocity estimation", end-fit
//   mean          the weighted mean of the last 8 differences, which the effects use (core/effects/smooth_velocity.h)
//   kalman        a mass pushed by white noise, whose position is read with a variance of step_m^2 / 12; parameter: RMS of its
//                 acceleration, m/s^2
struct VelocityFilter {
  enum class Kind : std::uint8_t { difference, first_order, adaptive, mean, kalman };
  static constexpr int kMaxWindow = 64;

  Kind kind = Kind::difference;
  double parameter = 0.0;

  // "first-order 100 Hz". RT: no.
  std::string name() const;
};

// The filters that are compared: each kind with the parameters that people use. RT: no.
std::vector<VelocityFilter> velocity_filters();

// step_m: step of the encoder; 0: exact positions. Pre: a parameter above 0 where the kind has one, windows up to kMaxWindow. RT: no.
std::unique_ptr<VelocityEstimator> make_velocity_estimator(const VelocityFilter& filter, double step_m);

// The errors of an estimator.
struct VelocityQuality {
  double noise_m_per_s = 0.0;  // RMS error at the worst of some steady speeds from 1 to 300 mm/s
  double lag_s = 0.0;          // delay of the estimate at a steady acceleration of 1 m/s^2
};
// Measures on positions read at equal intervals by an encoder that rounds down. Pre: 0 < period_s <= 1, step_m >= 0. RT: no.
VelocityQuality measure_velocity(const VelocityFilter& filter, double period_s, double step_m);

struct VelocityRow {
  VelocityFilter filter;
  VelocityQuality quality;
};
// The quality of all velocity_filters(). Pre: as for measure_velocity. RT: no.
std::vector<VelocityRow> compare_velocity(double period_s, double step_m);
// The row with the least lag whose noise is at most most_noise_m_per_s; null: all have more noise.
const VelocityRow* choose_velocity(const std::vector<VelocityRow>& rows, double most_noise_m_per_s) noexcept;

}  // namespace hapton
