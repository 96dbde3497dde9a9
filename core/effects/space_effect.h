#pragma once

#include <type_traits>
#include <utility>
#include <variant>

#include "core/effects/burst_effect.h"
#include "core/effects/constant_effect.h"
#include "core/effects/effect_switch.h"
#include "core/effects/gravity_well_effect.h"
#include "core/effects/mass_effect.h"
#include "core/effects/snap_effect.h"
#include "core/effects/spring_effect.h"
#include "core/effects/viscous_effect.h"
#include "core/effects/wave_effect.h"

namespace hapton {

// An effect in free space: it acts on the device whether a surface is touched or not. Frame: S. Units: SI. RT: yes.
using SpaceEffect =
    std::variant<SpringEffect, ConstantEffect, SnapEffect, GravityWellEffect, ViscousEffect, WaveEffect, BurstEffect, MassEffect>;

struct PassivityOf {
  Passivity operator()(const ConstantEffect& effect) const noexcept { return effect.passivity(); }
  template <class Effect>
  Passivity operator()(const Effect&) const noexcept {
    return Effect::kPassivity;
  }
};

inline Passivity passivity_of(const SpaceEffect& effect) noexcept { return std::visit(PassivityOf(), effect); }

// The largest force that the effect can give, N.
inline double bound_of(const SpaceEffect& effect) noexcept {
  return std::visit([](const auto& e) { return e.bound_n(); }, effect);
}

// An effect, and when it acts; by default always.
struct SwitchedEffect {
  SpaceEffect effect;
  EffectSwitch on = {};

  template <class Effect>
  requires(!std::is_same_v<std::remove_cvref_t<Effect>, SwitchedEffect> && std::is_constructible_v<SpaceEffect, Effect>)
      SwitchedEffect(Effect&& made, EffectSwitch when = {})
      : effect(std::forward<Effect>(made)), on(when) {}

  Passivity passivity() const noexcept {
    const Passivity always = passivity_of(effect);
    return on.button == 0 || always == Passivity::dissipative ? always : Passivity::active;
  }
};

}  // namespace hapton
