#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "bench/measure/effect_cases.h"
#include "core/base/result.h"

namespace hapton {

// Difference between the force of the haptic step and the force by the formulas of docs/effects.md. Errors of sampling, of smoothed
// velocities and of image resolution are included. Without effects, rms is a share of the RMS of the whole force.
struct EffectError {
  double rms = 0.0;      // RMS of the difference, as a share of the RMS of what the effects add to the force (N if that is zero)
  double worst_n = 0.0;  // largest difference, N
};

struct EffectErrorSettings {
  std::size_t steps = 8000;
  double rate_hz = 1000.0;
  std::uint64_t seed = 1;
};

// Measures the error of the force of method proxy with these effects, made for effect_plane(), along a smooth motion in and out of contact
// whose phases the seed draws. The formulas, implemented independently in EffectFormula, are evaluated 64 times per step and with the exact
// velocity. None: `effects` has no formula (a recorded texture is noise of a given spectrum), or the run ends within its first 0.2 s, which
// do not count. Error: that of make_method. RT: set-up only.
Result<std::optional<EffectError>> measure_effect_error(const EffectCase& effects, const EffectErrorSettings& settings);

// The sheet on which measure_effect_error measures; make_effect_cases(effect_plane()) makes the effects for it.
const TriangleMesh& effect_plane();

}  // namespace hapton
