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
// builds on approach, the first reply waits until the objects nearby are built, so that resumed contact has a force from the first reply
// on, and the same states always give the same forces. Once a second and after each change, the loop sends the hub its setup (for
// recordings, with the reply to a method request) and the facts of its scene. A vision node that shows another scene is logged. RT: run and
// turn yes, except logging. Threads: one.
class ReplyLoop {
 public:
  ReplyLoop(HubClient& hub, const Clock& clock, HapticsStep& step, MethodBuilder& builder, const HapticsSetup& setup = {},
            bool builds_on_approach = false, const SceneFacts& scene = {});

  // Before run: offers the hub the scene in parts. Pre: patches outlives this.
  void set_patch_sender(PatchSender* patches) noexcept { patch_sender_ = patches; }
  // Before run: computes changes of materials. Pre: material_task outlives this.
  void set_material_task(MaterialTask* material_task) noexcept { material_task_ = material_task; }
  // Before run: moves objects as programs request. Without a mover, such requests are ignored. Pre: mover outlives this.
  void set_object_mover(ObjectMover* mover) noexcept { mover_ = mover; }
  // Before run: deforms objects as programs request. Without a shaper, such requests are ignored; with one, requests of another method are
  // rejected. Pre: shapes outlives this.
  void set_object_shaper(ObjectShaper* shapes) noexcept { object_shaper_ = shapes; }
  // Before run: keeps and sends the carves that the stylus makes. Pre: carves outlives this.
  void set_carve_sender(CarveSender* carves) noexcept { carve_sender_ = carves; }
  // Before run: undoes carves on request. Pre: undo outlives this; set_carve_sender was called.
  void set_carve_undo(CarveUndoTask* undo) noexcept { carve_undo_ = undo; }
  // Before run: the effects from shared libraries that the step adds. The loop logs each of them that is cut off, and each method from a
  // shared library that is cut off. Pre: effects outlives this.
  void set_effects(PluginEffects* effects);
  // Before run: gets the hub's LoopFacts. Pre: adviser outlives this.
  void set_stiffness_adviser(StiffnessAdviser* adviser) noexcept { adviser_ = adviser; }
  // Before run: warns if the hand is inside a body from the start. Pre: inside outlives this.
  void set_inside_body_warning(InsideBodyWarning* inside) noexcept { inside_warning_ = inside; }

  // Before run: the longest time to spin for a device state (StateWait).
  void set_longest_spin(std::int64_t longest_ns) noexcept { wait_.set_longest_spin(longest_ns); }

  // Runs until a signal requests the stop or, if `seconds` is above 0, for that time.
  void run(const StopSignal& stop, double seconds);

  // One turn: waits for a message until deadline_ns, replies to the newest state.
  void turn(std::int64_t deadline_ns);

  // Times from the arrival of a state until its reply is sent.
  const LatencyHistogram& compute_times() const noexcept { return compute_times_; }
  // The part of these times that the step takes: from device sample to force.
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
  bool is_tuned() const noexcept { return tuned_ != nullptr && tuned_->scene_revision == material_revision_; }
  void take_scene(const NewScene& scene) noexcept;
  void describe_scene(std::uint64_t hash, const SceneFacts& facts) noexcept;
  void send_patches() noexcept;
  bool sends_parts(std::int64_t now_ns) const noexcept {
    return patch_sender_ != nullptr && patch_sender_->is_offered() && patch_sender_->is_wanted(now_ns);
  }
  bool has_withdrawn() const noexcept { return patch_sender_ != nullptr && patch_sender_->is_withdrawn(hub_.session()); }
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
  void report_move(const ObjectMover::Outcome& outcome);
  void report_plugins();
  bool is_method_cut_off() const noexcept;
  void show_plugins();

