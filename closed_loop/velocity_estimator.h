#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace hapton {

// The velocity of one axis from the positions that an encoder reads. Units: SI. RT: step and reset yes. Threads: one.
class VelocityEstimator {
 public:
  virtual ~VelocityEstimator() = default;
  // At rest there.
  virtual void reset(double position_m) noexcept = 0;
  // dt_s: since the position before. Pre: dt_s > 0.
  virtual double step(double position_m, double dt_s) noexcept = 0;
};

// One estimator and its one parameter, which trades noise for lag.
//
//   difference    two positions over the time between them
//   first_order   the same behind a first-order low-pass; parameter: cutoff, Hz
//   adaptive      the longest window whose end-to-end line passes all positions within an encoder step; parameter: longest window, samples.
//                 Source: Janabi-Sharifi, Hayward, Chen 2000, "Discrete-time adaptive windowing for velocity estimation", end-fit
//   mean          the weighted mean of the last 8 differences that effects run with (core/effects/smooth_velocity.h)
//   kalman        a mass pushed by white noise, read by an encoder with an error of a twelfth of a squared step; parameter: RMS of its
//                 acceleration, m/s^2
struct VelocityFilter {
  enum class Kind : std::uint8_t { difference, first_order, adaptive, mean, kalman };
  static constexpr int kMaxWindow = 64;

  Kind kind = Kind::difference;
  double parameter = 0.0;

  // "first-order 100 Hz". RT: no.
  std::string name() const;
};

// What is compared: each kind with the parameters that people use. RT: no.
std::vector<VelocityFilter> velocity_filters();

// step_m: of the encoder; 0: exact. Pre: a parameter above 0 where the kind has one, windows up to kMaxWindow. RT: no.
std::unique_ptr<VelocityEstimator> make_velocity_estimator(const VelocityFilter& filter, double step_m);

// How good an estimator is.
struct VelocityQuality {
  double noise_m_per_s = 0.0;  // RMS error at steady speeds from 1 to 300 mm/s, of the worst of them
  double lag_s = 0.0;          // how late it is at a steady acceleration of 1 m/s^2
};
// Read at equal intervals by an encoder that rounds down. Pre: period_s > 0, step_m >= 0. RT: no.
VelocityQuality measure_velocity(const VelocityFilter& filter, double period_s, double step_m);

struct VelocityRow {
  VelocityFilter filter;
  VelocityQuality quality;
};
// All velocity_filters(). RT: no.
std::vector<VelocityRow> compare_velocity(double period_s, double step_m);
// The filter with the least lag whose noise is at most this; null: all have more noise.
const VelocityRow* choose_velocity(const std::vector<VelocityRow>& rows, double most_noise_m_per_s) noexcept;

}  // namespace hapton
