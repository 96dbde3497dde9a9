#include "haptics_node/new_scene.h"

#include "core/force/virtual_coupling.h"
#include "haptic_step/scene_facts.h"
#include "scene/scene_hash.h"

namespace hapton {

std::shared_ptr<NewScene> make_placed_scene(const Scene& scene, double coupling_n_per_m, std::uint32_t revision,
                                            std::uint32_t put_down_serial) {
  auto made = std::make_shared<NewScene>();
  made->touch = scene.touch_scene();
  for (const TouchObject& object : made->touch.objects) made->materials.push_back(couple_material(object.material, coupling_n_per_m));
  made->revision = revision;
  made->put_down_serial = put_down_serial;
  return made;
}

std::shared_ptr<NewScene> make_new_scene(const Scene& scene, double coupling_n_per_m, std::uint32_t revision, bool keeps_shape) {
  auto made = make_placed_scene(scene, coupling_n_per_m, revision, 0);
  made->hash = hash_scene(made->touch);
  made->facts = make_scene_facts(scene);
  made->keeps_shape = keeps_shape;
  return made;
}

}  // namespace hapton
