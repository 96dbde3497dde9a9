#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/math/types.h"
#include "safety/passivity_observer.h"

namespace hapton {

// Keeps each axis of the device passive, whatever computes its force and however late it comes. E: what the observer has saved up, v:
// velocity along the force, m: the device's own mass, T: the period.
//
//   bound   |f| <= m/T (-v + sqrt(v^2 + 2 E/m)): with no more than the device's mass to carry, the force gives back at most E until the
//   next sample.
//           Without savings it may at most stop the motion
//   damper  E < 0: f -= min(-E / (T v^2), most_damping) v, which takes the debt back
//
// A wall stays far below the bound up to a stiffness of m/T^2 (45 N/mm for a Touch at 1 kHz): then it is left alone. A hand that pulls
// along the force during the period can draw more; the damper takes that back. Source: Hannaford and Ryu 2002, as the observer. We differ
// in two ways: the damper is bounded by what the device can stably render, and the bound keeps a debt from arising that the damper could
// only see one period later. Units SI, frame W. RT: yes. Threads: one.
class PassivityController {
 public:
  struct Options {
    PassivityObserver::Options observer = {};
    double mass_kg = 0.05;  // of the device, without hand; lighter than it is makes the bound stricter
    double most_damping_ns_per_m = 1.0;
  };

  explicit PassivityController(const Options& options)
      : options_(options),
        axes_{PassivityObserver(options.observer), PassivityObserver(options.observer), PassivityObserver(options.observer)} {}

  // A sample, taken at now_ns. Pre, here and below: now_ns does not go back.
  void observe(const Vec3& p_WD, std::int64_t now_ns) noexcept {
    advance(now_ns);
    for (int i = 0; i < 3; ++i) axes_[i].observe(p_WD[i]);
  }

  // The force to write now in place of a finite `wanted_n`; it must be the one that is written.
  const Vec3& shape(const Vec3& wanted_n, std::int64_t now_ns) noexcept {
    advance(now_ns);
    for (int i = 0; i < 3; ++i) written_n_[i] = shape_axis(axes_[i], wanted_n[i]);
    acted_ += (written_n_ - wanted_n).squaredNorm() > 0.0 ? 1 : 0;
    return written_n_;
  }

  // Something after this stage limited the force: this is on the motors.
  void note_written(const Vec3& force_n) noexcept { written_n_ = force_n; }

  // Of all axes together.
  double energy_j() const noexcept { return axes_[0].energy_j() + axes_[1].energy_j() + axes_[2].energy_j(); }
  // Largest debt of an axis so far.
  double worst_debt_j() const noexcept { return worst_debt_j_; }
  // How often it changed a force.
  std::uint64_t acted() const noexcept { return acted_; }

 private:
  void advance(std::int64_t now_ns) noexcept {
    const double passed_s = has_begun_ ? 1e-9 * static_cast<double>(std::max<std::int64_t>(0, now_ns - now_ns_)) : 0.0;
    has_begun_ = true;
    now_ns_ = now_ns;
    for (int i = 0; i < 3; ++i) axes_[i].held(written_n_[i], passed_s);
  }

  double shape_axis(const PassivityObserver& axis, double wanted_n) noexcept {
    const double period_s = axis.period_s();
    if (!(period_s > 0.0)) return wanted_n;
    const double velocity = axis.velocity_m_per_s();
    const double energy_j = axis.energy_j();
    const double bounded_n =
        std::copysign(std::min(std::fabs(wanted_n), bound_n(energy_j, std::copysign(1.0, wanted_n) * velocity, period_s)), wanted_n);
    if (energy_j >= 0.0) return bounded_n;
    worst_debt_j_ = std::max(worst_debt_j_, -energy_j);
    if (velocity == 0.0) return bounded_n;
    return bounded_n - std::min(-energy_j / (period_s * velocity * velocity), options_.most_damping_ns_per_m) * velocity;
  }

  // velocity: along the force.
  double bound_n(double energy_j, double velocity, double period_s) const noexcept {
    const double squared = velocity * velocity + 2.0 * energy_j / options_.mass_kg;
    return options_.mass_kg / period_s * std::max(0.0, std::sqrt(std::max(0.0, squared)) - velocity);
  }

  Options options_;
  PassivityObserver axes_[3];
  Vec3 written_n_ = Vec3::Zero();
  std::int64_t now_ns_ = 0;
  double worst_debt_j_ = 0.0;
  std::uint64_t acted_ = 0;
  bool has_begun_ = false;
};

}  // namespace hapton
