#pragma once

#include "core/effects/bounded_force.h"
#include "core/effects/effect_sample.h"
#include "core/effects/effect_volume.h"

namespace hapton {

// A constant force in a volume: weight, buoyancy, wind. Frame: S. Units: SI. RT: yes.
// Bound: |force_n|. Passivity: conservative if it acts everywhere; active in a bounded volume, because a path that crosses it along
// the force and returns outside gains up to |force_n| times the size of the volume.
struct ConstantEffect {
  Vec3 force_n = Vec3::Zero();
  EffectVolume volume = EffectVolume::everywhere();

  Passivity passivity() const noexcept { return volume.is_everywhere() ? Passivity::conservative : Passivity::active; }
  double bound_n() const noexcept { return force_n.norm(); }
  Vec3 force(const EffectSample& sample) const noexcept {
    return volume.contains(sample.p_SD) ? bounded_force(force_n, kMaxEffectForceN) : Vec3(Vec3::Zero());
  }
};

}  // namespace hapton
