#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/math/keyframe_motion.h"
#include "core/math/types.h"
#include "patch/felt_effects.h"

namespace hapton {

// How one body of a scene in parts moves. A body is all that stands still, or objects that move together. Its parts and its patches are in
// a frame that moves with the body and is S while the body is at rest.
struct PatchBodyMotion {
  std::shared_ptr<const KeyframeMotion> keyframes = nullptr;  // null: the body moves by commands, or not at all
  bool is_commanded = false;
  bool deforms = false;           // its surface deforms, before it is moved: a patch contains the whole body
  std::int32_t object = -1;       // of a commanded body: its object, as in ObjectMove
  Vec3 pivot_S = Vec3::Zero();    // ... a point of it at rest
  double radius_m = 0.0;          // ... no point of it is farther from pivot_S
  std::uint32_t move_serial = 0;  // ... the move that has to be known before the body can be felt; 0: none

  bool moves() const noexcept { return keyframes != nullptr || is_commanded || deforms; }
};

// All bodies of a scene, in the order of PatchChain: body 0 is what stands still. If nothing moves, there is only body 0.
struct PatchBodies {
  std::uint32_t generation = 0;
  double extent_m = 0.0;  // of the scene
  std::vector<PatchBodyMotion> bodies;
  std::unique_ptr<FeltEffects> effects = nullptr;  // null: the scene has none

  bool any_moves() const noexcept { return bodies.size() > 1; }
};

}  // namespace hapton
