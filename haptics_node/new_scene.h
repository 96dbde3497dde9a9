#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/force/touch_scene.h"
#include "link/messages.h"
#include "scene/scene_file.h"

namespace hapton {

// A scene that replaces the one in use while that is felt.
struct NewScene {
  TouchScene touch;
  std::vector<Material> materials;  // in series with the virtual coupling, for ForceMethod::set_materials
  std::uint64_t hash = 0;           // hash_scene of touch; 0, and facts empty, if an object was put down: PlacedScene has both
  SceneFacts facts;
  std::uint32_t revision = 0;         // counts the scenes that replaced another one, from 1
  bool keeps_shape = false;           // the meshes are those of the scene before: the method in use is kept
  std::uint32_t put_down_serial = 0;  // GraspRequest::serial of the request that put an object down; 0: none
};

// Makes a scene in which an object was put down by that request (NewScene::put_down_serial), without hash and facts. RT: no.
std::shared_ptr<NewScene> make_placed_scene(const Scene& scene, double coupling_n_per_m, std::uint32_t revision,
                                            std::uint32_t put_down_serial);

// Makes `scene` as it is felt with a virtual coupling of that stiffness. revision and keeps_shape: as in NewScene. RT: no.
std::shared_ptr<NewScene> make_new_scene(const Scene& scene, double coupling_n_per_m, std::uint32_t revision, bool keeps_shape);

}  // namespace hapton
