#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "core/effects/bounded_force.h"
#include "core/effects/effect_sample.h"

namespace hapton {

// One membrane below the surface, and the tissue behind it.
struct TissueLayer {
  double depth_m = 0.0;                                          // where it lies, unloaded
  double stiffness_n_per_m = 500.0;                              // until it is punctured
  double pop_force_n = std::numeric_limits<double>::infinity();  // it is punctured above this force; infinite: never
  double drag_ns_per_m = 0.0;                                    // along the needle, in the tissue behind it, once it is punctured
};

// Layers that a needle punctures one after the other (skin, fat, muscle, bone), along the contact normal. They replace the spring of the
// material. The layer in front resists like a spring from its rest depth until pop_force_n; then it is punctured and its force drops. The
// next layer begins to resist at its depth_m or, if the needle is deeper already, at the needle's depth: a puncture never leaves a tension
// that nobody has put in. A needle drawn back from there meets no spring, only drag. All layers are whole again when the contact ends.
// Units: SI. RT: yes.
//
// Bound: kMaxEffectForceN. Passivity: dissipative: a punctured layer keeps the energy that pressed it in, and drag takes some.
// With each puncture the force of the spring drops within one step, by pop_force_n or little more, to zero.
// Source: the phases of Okamura, Simone and O'Leary, Force modeling for needle insertion into soft tissue (2004): stiffness before the
// puncture, friction behind it. We leave out the cutting force.
class TissueLayers {
 public:
  static constexpr Passivity kPassivity = Passivity::dissipative;
  // A free choice: twice the number of skin, fat, muscle and bone.
  static constexpr std::size_t kMax = 8;

  struct State {
    std::size_t punctured_count = 0;  // number of layers
    double rest_depth_m = 0.0;        // depth from which the next one resists
    bool has_begun = false;
  };

  // Adds a layer. Pre: fewer than kMax; deeper than the one before; the layers before it can be punctured.
  void add(const TissueLayer& layer) noexcept { layers_[count_++] = layer; }

  bool is_on() const noexcept { return count_ > 0; }
  std::size_t count() const noexcept { return count_; }
  const TissueLayer& operator[](std::size_t i) const noexcept { return layers_[i]; }
  static constexpr double bound_n() noexcept { return kMaxEffectForceN; }

  // Punctures the layers that this depth punctures, and returns the force outwards; negative: drag holds a needle that is drawn back.
  // inward_m_per_s: speed of the needle into the body. Pre: depth_m >= 0, finite.
  double force(double depth_m, double inward_m_per_s, State& state) const noexcept;

 private:
  double spring_force(double depth_m, const State& state) const noexcept;

  std::array<TissueLayer, kMax> layers_ = {};
  std::size_t count_ = 0;
};

}  // namespace hapton
