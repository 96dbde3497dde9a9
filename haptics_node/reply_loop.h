#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "haptic_step/haptics_step.h"
#include "haptic_step/object_mover.h"
#include "haptics_node/carve_sender.h"
#include "haptics_node/carve_undo_task.h"
#include "haptics_node/inside_body_warning.h"
#include "haptics_node/material_task.h"
#include "haptics_node/method_builder.h"
#include "haptics_node/object_shaper.h"
#include "haptics_node/patch_sender.h"
#include "haptics_node/state_wait.h"
#include "haptics_node/stiffness_adviser.h"
#include "link/hub_client.h"
#include "runtime/clock.h"
#include "runtime/latency_histogram.h"
#include "runtime/stop_signal.h"

namespace hapton {

// The loop of the haptics node: replies to the newest device state at once, and does everything else after the reply. With a method that
// builds on approach, the first reply waits until the objects nearby are built, so resumed contact has a force from the first reply on,
// and the same states give the same forces again. It sends the hub its setup once a second and after a change, for recordings, with the
// result of a method request, and its scene. A vision node with another scene is logged. RT: run and turn yes, except logging. Threads:
// one.
class ReplyLoop {
 public:
  ReplyLoop(HubClient& hub, const Clock& clock, HapticsStep& step, MethodBuilder& builder, const HapticsSetup& setup = {},
            bool builds_on_approach = false, const SceneFacts& scene = {});

  // Before run: what offers the hub the scene in parts. Pre: outlives this.
  void set_patch_sender(PatchSender* patches) noexcept { patches_ = patches; }
  // Before run: who works out changes of materials. Pre: outlives this.
  void set_material_task(MaterialTask* material_task) noexcept { material_task_ = material_task; }
  // Before run: who carries out what programs request of the objects. Without one, such requests are left out. Pre: outlives this.
  void set_object_mover(ObjectMover* mover) noexcept { mover_ = mover; }
  // Before run: who deforms objects as programs request. Without one, such requests are left out. With one, the method stays. Pre: outlives
  // this.
  void set_object_shaper(ObjectShaper* shapes) noexcept { shapes_ = shapes; }
  // Before run: who keeps and sends what the stylus carves. Pre: outlives this.
  void set_carve_sender(CarveSender* carves) noexcept { carves_ = carves; }
  // Before run: who undoes it on request. Pre: outlives this; there is a carve sender.
  void set_carve_undo(CarveUndoTask* undo) noexcept { undo_ = undo; }
  // Before run: effects from shared libraries, which the step adds. Logs each of these, and each method from a shared library, that is
  // cut off. Pre: outlives this.
  void set_effects(PluginEffects* effects);
  // Before run: gets the hub's reports about its loop. Pre: outlives this.
  void set_stiffness_adviser(StiffnessAdviser* adviser) noexcept { adviser_ = adviser; }
  // Before run: who notices a hand that is inside a body from the start. Pre: outlives this.
  void set_inside_body_warning(InsideBodyWarning* inside) noexcept { inside_ = inside; }

  // Before run: the longest time to spin for a device state (StateWait).
  void set_longest_spin(std::int64_t longest_ns) noexcept { wait_.set_longest_spin(longest_ns); }

  // Runs until a signal requests the stop or, if `seconds` is above 0, for that time.
  void run(const StopSignal& stop, double seconds);

  // One turn: waits for a message until deadline_ns, replies to the newest state.
  void turn(std::int64_t deadline_ns);

  // From a state's arrival to its reply's departure.
  const LatencyHistogram& compute_times() const noexcept { return compute_times_; }
  // Of them the step alone: device sample to force.
  const LatencyHistogram& step_times() const noexcept { return step_times_; }
  const StateWait& wait() const noexcept { return wait_; }

 private:
  void drain(std::int64_t began_ns) noexcept;
  void note_join() noexcept;
  void handle(const Message& message) noexcept;
  bool is_ready() noexcept;
  void reply() noexcept;
  void request_materials(const MaterialRequest& request) noexcept;
  void reject_method(std::uint32_t request) noexcept;
  void change_method() noexcept;
  void change_materials() noexcept;
  bool is_tuned() const noexcept { return tuned_ != nullptr && tuned_->scene == material_revision_; }
  void take_scene(const NewScene& scene) noexcept;
  void describe_scene(std::uint64_t hash, const SceneFacts& facts) noexcept;
  void send_patches() noexcept;
  bool sends_parts(std::int64_t now_ns) const noexcept {
    return patches_ != nullptr && patches_->is_offered() && patches_->is_wanted(now_ns);
  }
  bool has_withdrawn() const noexcept { return patches_ != nullptr && patches_->is_withdrawn(hub_.session()); }
  void show_method(const HapticsSetup::Text& method) noexcept;
  void show_method_in_use() noexcept;
  void send_setup_soon() noexcept;
  void wait_for_builder() noexcept;
  void send_setup() noexcept;
  void report_hub_state();
  void report_scene();
  void report_shown_tool();
  void report_tool();
  void note_hand() noexcept;
  void report_inside() noexcept;
  void report_patches();
  std::string_view find_patch_obstacle() const noexcept;
  void withdraw_parts() noexcept;
  void report_grasp() noexcept;
  bool is_holding() const noexcept;
  void send_poses() noexcept;
  void move_objects();
  void repeat_move() noexcept;
  void send_moves() noexcept;
  bool handle_shape(const Message& message) noexcept;
  void deform_objects();
  void send_shape_starts() noexcept;
  void report_shape(const ShapeReply& reply);
  void note_carve() noexcept;
  void request_undo(const CarveUndo& request) noexcept;
  void undo_carves();
  void send_carves();
  void report_move(const ObjectMover::Done& done);
  void report_plugins();
  bool is_method_cut_off() const noexcept;
  void show_plugins();

