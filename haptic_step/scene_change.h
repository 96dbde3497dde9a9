#pragma once

#include <cstdint>
#include <optional>

#include "link/messages.h"
#include "scene/scene_file.h"

namespace hapton {

// What has changed in a scene file that was read again, ordered by how much must be made anew.
enum class SceneChange : std::uint8_t {
  none,
  names,      // only names of objects and materials: all forces are the same
  materials,  // stiffness, damping and friction of some objects
  effects,    // effects of surfaces or in free space, or both names and materials: the meshes are the same
  shape       // meshes, their poses, motions and number, or which of their sides are felt
};

// Compares what affects the forces, and the names of objects and materials; not the tool and effects from shared libraries. RT: no.
SceneChange compare_scenes(const Scene& before, const Scene& after);

// The differences between the materials of `after` and those of `before`, object by object; serial and request are 0. None: more objects
// differ than a MaterialState holds. Pre: both scenes have the same number of objects. RT: no.
std::optional<MaterialState> describe_materials(const Scene& before, const Scene& after);

}  // namespace hapton
