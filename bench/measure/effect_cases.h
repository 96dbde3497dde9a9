#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/effects/space_effect.h"
#include "core/effects/surface_effects.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// An effect, or several together, as `hapton bench effects` measures it: on the surface of a mesh or in free space.
struct EffectCase {
  std::string name;
  SurfaceEffects surface;
  std::vector<SwitchedEffect> space;
};

// The images of the effects: kTexels x kTexels texels each, repeated kImagesPerM times per metre along x and y.
constexpr int kTexels = 512;
constexpr double kImagesPerM = 10.0;
// The images show waves of brightness, 32 texels long. u, v: texture coordinates, 0 to 1 across one image.
constexpr double kWavesPerImage = kTexels / 32.0;
inline double brightness_at(double u, double v) {
  constexpr double kPhasePerImage = 2.0 * std::numbers::pi * kWavesPerImage;
  return 0.5 + 0.25 * (std::sin(kPhasePerImage * u) + std::sin(kPhasePerImage * v));
}

// The first case has no effect. mesh: the effects' images are mapped onto it along z. RT: set-up only.
std::vector<EffectCase> make_effect_cases(const TriangleMesh& mesh);

}  // namespace hapton
