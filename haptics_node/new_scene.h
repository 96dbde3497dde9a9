#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/force/touch_scene.h"
#include "link/messages.h"
#include "scene/scene_file.h"

namespace hapton {

// A scene that takes the place of another one while it is felt.
struct NewScene {
  TouchScene touch;
  std::vector<Material> materials;  // in series with the virtual coupling, for ForceMethod::set_materials
  std::uint64_t hash = 0;           // hash_scene of touch; not used where an object was put down, like the facts: PlacedScene has them
  SceneFacts facts;
  std::uint32_t revision = 0;  // counts the scenes that replaced another, from 1
  bool keeps_shape = false;    // same meshes as the scene before: the method in use is kept
  std::uint32_t put_down = 0;  // request by which an object was put down (GraspRequest::serial); 0: none
};

// Without hash and facts, for a scene in which an object is put down by that request (NewScene::put_down).
std::shared_ptr<NewScene> make_placed_scene(const Scene& scene, double coupling_n_per_m, std::uint32_t revision, std::uint32_t put_down);

// As `scene` is felt with a virtual coupling of that stiffness. revision and keeps_shape as above. RT: no.
std::shared_ptr<NewScene> make_new_scene(const Scene& scene, double coupling_n_per_m, std::uint32_t revision, bool keeps_shape);

}  // namespace hapton
