#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/math/keyframe_motion.h"
#include "core/math/types.h"
#include "patch/felt_effects.h"

namespace hapton {

// One of the bodies of a scene in parts: what stands still, or objects that move together. Its parts, and the patches of it, are in the
// frame that moves along, which at rest is S.
struct PatchBodyMotion {
  std::shared_ptr<const KeyframeMotion> keyframes = nullptr;  // null: by commands, or not at all
  bool is_commanded = false;
  bool deforms = false;           // before its motion: a patch of it is all of it
  std::int32_t object = -1;       // of a commanded one, as in ObjectMove
  Vec3 pivot_S = Vec3::Zero();    // ... on it at rest
  double radius_m = 0.0;          // ... no point is farther from there
  std::uint32_t move_serial = 0;  // ... of a move that has to be known before it can be felt; 0: none

  bool moves() const noexcept { return keyframes != nullptr || is_commanded || deforms; }
};

// All bodies of a scene, in the order of PatchChain: body 0 is what stands still. Of a scene where nothing moves, there is one.
struct PatchBodies {
  std::uint32_t generation = 0;
  double extent_m = 0.0;  // of the scene
  std::vector<PatchBodyMotion> bodies;
  std::unique_ptr<FeltEffects> effects = nullptr;  // null: the scene has none

  bool any_moves() const noexcept { return bodies.size() > 1; }
};

}  // namespace hapton
