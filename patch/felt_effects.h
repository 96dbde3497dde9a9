#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/effects/effect_step.h"
#include "core/force/mapped_surface.h"
#include "core/force/touch_step.h"
#include "patch/effect_codec.h"
#include "patch/patch_touch.h"

namespace hapton {

// Where the bodies of a scene in parts are, at one sample.
class BodyPlaces {
 public:
  virtual ~BodyPlaces() = default;
  // The pose X_SO of a body.
  virtual Pose pose(std::size_t body) const noexcept = 0;
  // Where an object that deforms was touched in the last step (ForceMethod::find_place). None: the object keeps its shape.
  virtual std::optional<SurfacePlace> place(std::size_t body, int object) const noexcept = 0;
  // The stiffness of an object, N/m: friction's spring is not stiffer (SurfaceDrag).
  virtual double stiffness(std::size_t body, int object) const noexcept = 0;
};

// Adds the effects of a scene to the force of its patches, as TouchStep adds them to that of the whole scene. Past the edge of a patch the
// plane of the last contact has the effects of the object touched last.
//
// Frames: W and S as named. Units: SI. RT: yes, except construction. Threads: one.
class FeltEffects {
 public:
  explicit FeltEffects(const SceneEffectSet& effects);

  // output: the result of the patches in this step; none: it is not known what they would give, and nothing is felt.
  void add(const TouchInput& input, const BodyPlaces& bodies, std::optional<PatchOutput>& output) noexcept;
  // Forgets contact and time.
  void forget() noexcept { effects_.reset(); }
  // Takes over the motion of the hand from `other`, as EffectStep does.
  void continue_hand_motion(const FeltEffects& other) noexcept;

 private:
  void compensate_scene_motion(const TouchInput& input) noexcept;
  int frame_of(int object) const noexcept;
  MapFinder* find_maps(int object) const noexcept;

  std::vector<std::size_t> bodies_;  // those that move and have effects, by number of their frame
  std::vector<int> frame_of_;        // by object, the number of its frame; EffectStep::kStill: it stands still, or has no effects
  EffectStep effects_;
  std::vector<Pose> X_SF_;                        // poses of these bodies at the newest sample
  std::vector<std::unique_ptr<MapFinder>> maps_;  // by object; null: it has no images
  TouchInput last_input_;                         // input of the last step
  bool has_last_input_ = false;
  int touched_object_ = -1;  // object of the last contact within a patch
};

}  // namespace hapton
