#pragma once

#include <cstdint>
#include <optional>

#include "link/messages.h"
#include "scene/scene_file.h"

namespace hapton {

// In what a scene file that was read again differs from before, from the least to the most.
enum class SceneChange : std::uint8_t {
  none,
  materials,  // stiffness, damping and friction of some objects
  effects,    // of surfaces or of space, or names: the meshes are the same
  shape       // meshes, their poses, motions and number, or which of their sides are felt
};

// Of everything that is felt, and of names. RT: no.
SceneChange compare_scenes(const Scene& before, const Scene& after);

// In what the materials of `after` differ from those of `before`, object by object, without serial and request. None: in more objects than
// a state holds. Pre: as many objects. RT: no.
std::optional<MaterialState> describe_materials(const Scene& before, const Scene& after);

}  // namespace hapton
