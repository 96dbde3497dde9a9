#pragma once

#include <cstdint>
#include <memory>

#include "core/effects/effect_sample.h"

namespace hapton {

class TextureModels;

// The vibration of a recorded surface: the acceleration a of its models at the present speed along the surface and normal force, as force
//   F = mass a (n x t),   t the direction of motion along the surface,
// so that it never drives or brakes the hand where it moves straight on. TextureVoice computes it. Frame: S. Units: SI. RT: yes.
//
// Bound: max_force_n, and the normal force, so that it begins and ends with the contact. Zero below kRestMPerS. Passivity: active; at most
// the bound times the path of the hand across its direction of motion. Source: Culbertson, Lopez Delgado and Kuchenbecker (2014), One
// hundred data-driven haptic texture models and open-source methods for rendering on 3D objects, IEEE Haptics Symposium.
struct RecordedTexture {
  static constexpr Passivity kPassivity = Passivity::active;
  // A hand below this speed rests. Up to twice the speed the force grows linearly.
  static constexpr double kRestMPerS = 5e-4;

  std::shared_ptr<const TextureModels> models = {};  // null: off
  double mass_kg = 0.05;                             // effective mass of the device at its tip, and of what holds it
  double max_force_n = 2.0;
  std::uint64_t seed = 1;  // of the noise

  bool is_on() const noexcept { return models != nullptr; }
  double bound_n() const noexcept { return max_force_n; }
};

}  // namespace hapton
