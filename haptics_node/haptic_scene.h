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

// The scene as it is felt now, coupled, for whoever needs to know beside the step: the advice on stiffness, the watch over a hand inside a
// body, and the parts for the hub. RT: no. Threads: any.
class HapticScene {
 public:
  using FindGains = std::function<LargestGains(const TouchScene&)>;

  // Pre: the others outlive this, and have this scene.
  HapticScene(TouchScene scene, FindGains find_gains, StiffnessAdviser& adviser, InsideBodyWarning& inside, PatchSender& patches);

  // Its materials have changed. Pre: one for each object.
  void tune(const std::vector<Material>& materials);
  // Another scene is in use.
  void follow(const TouchScene& scene);
  // An object was put down; the others are as before. Of the materials only the last ones of tune() count, if there are any: some may have
  // come while the scene was built. revision: of NewScene.
  void place(const TouchScene& scene, std::uint32_t revision);

 private:
  void note(const TouchScene& scene);

  FindGains find_gains_;
  StiffnessAdviser& adviser_;
  InsideBodyWarning& inside_;
  PatchSender& patches_;
  std::mutex mutex_;
  TouchScene scene_;
  std::vector<Material> tuned_;  // of tune(); empty: those of the scene
};

}  // namespace hapton
