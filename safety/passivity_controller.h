#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/math/types.h"
#include "safety/passivity_observer.h"

namespace hapton {

// Keeps each axis of the device passive, whatever computes its force and however late it comes: while an axis owes energy (observer below
// zero), its force does not act along the motion, and a damper takes the debt back.
//
//   E < 0:  f = (f along the motion ? 0 : f) - min(-E / (T v^2), most_damping) v
//
// An axis that owes nothing is left alone. The debt of one period can only be seen in the next, so that up to one period's energy may be
// out at a time. Source: Hannaford and Ryu 2002, as the observer. We differ in two ways: the damper is bounded by what the device can
// stably render, and what it cannot take back at once waits, during which the force may only oppose the motion; without the second part a
// bounded damper lets the debt grow. Units SI, frame W. RT: yes. Threads: one.
class PassivityController {
 public:
  struct Options {
    PassivityObserver::Options observer = {};
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
    const double debt_j = -axis.energy_j();
    if (!(debt_j > 0.0)) return wanted_n;
    worst_debt_j_ = std::max(worst_debt_j_, debt_j);
    const double velocity = axis.velocity_m_per_s();
    const double opposing_n = wanted_n * velocity > 0.0 ? 0.0 : wanted_n;
    if (velocity == 0.0) return opposing_n;
    const double damping = std::min(debt_j / (axis.period_s() * velocity * velocity), options_.most_damping_ns_per_m);
    return opposing_n - damping * velocity;
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
