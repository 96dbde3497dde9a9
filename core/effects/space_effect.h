#pragma once

#include <variant>

#include "core/effects/burst_effect.h"
#include "core/effects/constant_effect.h"
#include "core/effects/gravity_well_effect.h"
#include "core/effects/snap_effect.h"
#include "core/effects/spring_effect.h"
#include "core/effects/viscous_effect.h"
#include "core/effects/wave_effect.h"

namespace hapton {

// An effect in free space: it acts on the device whether a surface is touched or not.
using SpaceEffect = std::variant<SpringEffect, ConstantEffect, SnapEffect, GravityWellEffect, ViscousEffect, WaveEffect, BurstEffect>;

struct PassivityOf {
  Passivity operator()(const ConstantEffect& effect) const noexcept { return effect.passivity(); }
  template <class Effect>
  Passivity operator()(const Effect&) const noexcept {
    return Effect::kPassivity;
  }
};

inline Passivity passivity_of(const SpaceEffect& effect) noexcept { return std::visit(PassivityOf(), effect); }

// The largest force it can give, N.
inline double bound_of(const SpaceEffect& effect) noexcept {
  return std::visit([](const auto& e) { return e.bound_n(); }, effect);
}

}  // namespace hapton