  HubClient& hub_;
  StateWait wait_;
  const Clock& clock_;
  HapticsStep& step_;
  MethodBuilder& builder_;
  HapticsSetup setup_;
  HapticsSetup::Text method_ = {};        // without effects from shared libraries; while no object is held
  HapticsSetup::Text effects_text_ = {};  // of these
  SceneFacts scene_;
  PatchSender* patches_ = nullptr;
  std::string_view patch_obstacle_reported_;                 // to a hub that asks; empty: none
  static constexpr std::int64_t kThinnedGapNs = 40'000'000;  // the hub sends 20 states a second while it computes the force
  std::int64_t state_ns_ = 0;                                // time of the newest state's sample
  std::int64_t state_gap_ns_ = 0;                            // ... since the one before
  bool is_first_reply_ = true;                               // of this session, is still to come
  bool wants_patches_ = false;                               // the hub
  PluginEffects* effects_ = nullptr;
  bool is_method_cut_off_ = false;  // as reported
  StiffnessAdviser* adviser_ = nullptr;
  InsideBodyWarning* inside_ = nullptr;
  std::uint32_t free_starts_ = 0;  // of the step, as noted there
  MaterialTask* material_task_ = nullptr;
  std::unique_ptr<TunedMaterials> tuned_;  // in use, if it is of these materials; null, or of others: those of the scene's file
  std::uint32_t scene_revision_ = 0;       // NewScene::revision of the scene in use
  std::uint32_t material_revision_ = 0;    // of the scene that its materials came with: objects that are put down keep theirs
  const PlacedScene* placed_ = nullptr;    // of a scene that is not in use yet; null: none
  MaterialState materials_;
  std::uint64_t scene_shown_ = 0;     // hash of the scene that a vision node last reported; 0: none
  std::uint64_t scene_reported_ = 0;  // of these, the one that the log spoke of
  std::uint64_t tool_shown_ = 0;      // the same of its tool (SceneFacts::tool_hash)
  std::uint64_t tool_reported_ = 0;
  bool builds_on_approach_;
  std::optional<std::uint64_t> idle_polls_before_;  // of the builder, at the call of announce_start
  std::int64_t next_setup_ns_ = 0;
  std::int64_t setup_sent_ns_ = 0;
  std::int64_t preparing_since_ns_ = 0;  // a state waits for the first reply since then; 0: none
  std::uint64_t setup_session_ = 0;      // of the setup
  int setup_repeats_ = 0;                // still to be sent soon
  Datagram datagram_;
  LatencyHistogram compute_times_;
  LatencyHistogram step_times_;
  std::int64_t arrival_ns_ = 0;
  std::int64_t start_ns_;
  std::uint64_t session_ = 0;
  std::uint32_t last_request_ = 0;           // of a method
  std::uint32_t last_material_request_ = 0;  // of a material
  JoinState state_reported_ = JoinState::joining;
  bool absence_reported_ = false;
  bool is_tool_blocked_ = false;   // as reported
  std::uint32_t pose_serial_ = 0;  // of the objects' poses, as reported
  std::size_t next_pose_ = 0;      // to be sent again
  CarveSender* carves_ = nullptr;
  CarveUndoTask* undo_ = nullptr;
  bool are_carves_full_ = false;  // as reported
  ObjectShaper* shapes_ = nullptr;
  std::int64_t repeat_start_ns_ = 0;    // the newest start of a shape is sent again then
  int start_repeats_ = 0;               // so often
  std::int64_t last_shape_ns_ = 0;      // an object took a shape
  std::int64_t shape_rejected_ns_ = 0;  // the log spoke of one
  ObjectMover* mover_ = nullptr;
  std::uint64_t joins_ = 0;            // of the hub, after which the moves were announced
  std::size_t next_move_ = 0;          // of mover_->moves(), to be sent again
  std::int64_t next_move_ns_ = 0;      // no request is carried out before
  std::int64_t repeat_move_ns_ = 0;    // the newest move is sent again then
  int move_repeats_ = 0;               // so often
  std::int64_t last_move_ns_ = 0;      // a request was carried out
  std::int64_t move_rejected_ns_ = 0;  // the log spoke of one
};

}  // namespace hapton
