#include "closed_loop/velocity_estimator.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/effects/smooth_velocity.h"

namespace hapton {
namespace {

class Difference final : public VelocityEstimator {
 public:
  void reset(double position_m) noexcept override { previous_m_ = position_m; }
  double step(double position_m, double dt_s) noexcept override {
    const double velocity = (position_m - previous_m_) / dt_s;
    previous_m_ = position_m;
    return velocity;
  }

 private:
  double previous_m_ = 0.0;
};

class FirstOrder final : public VelocityEstimator {
 public:
  explicit FirstOrder(double cutoff_hz) : cutoff_hz_(cutoff_hz) {}
  void reset(double position_m) noexcept override {
    difference_.reset(position_m);
    velocity_ = 0.0;
  }
  double step(double position_m, double dt_s) noexcept override {
    const double share = -std::expm1(-2.0 * std::numbers::pi * cutoff_hz_ * dt_s);
    velocity_ += share * (difference_.step(position_m, dt_s) - velocity_);
    return velocity_;
  }

 private:
  double cutoff_hz_;
  Difference difference_;
  double velocity_ = 0.0;
};

class AdaptiveWindow final : public VelocityEstimator {
 public:
  AdaptiveWindow(int longest_window, double step_m) : longest_window_(longest_window), step_m_(step_m) {}
  void reset(double position_m) noexcept override {
    now_s_ = 0.0;
    count_ = 1;
    points_[0] = {0.0, position_m};
  }
  double step(double position_m, double dt_s) noexcept override {
    now_s_ += dt_s;
    points_[static_cast<std::size_t>(count_++ % kPoints)] = {now_s_, position_m};
    double velocity = slope(1);
    const auto most = static_cast<int>(std::min<std::int64_t>(longest_window_, count_ - 1));
    for (int n = 2; n <= most && passes_all(n); ++n) velocity = slope(n);
    return velocity;
  }

 private:
  struct Point {
    double time_s = 0.0;
    double position_m = 0.0;
  };
  static constexpr int kPoints = VelocityFilter::kMaxWindow + 1;

  // The point n samples before the newest.
  const Point& before(int n) const noexcept { return points_[static_cast<std::size_t>((count_ - 1 - n) % kPoints)]; }
  double slope(int n) const noexcept { return (before(0).position_m - before(n).position_m) / (before(0).time_s - before(n).time_s); }
  // Whether the line over the newest n intervals passes every position in between at a distance of at most one encoder step.
  bool passes_all(int n) const noexcept {
    const double velocity = slope(n);
    // At constant speed the distance can reach a whole step, and rounding must not decide.
    const double tolerance_m = step_m_ * (1.0 + 0x1p-20);
    for (int i = 1; i < n; ++i) {
      const double on_line_m = before(0).position_m - velocity * (before(0).time_s - before(i).time_s);
      if (std::fabs(on_line_m - before(i).position_m) > tolerance_m) return false;
    }
    return true;
  }

  int longest_window_;
  double step_m_;
  double now_s_ = 0.0;
  std::int64_t count_ = 0;
  std::array<Point, kPoints> points_ = {};
};

class Mean final : public VelocityEstimator {
 public:
  void reset(double position_m) noexcept override {
    velocity_.reset();
    velocity_.add(Vec3(position_m, 0.0, 0.0), 0.0);
  }
  double step(double position_m, double dt_s) noexcept override {
    velocity_.add(Vec3(position_m, 0.0, 0.0), dt_s);
    return velocity_.mean().x();
  }

 private:
  SmoothVelocity velocity_;
};

class Kalman final : public VelocityEstimator {
 public:
  Kalman(double acceleration, double step_m)
      : acceleration_variance_(acceleration * acceleration), reading_variance_(step_m * step_m / 12.0) {}
  void reset(double position_m) noexcept override {
    x_ = position_m;
    v_ = 0.0;
    p_xx_ = 0.0;
    p_xv_ = 0.0;
    p_vv_ = 0.0;
  }
  double step(double position_m, double dt_s) noexcept override {
    const double velocity_variance = acceleration_variance_ * dt_s * dt_s;
    x_ += v_ * dt_s;
    p_xx_ += 2.0 * dt_s * p_xv_ + dt_s * dt_s * p_vv_ + 0.25 * velocity_variance * dt_s * dt_s;
    p_xv_ += dt_s * p_vv_ + 0.5 * velocity_variance * dt_s;
    p_vv_ += velocity_variance;
    // A reading's variance is at least that of the motion by one random acceleration in a step. With a finer reading the filter would take
    // every reading as exact, and the estimate would oscillate for ever.
    const double reading_variance = std::max(reading_variance_, 0.25 * velocity_variance * dt_s * dt_s);
    const double gain_x = p_xx_ / (p_xx_ + reading_variance);
    const double gain_v = p_xv_ / (p_xx_ + reading_variance);
    const double innovation = position_m - x_;
    x_ += gain_x * innovation;
    v_ += gain_v * innovation;
    p_vv_ -= gain_v * p_xv_;
    p_xv_ *= 1.0 - gain_x;
    p_xx_ *= 1.0 - gain_x;
    return v_;
  }

