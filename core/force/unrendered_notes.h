#pragma once

#include <string>

#include "core/force/touch_scene.h"

namespace hapton {

// What a method does not render as the scene has it: a line "note: ...\n" with the number of objects and what to do, for describe(), or
// nothing. RT: no.

// Of a method whose force builds up in a layer outside the surface, where no object is touched yet.
std::string note_bare_layer(const TouchScene& scene);

}  // namespace hapton
