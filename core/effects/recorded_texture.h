#pragma once

#include <cstdint>
#include <memory>

#include "core/effects/effect_sample.h"

namespace hapton {

class TextureModels;

// The vibration of a recorded surface. Its models give an acceleration a for the present speed along the surface and normal force; the
// force is
//   F = mass a (n x t),   n the normal, t the direction of motion along the surface.
// It acts across the direction of motion, so it neither drives nor brakes a hand that moves straight on. TextureVoice computes it. Frame:
// S. Units: SI. RT: yes.
//
// Bound: the smaller of max_force_n and the normal force, so that it begins and ends with the contact. Zero at or below kRestMPerS.
// Passivity: active; the energy it gives is at most the bound times the path of the hand across its direction of motion. Source:
// Culbertson, Lopez Delgado and Kuchenbecker (2014), One hundred data-driven haptic texture models and open-source methods for rendering on
// 3D objects, IEEE Haptics Symposium.
struct RecordedTexture {
  static constexpr Passivity kPassivity = Passivity::active;
  // A hand slower than this counts as at rest; a free choice. Up to twice this speed the force grows linearly, so that it begins without a
  // jump.
  static constexpr double kRestMPerS = 5e-4;

  std::shared_ptr<const TextureModels> models = {};  // null: off
  double mass_kg = 0.05;                             // effective mass at the device point: of the device and of the hand that holds it
  double max_force_n = 2.0;
  std::uint64_t seed = 1;  // seed of the noise

  bool is_on() const noexcept { return models != nullptr; }
  double bound_n() const noexcept { return max_force_n; }
};

}  // namespace hapton
