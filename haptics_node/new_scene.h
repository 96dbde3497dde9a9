#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/force/touch_scene.h"
#include "link/messages.h"

namespace hapton {

// A scene that takes the place of another one while it is felt.
struct NewScene {
  TouchScene touch;
  std::vector<Material> materials;  // coupled, for ForceMethod::set_materials
  std::uint64_t hash = 0;           // hash_scene of touch
  SceneFacts facts;
  std::uint32_t revision = 0;  // counts the scenes that replaced another, from 1
  bool keeps_shape = false;    // its meshes are those of the scene before: the method in use feels it
};

}  // namespace hapton
