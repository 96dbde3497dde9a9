#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <vector>

#include "core/force/stiffest.h"
#include "core/force/touch_scene.h"
#include "haptics_node/inside_body_warning.h"
#include "haptics_node/patch_sender.h"
#include "haptics_node/stiffness_adviser.h"

namespace hapton {

// The scene as it is felt now, with its materials in series with the virtual coupling. Passes each change of it on to those that need it
// besides the step: the stiffness adviser, the warning of a hand inside a body, and the sender of parts for the hub. RT: no. Threads: any.
class HapticScene {
 public:
  using FindGains = std::function<LargestGains(const TouchScene&)>;

  // Pre: adviser, inside and patches outlive this, and have this scene already.
  HapticScene(TouchScene scene, FindGains find_gains, StiffnessAdviser& adviser, InsideBodyWarning& inside, PatchSender& patches);

  // To be called when materials of the scene have changed. Pre: materials has one for each object.
  void tune(const std::vector<Material>& materials);
  // To be called when another scene is in use, with the materials of its file.
  void follow(const TouchScene& scene);
  // To be called when an object was put down; the others are as before. The materials of the last tune() since follow(), if any, replace
  // those of `scene`, because they may have changed while it was built. revision: NewScene::revision.
  void place(const TouchScene& scene, std::uint32_t revision);

 private:
  void note(const TouchScene& scene);

  FindGains find_gains_;
  StiffnessAdviser& adviser_;
  InsideBodyWarning& inside_warning_;
  PatchSender& patch_sender_;
  std::mutex mutex_;
  TouchScene scene_;
  std::vector<Material> tuned_;  // materials of the last tune(); empty: those of the scene count
};

}  // namespace hapton
