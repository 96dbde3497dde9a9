#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/effects/smooth_velocity.h"
#include "core/effects/space_effect.h"
#include "core/effects/spring_friction.h"
#include "core/effects/surface_effects.h"
#include "core/effects/surface_frame.h"
#include "core/effects/surface_place.h"
#include "core/effects/texture_voice.h"

namespace hapton {

// The contact that a force method found at one sample. Frame: S. Units: SI.
struct SurfaceContact {
  Vec3 force_n = Vec3::Zero();  // the method's, with its damping and friction; its direction counts as the contact normal
  Vec3 p_SP = Vec3::Zero();     // proxy
  int object = -1;              // number of the touched object; -1: none, or unknown
  bool contact = false;
  const MapSample* map = nullptr;       // what the object's images say at the proxy; null: it has no images
  const SurfacePlace* place = nullptr;  // where an object that deforms is touched; null: it keeps its shape
};

// The result of all effects at one sample.
struct EffectResult {
  Vec3 force_n = Vec3::Zero();
  Vec3 p_SP = Vec3::Zero();  // where the probe is drawn: in punctured layers, at the tip of the needle
  bool is_felt = false;      // there is contact, or force_n is not zero
};

// Adds all effects of a scene to the force of a method, sample by sample, and holds their state: time, velocity, punctured layers, the
// surface that holds the device (snap), the last tap. The result is finite if the method's force is. A sample that is not finite gives zero
// force and changes nothing.
//
// The effects of a surface that moves are computed in its frame F, in which the surface stays where it is in S at rest: positions,
// velocities and states are relative to F. Friction and a recorded texture go on from surface to surface, also from one frame to another.
//
// Frame: S. Units: SI. RT: all but construction and any. Threads: one.
class EffectStep {
 public:
  // surfaces: one for each object of the scene. frame_of: for each object the number of its frame, from 0, or kStill if it stands still;
  // empty: all objects stand still.
  static constexpr int kStill = -1;
  EffectStep(std::vector<SurfaceEffects> surfaces, std::vector<SwitchedEffect> space, std::vector<int> frame_of = {});

  // Sets where the frames are at the next sample, by number; to be called before each step. The span must last until the step ends.
  void place(std::span<const Pose> X_SF) noexcept { X_SF_ = X_SF; }

  // dt_s: time since the sample before; not above zero: the same moment; above kLongestS: time advances by kLongestS. buttons: those of the
  // stylus that are down, a bit each.
  EffectResult step(const Vec3& p_SD, double dt_s, const SurfaceContact& contact, std::uint32_t buttons = 0) noexcept;
  // Called in place of step, while the stylus holds a rigid tool: the force of the effects in free space. The surface touched last, which
  // may be that of the tool, no longer snaps.
  Vec3 step_in_space(const Vec3& p_SD, double dt_s, std::uint32_t buttons = 0) noexcept;
  void reset() noexcept;
  // Sets the drag of one object of the scene, without its damping if the object has layers. RT: yes.
  void set_drag(std::size_t object, const SurfaceDrag& drag) noexcept;
  // Whether a surface or the free space has an effect.
  bool any() const noexcept;
  // Takes over the velocities of the device as `other` knows them at its last sample: that of the hand, and those relative to moving
  // surfaces if both have the same frame_of. Pre: this has made a step at that sample.
  void continue_hand_motion(const EffectStep& other) noexcept;
  // Tells that the scene was moved, so that the last device point has other coordinates in frame S: not a motion of the hand.
  void note_scene_moved(const Vec3& last_p_SD) noexcept;

 private:
  // A free choice: a longer gap between two samples counts as this.
  static constexpr double kLongestS = 1.0;

  // State of one object since it was first touched in this contact. A probe that touches two objects may alternate between them.
  struct ObjectState {
    SurfaceEffectState effects;
    std::uint64_t contact = 0;
  };
  struct EffectWithState {
    SwitchedEffect effect;
    BurstEffect::State burst;
    MassEffect::State mass;
    EffectSwitch::State switch_state;
  };

  // One sample in the frame of the surface.
  struct SurfaceSample {
    EffectSample sample;
    Vec3 newest_v = Vec3::Zero();  // velocity over the last interval alone
    Vec3 motion = Vec3::Zero();    // of the device since the sample before
    double dt_s = 0.0;
  };

  // How a surface is pressed at one sample.
  struct Press {
    Vec3 normal;
    double method_n;  // magnitude of the method's force
    double depth_m;   // of the hand below the surface, without bumps
    double normal_n;  // force along the normal, with bumps, layers and damping
    bool begins;      // the first sample of a contact
  };

  SurfaceEffectState& state_of(int object) noexcept;
  int frame_of(int object) const noexcept { return frame_of_.empty() ? kStill : frame_of_[static_cast<std::size_t>(object)]; }
  void advance_frames(const Vec3& p_SD, double dt_s) noexcept;
  void carry_state_into(int frame) noexcept;
  Vec3 moving_force(SurfaceFrame& frame, const EffectSample& sample, double dt_s, const SurfaceContact& contact, Vec3& p_SP) noexcept;
  Vec3 surface_force(const SurfaceSample& surface_sample, const SurfaceContact& contact, Vec3& p_SP) noexcept;
  void add_friction(const SurfaceSample& surface_sample, const SurfaceEffects& surface, const MapSample& map, const Press& press,
                    Vec3& force_n) noexcept;
  Vec3 leave_surface(const EffectSample& sample) noexcept;
  Vec3 space_force(const EffectSample& sample, std::uint32_t buttons) noexcept;

  std::vector<SurfaceEffects> surfaces_;  // by object
  std::vector<EffectWithState> space_;
  SmoothVelocity velocity_;
  double time_s_ = 0.0;
  int touched_object_ = -1;  // the object touched in the last step that touched any
  bool is_in_contact_ = false;
  Vec3 last_p_SD_ = Vec3::Zero();
  std::vector<int> frame_of_;  // by object; empty: nothing moves
  std::vector<SurfaceFrame> frames_;
  std::span<const Pose> X_SF_;           // poses of frames_ at the next sample
  int state_frame_ = kStill;             // the frame of friction_ and texture_
  SpringFriction::State friction_;       // carried over from object to object, so that the force stays
  std::optional<TextureVoice> texture_;  // carried over likewise; none: no surface has one
  std::uint64_t contacts_ = 0;           // number of contacts begun from free space
  std::vector<ObjectState> states_;      // by object
};

}  // namespace hapton