 private:
  double acceleration_variance_;
  double reading_variance_;
  double x_ = 0.0;
  double v_ = 0.0;
  // Covariance of the errors of position and velocity.
  double p_xx_ = 0.0;
  double p_xv_ = 0.0;
  double p_vv_ = 0.0;
};

double read_encoder(double position_m, double step_m) { return step_m > 0.0 ? step_m * std::floor(position_m / step_m) : position_m; }

// Visits time and estimate of each sample of a motion, once the estimate has settled.
template <class PositionAt, class Visit>
void visit_estimates(const VelocityFilter& filter, double period_s, double step_m, const PositionAt& position_at, const Visit& visit) {
  constexpr double kSettleS = 0.3;  // longer than the longest window at 250 Hz (kMaxWindow)
  constexpr double kSeconds = 1.3;  // length of the motion, so the estimate is measured for 1 s
  const auto estimator = make_velocity_estimator(filter, step_m);
  estimator->reset(0.0);
  for (int k = 1; k * period_s < kSeconds; ++k) {
    const double t_s = k * period_s;
    const double velocity = estimator->step(read_encoder(position_at(t_s), step_m), period_s);
    if (t_s >= kSettleS) visit(t_s, velocity);
  }
}

// RMS error at a steady speed.
double find_noise(const VelocityFilter& filter, double period_s, double step_m, double speed) {
  double sum = 0.0;
  int count = 0;
  visit_estimates(
      filter, period_s, step_m, [&](double t_s) { return speed * t_s; },
      [&](double, double velocity) {
        sum += (velocity - speed) * (velocity - speed);
        ++count;
      });
  return std::sqrt(sum / count);
}

double find_lag(const VelocityFilter& filter, double period_s, double step_m) {
  constexpr double kAcceleration = 1.0;
  double sum = 0.0;
  int count = 0;
  visit_estimates(
      filter, period_s, step_m, [&](double t_s) { return 0.5 * kAcceleration * t_s * t_s; },
      [&](double t_s, double velocity) {
        sum += t_s - velocity / kAcceleration;
        ++count;
      });
  return sum / count;
}

}  // namespace

std::string VelocityFilter::name() const {
  switch (kind) {
    case Kind::difference:
      return "difference";
    case Kind::first_order:
      return fmt::format("first-order {:g} Hz", parameter);
    case Kind::adaptive:
      return fmt::format("adaptive {:g} samples", parameter);
    case Kind::mean:
      return fmt::format("mean {} samples", SmoothVelocity::kSamples);
    case Kind::kalman:
      return fmt::format("kalman {:g} m/s^2", parameter);
  }
  return "difference";
}

std::vector<VelocityFilter> velocity_filters() {
  using Kind = VelocityFilter::Kind;
  return {{Kind::difference},        {Kind::first_order, 200.0}, {Kind::first_order, 100.0},
          {Kind::first_order, 50.0}, {Kind::first_order, 20.0},  {Kind::adaptive, 8.0},
          {Kind::adaptive, 16.0},    {Kind::adaptive, 32.0},     {Kind::mean},
          {Kind::kalman, 30.0},      {Kind::kalman, 10.0},       {Kind::kalman, 3.0},
          {Kind::kalman, 1.0}};
}

std::unique_ptr<VelocityEstimator> make_velocity_estimator(const VelocityFilter& filter, double step_m) {
  switch (filter.kind) {
    case VelocityFilter::Kind::first_order:
      return std::make_unique<FirstOrder>(filter.parameter);
    case VelocityFilter::Kind::adaptive:
      return std::make_unique<AdaptiveWindow>(static_cast<int>(filter.parameter), step_m);
    case VelocityFilter::Kind::mean:
      return std::make_unique<Mean>();
    case VelocityFilter::Kind::kalman:
      return std::make_unique<Kalman>(filter.parameter, step_m);
    case VelocityFilter::Kind::difference:
      break;
  }
  return std::make_unique<Difference>();
}

VelocityQuality measure_velocity(const VelocityFilter& filter, double period_s, double step_m) {
  VelocityQuality quality;
  // The speeds are no multiples of each other: one that moves a whole number of encoder steps in a period shows no noise.
  for (const double speed : {0.00103, 0.00317, 0.0101, 0.0331, 0.1009, 0.3019}) {
    quality.noise_m_per_s = std::max(quality.noise_m_per_s, find_noise(filter, period_s, step_m, speed));
  }
  quality.lag_s = find_lag(filter, period_s, step_m);
  return quality;
}

std::vector<VelocityRow> compare_velocity(double period_s, double step_m) {
  std::vector<VelocityRow> rows;
  for (const VelocityFilter& filter : velocity_filters()) rows.push_back({filter, measure_velocity(filter, period_s, step_m)});
  return rows;
}

const VelocityRow* choose_velocity(const std::vector<VelocityRow>& rows, double most_noise_m_per_s) noexcept {
  const VelocityRow* chosen = nullptr;
  for (const VelocityRow& row : rows) {
    if (!(row.quality.noise_m_per_s <= most_noise_m_per_s)) continue;
    if (chosen == nullptr || row.quality.lag_s < chosen->quality.lag_s) chosen = &row;
  }
  return chosen;
}

}  // namespace hapton
