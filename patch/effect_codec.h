#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/effects/space_effect.h"
#include "core/effects/surface_effects.h"
#include "core/force/touch_scene.h"

namespace hapton {

// The effects of a scene in the form in which io_node computes them. Frame: S, at rest. Units: SI.
struct SceneEffectSet {
  std::vector<SwitchedEffect> space;
  std::vector<SurfaceEffects> surfaces;  // one for each object of the scene
  std::vector<int> body_of;              // for each object the body (PatchBody) that it belongs to, if it has effects

  bool any() const noexcept {
    return !space.empty() || std::any_of(surfaces.begin(), surfaces.end(), [](const SurfaceEffects& surface) { return surface.any(); });
  }
};

// The most that decode_effects takes. These bound the time of a step and the memory.
constexpr std::size_t kMaxSpaceEffects = 256;
constexpr std::size_t kMaxEffectObjects = 8192;  // as many as a scene in parts has tiles

// Encodes effects as SceneEffects of proto/hapton.proto; empty: there are none. Numbers are exact, except those of images, whose texels are
// rounded to a 65,535th of their range, and those of their triangles, which are rounded to floats.
std::string encode_effects(const SceneEffectSet& effects);

// Error: the bytes are not SceneEffects, or name something that no scene may have: a number that is not finite or not in its range, a force
// above kMaxEffectForceN, an image or model that is not there. The result is safe to compute forces with.
Result<SceneEffectSet> decode_effects(std::string_view bytes);

}  // namespace hapton
