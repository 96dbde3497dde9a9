#pragma once

#include <memory>

#include "core/force/touch_step.h"

namespace hapton {

// Computes the force for a device sample, in place of the haptics node in a simulated control loop. Frame W, SI. RT: step and reset yes.
class ForceLaw {
 public:
  virtual ~ForceLaw() = default;
  // The force on a device at p_WD. dt_s: time since the previous sample; 0: there was none.
  virtual Vec3 step(const Vec3& p_WD, double dt_s) noexcept = 0;
  virtual void reset(const Vec3& p_WD) noexcept = 0;
};

// A flat wall that fills x < 0: a spring, and damping by the finite difference of the position. One-sided: it only pushes, like a real
// surface. Two-sided: it pulls as well, as linear theory assumes.
class WallLaw final : public ForceLaw {
 public:
  struct Wall {
    double stiffness_n_per_m = 1000.0;
    double damping_ns_per_m = 0.0;
    bool two_sided = false;
  };

  explicit WallLaw(const Wall& wall) : wall_(wall) {}

  Vec3 step(const Vec3& p_WD, double dt_s) noexcept override;
  void reset(const Vec3& p_WD) noexcept override { previous_m_ = p_WD.x(); }

 private:
  Wall wall_;
  double previous_m_ = 0.0;
};

// A mesh that is touched with the same TouchStep as in the haptics node.
class TouchLaw final : public ForceLaw {
 public:
  explicit TouchLaw(std::shared_ptr<ForceMethod> method) : step_(std::move(method)) {}

  Vec3 step(const Vec3& p_WD, double dt_s) noexcept override { return step_.step({.p_WD = p_WD, .dt_s = dt_s}).force_n; }
  void reset(const Vec3& p_WD) noexcept override { step_.reset({.p_WD = p_WD}); }

 private:
  TouchStep step_;
};

}  // namespace hapton
