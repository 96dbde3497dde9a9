#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/force/force_fade.h"
#include "core/force/streamed_method.h"
#include "core/force/touch_step.h"
#include "core/tool/stylus_tool.h"
#include "haptic_step/grasp.h"
#include "link/messages.h"
#include "plugin/plugin_effects.h"
#include "scene/tool_obstacles.h"

namespace hapton {

// Counters of the haptics node.
struct HapticsCounts {
  std::uint64_t replied = 0;
  std::uint64_t contact_steps = 0;
  std::uint64_t skipped = 0;  // states superseded before the reply
  std::uint64_t views_applied = 0;
  std::uint64_t views_rejected = 0;  // not rigid
  std::uint64_t method_changes = 0;  // changes while running
  std::uint64_t materials_taken = 0;
  std::uint64_t moves_taken = 0;     // moves of objects by programs
  std::uint64_t shapes_applied = 0;  // stages of objects that programs deform
  double max_force_n = 0.0;
  // Of a rigid tool:
  double max_torque_nm = 0.0;
  std::uint64_t haptons = 0;  // over all steps in contact (pairs of triangles that touch: a unit of the memo, section 5)
  int most_haptons = 0;       // in one step
};

// What the haptics node computes, without its threads, clock and link: device states and view transforms go in, force commands come out.
// Frames: W world, S static scene, D device point, T stylus, P probe or tool, O an object from its place in the scene file. RT: all but
// construction yes. Threads: one.
class HapticsStep {
 public:
  // offset_m: distance off the surface, on the side in contact, at which a new method starts when it takes over in contact.
  explicit HapticsStep(std::unique_ptr<TouchStep> touch, double offset_m);

  // Before the first reply: the stylus holds a rigid tool, which is rendered in place of the method's probe. parts: the parts of the scene
  // that move, the same that the tool was made for. Pre: the tool outlives this object.
  void hold(StylusTool* tool, std::vector<ToolPart> parts = {});
  bool holds_tool() const noexcept { return tool_ != nullptr; }
  // Before the first reply: sets what picks up movable objects with the stylus. parts: the parts of the scene that move; each tool of
  // `grasp` is made for these. Pre: `grasp` outlives this object.
  void set_grasp(Grasp* grasp, std::vector<ToolPart> parts = {});
  // Null: nothing is movable.
  Grasp* grasp() const noexcept { return grasp_; }
  // Before the first reply: sets effects from shared libraries, added to every force of every method. Pre: they outlive this object.
  void use_effects(PluginEffects* effects) noexcept { effects_ = effects; }
  // Whether there are effects, of the scene or from shared libraries: the force then depends on more than the contact.
  bool has_effects() const noexcept { return effects_ != nullptr || touch_->has_effects(); }
  // Whether, in the last reply, the tool gave no force because it has overlapped the scene since it was put there.
  bool is_tool_blocked() const noexcept { return is_tool_blocked_; }

  // Whether the hub may compute the force itself. It then sends few states, between which a hand goes far. When it needs forces
  // again, it sends the position of its probe (DeviceState::is_resumed).
  void set_thinned(bool is_thinned) noexcept { is_thinned_ = is_thinned; }
  // A newer state for the next reply; one still waiting is skipped. If the hand may have gone around something since the last reply (more
  // than kResumeReachM away, after a gap in the samples or in a jump), the probe begins anew, as in a new session: see resume(). So does a
  // rigid tool, also if it was turned by more than kResumeTurnRad meanwhile. With set_thinned(true) only state.is_resumed causes this.
  void offer(const DeviceState& state) noexcept;
  bool has_state() const noexcept { return has_state_; }
  // Whether there was a reply since the start or the last restart().
  bool is_running() const noexcept { return is_running_; }
  // How often the probe, or a rigid tool, started at the device point, because there was no earlier contact to continue.
  std::uint32_t free_starts() const noexcept { return free_starts_; }
  // A point of the probe or tool at the last reply, frame S: the device point, or a vertex of the tool of hold() in the device's pose.
  Vec3 p_STouching() const noexcept;
  // Whether there was contact at the last reply.
  bool has_contact() const noexcept { return output_.contact || is_tool_in_contact_; }

  // Tells the method where it will start, so that its slow task can build the objects there; changes nothing else. Pre: has_state(), not
  // is_running().
  void announce_start() noexcept;

  // The force for the newest state, with the number of its sample; compute_ns is left to the caller. Pre: has_state().
  ForceCommand reply() noexcept;

  // Moves the static scene. False: the pose is not rigid, and the scene stays.
  bool turn_scene(const ViewTransform& view) noexcept;

  // Sets the scene time of the next reply, from which keyframes continue. Without this call scene time begins at 0 with the first reply and
  // advances with the samples. A gap between two samples counts as at most kMaxSceneStepNs, the time between two sessions as 0. A state
  // that has a scene time of its own (DeviceState) sets it.
  void set_scene_time(std::int64_t time_ns) noexcept { next_scene_time_ns_ = time_ns; }
  // The time between samples that the hub sends to a node that computes no force (20 a second).
  static constexpr std::int64_t kMaxSceneStepNs = 50'000'000;

  std::int64_t scene_time_ns() const noexcept { return scene_time_ns_; }

