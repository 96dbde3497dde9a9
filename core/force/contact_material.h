#pragma once

#include "core/force/touch_scene.h"

namespace hapton {

// The material of a contact with several active constraints. Stiffness, damping and friction are the means of the constraints' materials,
// weighted by their multipliers. A constraint whose multiplier falls to zero has no weight when it is released, so the force is continuous
// at its release; constraints of one material give exactly that material. The force stays along the penetration vector.
//
// If all multipliers are zero, the first constraint's material is used. two_sided always comes from the first constraint.
// RT: yes.
class ContactMaterial {
 public:
  // multiplier: >= 0; any unit, the same for all constraints.
  void add(const Material& material, double multiplier) noexcept {
    if (!has_material_) mean_ = material;
    has_material_ = true;
    if (!(multiplier > 0.0)) return;
    multiplier_sum_ += multiplier;
    // The mean is updated by differences, so equal values are kept exactly: their difference is zero.
    const double share = multiplier / multiplier_sum_;
    if (share == 1.0) {  // the first constraint with a weight
      const bool two_sided = mean_.two_sided;
      mean_ = material;
      mean_.two_sided = two_sided;
      return;
    }
    mean_.stiffness_n_per_m += share * (material.stiffness_n_per_m - mean_.stiffness_n_per_m);
    mean_.damping_ns_per_m += share * (material.damping_ns_per_m - mean_.damping_ns_per_m);
    mean_.friction_static += share * (material.friction_static - mean_.friction_static);
    mean_.friction_dynamic += share * (material.friction_dynamic - mean_.friction_dynamic);
  }

  const Material& mean() const noexcept { return mean_; }

 private:
  Material mean_;
  double multiplier_sum_ = 0.0;
  bool has_material_ = false;
};

}  // namespace hapton
