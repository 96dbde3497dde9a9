#pragma once

#include <cstdint>

#include "core/force/touch_scene.h"

namespace hapton {

// Of all that can be felt: vertices, triangles and materials, in their order. Equal scenes have equal hashes, on every machine of one byte
// order. Not against forgery. RT: set-up only.
std::uint64_t hash_scene(const TouchScene& scene);

}  // namespace hapton