  HubClient& hub_;
  StateWait wait_;
  const Clock& clock_;
  HapticsStep& step_;
  MethodBuilder& builder_;
  HapticsSetup setup_;
  HapticsSetup::Text method_text_ = {};   // of the probe or the scene's tool, without effects from shared libraries
  HapticsSetup::Text effects_text_ = {};  // text of these effects
  SceneFacts scene_;
  PatchSender* patch_sender_ = nullptr;
  std::string_view patch_obstacle_reported_;                 // logged for a hub that requests parts; empty: none
  static constexpr std::int64_t kThinnedGapNs = 40'000'000;  // the hub sends 20 states a second while it computes the force
  std::int64_t state_ns_ = 0;                                // sample time of the newest state
  std::int64_t state_gap_ns_ = 0;                            // from the sample of the state before to it
  bool is_first_reply_ = true;                               // the first reply of this session is still to be sent
  bool wants_patches_ = false;                               // the hub requests parts of the scene
  PluginEffects* effects_ = nullptr;
  bool is_method_cut_off_ = false;  // as logged last
  StiffnessAdviser* adviser_ = nullptr;
  InsideBodyWarning* inside_warning_ = nullptr;
  std::uint32_t free_starts_ = 0;  // HapticsStep::free_starts(), as passed to inside_warning_
  MaterialTask* material_task_ = nullptr;
  std::unique_ptr<TunedMaterials> tuned_;      // in use while is_tuned(); otherwise the materials of the scene file are in use
  std::uint32_t scene_revision_ = 0;           // NewScene::revision of the scene in use
  std::uint32_t material_revision_ = 0;        // revision that the materials came with: a scene with an object put down keeps them
  const PlacedScene* placed_scene_ = nullptr;  // facts of a scene that may not be in use yet; null: none
  MaterialState materials_;
  std::uint64_t shown_scene_hash_ = 0;     // hash of the scene that a vision node last reported; 0: none
  std::uint64_t reported_scene_hash_ = 0;  // shown_scene_hash_ when it was logged last
  std::uint64_t shown_tool_hash_ = 0;      // SceneFacts::tool_hash that a vision node last reported; 0: none
  std::uint64_t reported_tool_hash_ = 0;   // shown_tool_hash_ when it was logged last
  bool builds_on_approach_;
  std::optional<std::uint64_t> idle_polls_before_;  // MethodBuilder::idle_polls() at the call of announce_start
  std::int64_t next_setup_ns_ = 0;
  std::int64_t setup_sent_ns_ = 0;
  std::int64_t preparing_since_ns_ = 0;  // since when a state has waited for the first reply; 0: none waits
  std::uint64_t setup_session_ = 0;      // session in which the setup was sent last
  int setup_repeats_ = 0;                // how often the setup is still to be sent soon
  Datagram datagram_;
  LatencyHistogram compute_times_;
  LatencyHistogram step_times_;
  std::int64_t arrival_ns_ = 0;
  std::int64_t start_ns_;
  std::uint64_t session_ = 0;
  std::uint32_t last_request_ = 0;           // Settings::method_request handled last
  std::uint32_t last_material_request_ = 0;  // MaterialRequest::request handled last
  JoinState state_reported_ = JoinState::joining;
  bool absence_reported_ = false;
  bool is_tool_blocked_ = false;   // as logged last
  std::uint32_t pose_serial_ = 0;  // Grasp::pose_serial(), as sent last
  std::size_t next_pose_ = 0;      // index of the pose to be sent again next
  CarveSender* carve_sender_ = nullptr;
  CarveUndoTask* carve_undo_ = nullptr;
  bool are_carves_full_ = false;  // as logged last
  ObjectShaper* object_shaper_ = nullptr;
  std::int64_t repeat_start_ns_ = 0;    // when the newest start of a shape is sent again
  int start_repeats_ = 0;               // how often it is still sent again
  std::int64_t last_shape_ns_ = 0;      // when a shape was announced last
  std::int64_t shape_rejected_ns_ = 0;  // when a rejected shape was logged last
  ObjectMover* mover_ = nullptr;
  std::uint64_t handled_joins_ = 0;    // HubClient::counts().joins, as handled by note_join() last
  std::size_t next_move_ = 0;          // index in mover_->moves() of the move to be sent again next
  std::int64_t next_move_ns_ = 0;      // before this time no request is carried out
  std::int64_t repeat_move_ns_ = 0;    // when the newest move is sent again
  int move_repeats_ = 0;               // how often it is still sent again
  std::int64_t last_move_ns_ = 0;      // when a request was carried out last
  std::int64_t move_rejected_ns_ = 0;  // when a rejected request was logged last
};

}  // namespace hapton
