#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/effects/effect_step.h"
#include "core/force/effect_frames.h"
#include "core/force/force_method.h"
#include "core/force/mapped_surface.h"
#include "core/math/commanded_motion.h"

namespace hapton {

// One device sample in the world frame, and the pose of the static scene.
struct TouchInput {
  Vec3 p_WD = Vec3::Zero();      // device point, m
  Pose X_WS = Pose::Identity();  // static scene in world (the view transform)
  double dt_s = 1e-3;
  std::uint32_t buttons = 0;  // pressed buttons of the stylus: one bit each, the first button the lowest; used by effects and carving only
  double time_s = 0.0;        // as in MethodInput
  Quat q_WT = Quat::Identity();  // orientation of the stylus; used by methods of plug-ins only
  bool is_correction = false;    // as in MethodInput; only in a scene without effects
};

struct TouchOutput {
  Vec3 force_n = Vec3::Zero();          // acts on the device, frame W
  Vec3 visual_offset_m = Vec3::Zero();  // frame W: drawn probe minus device point; see also held_offset()
  bool contact = false;                 // a surface is touched, or an effect acts
  int object = -1;                      // as in MethodOutput
};

// One haptic step: transforms the device point into the static scene's frame, runs the method, adds the scene's effects, and transforms
// force and visual offset back to the world. The live node, replay, tests and benches all call it. RT: step, step_in_space, reset,
// reset_effects, resume, set_materials, command, copy_commands, continue_hand_motion and the functions for carves yes. Threads: one.
class TouchStep {
 public:
  // Without effects.
  explicit TouchStep(std::shared_ptr<ForceMethod> method) : method_(std::move(method)) {}
  // With the effects of the scene that the method was made for. In a scene without effects a step costs one comparison more.
  TouchStep(std::shared_ptr<ForceMethod> method, const TouchScene& scene);

  TouchOutput step(const TouchInput& input) noexcept;
  // In place of step() while the stylus holds a rigid tool: the force of the scene's effects in free space at the device point, frame W.
  Vec3 step_in_space(const TouchInput& input) noexcept;
  void reset(const TouchInput& input) noexcept;
  // Resets only the effects, for a rigid tool that is held from the first sample on.
  void reset_effects(const TouchInput& input) noexcept;
  // See ForceMethod::resume. input.p_WD: where a surface held the proxy.
  void resume(const TouchInput& input) noexcept;
  // See ForceMethod::set_materials. Surface effects other than damping and friction of the materials stay as they were made.
  void set_materials(std::span<const Material> materials) noexcept;
  const ForceMethod& method() const { return *method_; }
  // Proxy minus device point of the last step, frame W, m, if the probe is drawn elsewhere than at the proxy, as a needle in layers is.
  // None: the probe is drawn at the proxy, and visual_offset_m is proxy minus device point.
  const std::optional<Vec3>& held_offset() const noexcept { return held_offset_m_; }
  // Whether a surface of the scene has layers.
  bool has_layers() const noexcept { return has_layers_; }
  // Whether the scene has effects, or TouchStep adds damping or friction (ForceMethod::unrendered_drag).
  bool has_effects() const { return uses_effects_; }
  // Whether objects of the scene move or deform (TouchScene::has_motion): the force depends on TouchInput::time_s.
  bool has_motion() const { return has_motion_; }
  // Moves an object that programs may move (TouchObject::command_pivot), from the next step on. object: its index in the scene. False:
  // programs may not move it, or the move is not newer than the last one.
  bool command(int object, const CommandedMove& move) noexcept;
  // The motion of such an object; null: programs may not move it.
  const CommandedMotion* find_commanded(int object) const noexcept;
  // All objects that programs may move. RT: no.
  std::vector<int> commanded_objects() const;
  // Takes over the filtered velocity of the hand of `other`. Pre: this was reset, and then made a step at the last sample of `other`.
  void continue_hand_motion(const TouchStep& other) noexcept;
  // Copies the commanded motions of `other`, a step for the same scene. Does nothing if the numbers of such objects differ.
  void copy_commands(const TouchStep& other) noexcept;
  // Whether the scene has bodies of material, which the buttons of TouchInput carve.
  bool has_sculpture() const { return method_->sculpture() != nullptr; }
  // The carve that the last step made; null: it made none.
  const MadeCarve* made_carve() const noexcept {
    const Sculpture* sculpture = method_->sculpture();
    return sculpture != nullptr && sculpture->made() ? &*sculpture->made() : nullptr;
  }
  // Exchanges the carved shapes with `other`, a step for the same scene.
  void exchange_carves(TouchStep& other) noexcept {
    if (method_ != other.method_) method_->exchange_sculpture(*other.method_);
  }
  // See ForceMethod::restore_sculpture.
  bool restore_carves(Sculpture& other, std::uint32_t undo_serial) noexcept { return method_->restore_sculpture(other, undo_serial); }
  // Serial number of the newest carve or undo; 0: none.
  std::uint32_t newest_carve_serial() const noexcept { return has_sculpture() ? method_->sculpture()->newest() : 0; }
  // See ForceMethod::repeat_carve.
  bool repeat_carve(int object, const Carve& carve) noexcept { return method_->repeat_carve(object, carve); }
  // See ForceMethod::find_streamed.
  StreamedMethod* find_streamed(int object) const noexcept { return method_->find_streamed(object); }
  // The method, for the slow task: it calls prepare() in another thread while step() runs.
  std::shared_ptr<ForceMethod> share_method() const { return method_; }

 private:
  struct Commanded {
    int object = -1;  // index in the scene
    CommandedMotion motion;
  };

  void place_commanded(double time_s) noexcept;
  void compensate_scene_motion(const TouchInput& input) noexcept;
  void update_drag() noexcept;
  std::optional<SurfacePlace> place_frames(const MethodInput& sample, const MethodOutput& result) noexcept;
  Vec3 find_at_rest(const MethodOutput& result, const std::optional<SurfacePlace>& place) const noexcept;
  TouchOutput add_effects(const TouchInput& input, const MethodInput& sample, const MethodOutput& result) noexcept;

  std::shared_ptr<ForceMethod> method_;
  std::unique_ptr<EffectStep> effects_;  // null: no effects, and set_materials cannot add any
  bool uses_effects_ = false;            // at least one effect acts
  bool has_layers_ = false;
  bool has_new_effects_ = false;  // effects were added since the last step
  bool has_set_drag_ = false;     // update_drag() was called, in the first step: before it another thread may use the method
  std::vector<std::unique_ptr<MapFinder>> maps_;  // by object; null: it has no images; used with effects only
  std::unique_ptr<EffectFrames> frames_;          // null: no object with effects moves
  TouchInput last_input_;                         // input of the last step; used with effects only
  std::optional<Vec3> held_offset_m_;             // as held_offset() returns it
  bool has_motion_ = false;
  std::vector<Commanded> commanded_;  // in the order of the scene
  std::vector<Pose> X_SO_;            // their poses at placed_s_
  double placed_s_ = 0.0;             // scene time of X_SO_; a move sets it back, so that they are computed again
  double commanded_until_s_ = 0.0;    // scene time from which no object moves any more
};

}  // namespace hapton
