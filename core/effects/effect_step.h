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
  Vec3 force_n = Vec3::Zero();  // of the method, along the contact normal with its damping and friction
  Vec3 p_SP = Vec3::Zero();     // proxy
  int object = -1;              // touched; -1: none, or unknown
  bool contact = false;
  const MapSample* map = nullptr;       // of the object's images at the proxy; null: it has none
  const SurfacePlace* place = nullptr;  // where an object that deforms is touched; null: it keeps its shape
};

// The result of all effects on it.
struct EffectResult {
  Vec3 force_n = Vec3::Zero();
  Vec3 p_SP = Vec3::Zero();  // where the probe is drawn: in punctured layers, at the tip of the needle
  bool is_felt = false;      // there is contact, or force_n is not zero
};

// Adds all effects of a scene to the force of a method, sample by sample, and holds their state: time, velocity, punctured layers, the
// surface that holds the device (snap), the last tap. The result is finite if the method's force is. A sample that is not finite gives zero
// force and changes nothing.
//
// The effects of a surface that moves are computed in its frame F, in which it always is where it is in S at rest: positions, velocities
// and memory are relative to it. Friction and a recorded texture go on from surface to surface, also from one frame to another.
//
// Frame: S. Units: SI. RT: all but construction and any. Threads: one.
class EffectStep {
 public:
  // surfaces: one for each object of the scene. frame_of: by object, the number of its frame, from 0; kStill: it stands still. Empty: all
  // do.
  static constexpr int kStill = -1;
  EffectStep(std::vector<SurfaceEffects> surfaces, std::vector<SwitchedEffect> space, std::vector<int> frame_of = {});

  // Where the frames are at the next sample, by number. Before each step. The span has to last until then.
  void place(std::span<const Pose> X_SF) noexcept { X_SF_ = X_SF; }

  // dt_s: since the sample before; one that is not above zero counts as the same moment, one above kLongestS as kLongestS. buttons: of the
  // stylus that are down, a bit each.
  EffectResult step(const Vec3& p_SD, double dt_s, const SurfaceContact& contact, std::uint32_t buttons = 0) noexcept;
  // In place of step, while the stylus holds a rigid tool: the force of the effects in free space. The surface touched last, which may be
  // the tool's own, does not snap any more.
  Vec3 step_in_space(const Vec3& p_SD, double dt_s, std::uint32_t buttons = 0) noexcept;
  void reset() noexcept;
  // Of an object of the scene; layers replace the damping. RT: yes.
  void set_drag(std::size_t object, const SurfaceDrag& drag) noexcept;
  // A surface or the space has an effect.
  bool any() const noexcept;
  // Goes on with the velocities of the device that `other` has followed to its last sample: of the hand, and relative to moving
  // surfaces if these are as many. Pre: a step at that sample.
  void continue_hand_motion(const EffectStep& other) noexcept;
  // The scene was moved, so that the last device point has other coordinates in frame S: this is not a motion of the hand.
  void note_scene_moved(const Vec3& last_p_SD) noexcept;

 private:
  // A choice: a longer gap between two samples counts as this.
  static constexpr double kLongestS = 1.0;

  // State of one object since it was first touched in this contact. A probe between two objects may alternate between them.
  struct ObjectState {
    SurfaceEffectState effects;
    std::uint64_t contact = 0;
  };
  struct Placed {
    SwitchedEffect effect;
    BurstEffect::State burst;
    MassEffect::State mass;
    EffectSwitch::State on;
  };

  // One sample as a surface sees it: in its frame.
  struct Seen {
    EffectSample sample;
    Vec3 newest_v = Vec3::Zero();  // over the last interval alone
    Vec3 motion = Vec3::Zero();    // since the sample before
    double dt_s = 0.0;
  };

  // How a surface is pressed at one sample.
  struct Press {
    Vec3 normal;
    double method_n;  // force of the method
    double depth_m;   // of the hand below the surface, without bumps
    double normal_n;  // force along the normal, with bumps, layers and damping
    bool begins;      // the first sample of a contact
  };

  SurfaceEffectState& state_of(int object) noexcept;
  int frame_of(int object) const noexcept { return frame_of_.empty() ? kStill : frame_of_[static_cast<std::size_t>(object)]; }
  void advance_frames(const Vec3& p_SD, double dt_s) noexcept;
  void carry_into(int frame) noexcept;
  Vec3 moving_force(SurfaceFrame& frame, const EffectSample& sample, double dt_s, const SurfaceContact& contact, Vec3& p_SP) noexcept;
  Vec3 surface_force(const Seen& seen, const SurfaceContact& contact, Vec3& p_SP) noexcept;
  void add_friction(const Seen& seen, const SurfaceEffects& surface, const MapSample& map, const Press& press, Vec3& force_n) noexcept;
  Vec3 leave_surface(const EffectSample& sample) noexcept;
  Vec3 space_force(const EffectSample& sample, std::uint32_t buttons) noexcept;

  std::vector<SurfaceEffects> surfaces_;  // by object
  std::vector<Placed> space_;
  SmoothVelocity velocity_;
  double time_s_ = 0.0;
  int touched_ = -1;  // the object touched in the last step that touched any
  bool in_contact_ = false;
  Vec3 last_p_SD_ = Vec3::Zero();
  std::vector<int> frame_of_;  // by object; empty: nothing moves
  std::vector<SurfaceFrame> frames_;
  std::span<const Pose> X_SF_;           // of these, at the next sample
  int carried_in_ = kStill;              // the frame of the next two
  SpringFriction::State friction_;       // carried over from object to object, so that the force stays
  std::optional<TextureVoice> texture_;  // carried over likewise; none: no surface has one
  std::uint64_t contacts_ = 0;           // begun from free space
  std::vector<ObjectState> states_;      // by object
};

}  // namespace hapton
