#include "haptics_node/haptic_scene.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "scene/scene_hash.h"

namespace hapton {

HapticScene::HapticScene(TouchScene scene, FindGains find_gains, StiffnessAdviser& adviser, InsideBodyWarning& inside, PatchSender& patches)
    : find_gains_(std::move(find_gains)), adviser_(adviser), inside_warning_(inside), patch_sender_(patches), scene_(std::move(scene)) {}

void HapticScene::tune(const std::vector<Material>& materials) {
  const std::scoped_lock lock(mutex_);
  tuned_ = materials;
  for (std::size_t o = 0; o < std::min(tuned_.size(), scene_.objects.size()); ++o) scene_.objects[o].material = tuned_[o];
  adviser_.set_gains(find_gains_(scene_));
  patch_sender_.set_materials(tuned_);
}

void HapticScene::follow(const TouchScene& scene) {
  const std::scoped_lock lock(mutex_);
  tuned_.clear();
  note(scene);
  patch_sender_.set_scene(scene_, hash_scene(scene_));
}

void HapticScene::place(const TouchScene& scene, std::uint32_t revision) {
  const std::scoped_lock lock(mutex_);
  note(scene);
  // PatchSender needs meshes and materials only. Their hash is left out (0), because computing it here takes too long.
  TouchScene meshes = scene_;
  meshes.built.reset();
  meshes.mapped.clear();
  patch_sender_.set_scene(std::move(meshes), 0, revision);
}

void HapticScene::note(const TouchScene& scene) {
  scene_ = scene;
  for (std::size_t o = 0; o < std::min(tuned_.size(), scene_.objects.size()); ++o) scene_.objects[o].material = tuned_[o];
  adviser_.set_gains(find_gains_(scene_));
  inside_warning_.set_scene(scene_);
}

}  // namespace hapton