  // Moves an object, as TouchStep::command; it counts from the next reply on. The times of the move are scene times.
  bool command(int object, const CommandedMove& move) noexcept;

  // A program deforms an object: gives it its next stage, as StreamedMethod::offer_at; times are scene times. Returned: as there.
  // Pre: programs may deform the object.
  std::unique_ptr<ShapeStage> deform(int object, std::unique_ptr<ShapeStage> stage, std::int64_t start_ns, std::int64_t end_ns) noexcept;

  // Replaces the method and returns the old one. Objects that programs moved stay where they are, and what was carved stays
  // carved. In contact the new method starts where the probe of the old one is, on the same side of the surface,
  // so its first step has the same contact; in free space it starts at the device point.
  // If the forces of the two differ, the difference fades (ForceFade).
  std::unique_ptr<TouchStep> replace(std::unique_ptr<TouchStep> touch) noexcept;

  // What the last reply carved; null: nothing.
  const MadeCarve* made_carve() const noexcept { return touch_->made_carve(); }
  // Calls TouchStep::repeat_carve.
  bool repeat_carve(int object, const Carve& carve) noexcept { return touch_->repeat_carve(object, carve); }
  // Calls TouchStep::restore_carves, after carves were undone. In contact the difference of the forces fades (ForceFade).
  bool restore_carves(Sculpture& other, std::uint32_t newest) noexcept;
  // Puts `touch` in place of the present method without counting a change of method: for a replay that begins anew with whole bodies.
  void begin_anew(std::unique_ptr<TouchStep> touch) noexcept {
    touch->copy_commands(*touch_);
    touch_ = std::move(touch);
    restart();
  }

  // The materials have changed, as ForceMethod::set_materials has them; the proxy stays. In contact the difference of the forces fades
  // (ForceFade), as after a change of method.
  void set_materials(std::span<const Material> materials) noexcept;
  // The same with a rigid tool held from the start (hold). of_tool: as in StylusTool::set_materials. Pre: holds_tool(), and as there.
  void set_materials(std::span<const Material> materials, const ToolMaterials& of_tool) noexcept;

  // Forgets contact and time.
  void restart() noexcept {
    is_running_ = begins_within_session_ = false;
    replied_before_ = 0;
    resume_p_WP_.reset();
    fade_.forget();
    torque_fade_.forget();
  }

  // A new hub session begins: as restart, but contact continues at the probe's position, if the device is still near (kResumeReachM).
  void resume() noexcept;

  // The last view transform that turn_scene() took.
  const ViewTransform& view() const noexcept { return view_; }

  const HapticsCounts& counts() const noexcept { return counts_; }
  const TouchStep& touch() const noexcept { return *touch_; }

 private:
  Vec3 held_offset() const noexcept;
  void restart_here(bool is_in_contact) noexcept;
  void remember_reply() noexcept;
  void render_probe(ForceCommand& reply) noexcept;
  void begin_at(const TouchInput& start) noexcept;
  void render_tool(ForceCommand& reply, bool is_near) noexcept;
  void set_parts(std::vector<ToolPart> parts);
  void place_parts() noexcept;
  void note_push(ForceCommand& reply) const noexcept;
  void render_space_effects(ForceCommand& reply) noexcept;
  void update_grasp() noexcept;
  void return_probe() noexcept;
  void advance_scene(std::int64_t step_ns) noexcept;
  void add_effects(ForceCommand& reply, bool begins) noexcept;
  TouchInput make_start() noexcept;

  std::unique_ptr<TouchStep> touch_;
  StylusTool* tool_ = nullptr;
  std::vector<ToolPart> tool_parts_;
  std::vector<Pose> X_SO_;  // the poses of these parts
  Grasp* grasp_ = nullptr;
  PluginEffects* effects_ = nullptr;  // null: none
  bool is_tool_blocked_ = false;
  bool is_tool_in_contact_ = false;  // by a surface, in the last reply
  double offset_m_;
  Pose X_WS_ = Pose::Identity();
  ViewTransform view_;
  DeviceState state_;
  TouchInput input_;                      // the input of the last reply
  TouchOutput output_;                    // the method's output at the last reply, without fade and tool
  ForceFade fade_;                        // fades the difference from an earlier method, N
  ForceFade torque_fade_;                 // the same for the torque, Nm
  std::optional<Vec3> resume_p_WP_;       // where the probe rested when the session ended, or an object was put down
  Vec3 resume_outward_W_ = Vec3::Zero();  // from the device point to there, at that time
  std::int64_t last_time_ns_ = 0;
  std::int64_t scene_time_ns_ = 0;
  std::optional<std::int64_t> next_scene_time_ns_;
  std::uint64_t last_sample_ = 0;     // the sample of the last reply
  std::uint64_t replied_before_ = 0;  // as in ForceCommand, for the next reply: without last_sample_
  std::uint32_t skipped_ = 0;
  std::uint32_t free_starts_ = 0;
  bool has_state_ = false;
  bool is_running_ = false;             // there was a last reply
  bool is_thinned_ = false;             // see set_thinned
  bool begins_within_session_ = false;  // not running, since the probe begins anew within a session
  HapticsCounts counts_;
};

}  // namespace hapton
