#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "bench/measure/effect_cases.h"
#include "core/base/result.h"

namespace hapton {

// How far the felt force is from the formula of its effects in docs/effects.md: sampling, the smoothing of velocities and the resolution of
// images are in it.
struct EffectError {
  double rms = 0.0;      // share of the root mean square of what the effects add to the force
  double worst_n = 0.0;  // largest difference, N
};

struct EffectErrorSettings {
  std::size_t steps = 8000;
  double rate_hz = 1000.0;
  std::uint64_t seed = 1;
};

// The felt force of method proxy with effects on the plane z = 0, along a smooth motion in and out of contact whose phases the seed draws.
// Compared with the formulas, which are written anew here, in 64 parts of each step and with the exact velocity. none: `effects` has no
// formula (a recorded texture, whose noise has a spectrum). The first 0.2 s do not count; none if there is nothing else. Error: see
// make_method. RT: set-up only.
Result<std::optional<EffectError>> measure_effect_error(const EffectCase& effects, const EffectErrorSettings& settings);

// The sheet on which it is measured: make_effect_cases(this) has images for it.
const TriangleMesh& effect_plane();

}  // namespace hapton
