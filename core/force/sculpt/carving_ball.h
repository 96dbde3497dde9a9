#pragma once

#include <optional>

#include "core/force/sculpt/field_ball.h"
#include "core/force/touch_scene.h"
#include "core/sculpt/sculpture.h"

namespace hapton {

// The spherical tool on one body of material: its proxy on the surface, and the carves that it makes. Units: SI. Frame: S.
//
// The ball touches with a slightly smaller radius than it carves with, so that it is free after a carve. While the button is down, its
// centre follows the device through material with a first-order lag (kCutS) and removes the material within the radius: by one carve when
// the button is pressed, and another each time the centre has moved half a voxel. So pressing harder cuts faster, and the force is
// continuous: on a straight path it is stiffness times speed times kCutS. Through free space, and back through what was cut, the centre is
// not held, and what is left of its lag behind the device decays (kCatchUpS). A ball that begins inside the material has no force and
// carves nothing until it has left the material. Source: decision 160. RT: yes, except construction. Threads: one.
class CarvingBall {
 public:
  // Time constant of the lag while it cuts. Longer: slower cutting and more force at the same speed.
  static constexpr double kCutS = 0.02;
  // Time constant with which the lag, and so the force, decays once the ball comes out into free space.
  static constexpr double kCatchUpS = 0.01;
  // Largest speed through material, m/s: bounds the change of force in a step, and the size of a carve.
  static constexpr double kMaxCutSpeed = 0.5;

  explicit CarvingBall(const SculptSettings& settings);

  struct Input {
    Vec3 goal = Vec3::Zero();  // the device point, less what other parts of the scene hold (CommonProxy): the ball moves to it
    double dt_s = 1e-3;        // since the last step
    bool is_down = false;      // the button that carves
    // The same sample as in the last step, with another goal: no time passes, and the ball continues from where that step left it.
    // Pre: the ball does not cut.
    bool is_correction = false;
  };
  // The proxy; in free space it is the goal itself.
  struct Felt {
    Vec3 p_SP = Vec3::Zero();
    bool contact = false;
  };
  // One step: moves the ball on the body with this number, and carves that body if the ball cuts. Pre: body < sculpture.bodies().size().
  Felt step(const Input& input, const Material& material, Sculpture& sculpture, std::size_t body) noexcept;

  // Whether the ball will cut in the next step, with its button down or not: it then gives way to the device.
  bool cuts(bool is_down, const Sculpture& sculpture) const noexcept { return is_down && !state_.is_inside && !sculpture.is_full(); }
  // After a step in which the ball cut: p_S is where the other parts of the scene let the proxy be. The ball is moved to p_S, unless it
  // would overlap the material there by more than a fifth of a voxel. goal: the device point.
  void settle(const CarvedField& field, const Vec3& p_S, const Vec3& goal) noexcept;
  // The next correction starts from the state of the ball before the sample.
  void restart_sample() noexcept { state_ = state_before_; }

  // Material came back (SculptMethod::restore_sculpture). A ball that is now inside it has no force and no carve until it has left it.
  void note_restored_material(const CarvedField& field) noexcept;

  // Puts the ball at this position, without contact and without earlier samples.
  void reset(const Vec3& p_S) noexcept;

 private:
  void begin_sample(bool is_correction) noexcept;
  Vec3 touch(const CarvedField& field, const Input& input, const Material& material) noexcept;
  Vec3 catch_up(const Input& input, const Vec3& free_centre) const noexcept;
  Vec3 cut(const Input& input, Sculpture& sculpture, std::size_t body) noexcept;
  Vec3 find_friction_goal(const Vec3& goal, const Vec3& normal, const Material& material) noexcept;

  struct State {
    Vec3 centre = Vec3::Zero();
    Vec3 normal = Vec3::Zero();        // of the contact of the last step, unit; zero: none
    Vec3 shown_offset = Vec3::Zero();  // shown proxy minus centre; decays after the button was released
    std::optional<Vec3> carved_to;     // end of the last carve; none: the next carve begins at the centre
    double lag_m = 0.0;                // distance to the goal after the last step
    bool has_begun = false;            // it has had a step since reset()
    bool is_inside = false;   // the ball began inside the material, or material came back around it, and it has not left the material
    bool is_cutting = false;  // the button was down in the last step
    bool is_sliding = false;  // friction: the ball slides, it does not stick
  };

  SculptSettings settings_;
  FieldBall ball_;
  State state_;
  State state_before_;  // before the sample of the last step
};

}  // namespace hapton
