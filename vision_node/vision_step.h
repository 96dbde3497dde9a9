#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "link/messages.h"
#include "scene/object_names.h"
#include "vision_node/camera_view.h"
#include "vision_node/frame_log.h"
#include "vision_node/hud_text.h"
#include "vision_node/interaction.h"
#include "vision_node/knob_box.h"
#include "vision_node/live_plots.h"
#include "vision_node/probe_shown.h"
#include "vision_node/stereo_camera.h"
#include "vision_node/viewer_head.h"

namespace hapton {

struct VisionStepSettings {
  Vec3 p_WC = Vec3::Zero();   // workspace centre, about which the dials turn
  Dials dials;                // the dials at the start
  double max_rate_hz = 60.0;  // frames a second; 0: no limit
  Quat stylus_lean = Quat::Identity();
  bool always_changing = false;  // draw even when nothing moved: modes that alternate the eyes
  bool cull = true;
  bool help = true;
  bool depth_cues = true;
  std::string stereo;        // the mode's name, for the HUD
  Framing home;              // the initial view
  Vec3 p_SO = Vec3::Zero();  // centre of a sphere around the scene
  double scene_radius_m = 0.0;
  double threshold_px = 0.5;      // smaller motion causes no frame
  std::vector<ObjectName> names;  // names of the objects shown
  bool plots = false;
  Head head;                    // the viewer's head at the start
  double ipd_m = kEyeDistance;  // between the viewer's eyes, real metres
};

// All decisions of the vision node, without a window, socket or clock. Inputs: messages of the hub and events of the window; outputs: when
// to draw, what to draw and what to send. Times: any one monotonic clock, ns. RT: no.
class VisionStep {
 public:
  // The present picture: its place in the world, its size in pixels, and the sizes of the drawn probe.
  struct Screen {
    StereoScreen screen;
    PictureSize picture;
    ProbeSizes sizes;
  };
  // Content of the next frame.
  struct Shown {
    Pose X_WS = Pose::Identity();
    Framing framing;
    std::optional<ProbeShown> probe;  // none before the first ProbeState
    std::string hud;
    std::string_view help;
    std::string notice;  // what is wrong with the scene; empty: nothing
    bool cull = true;
    bool depth_cues = true;
    std::vector<PlotContent> plots;
  };
  struct Texts {
    std::string_view hud;
    std::string_view help;
    std::string_view notice;
  };

  explicit VisionStep(VisionStepSettings settings);

  // Takes the newest state. Pre: it is not older than the one before (the caller drops older ones). received_ns: for plots.
  void receive(const ProbeState& state, std::int64_t received_ns = 0);
  // The hub rejected a view transform of ours: one line in the log for each.
  void receive(const ViewRejected& rejected) { sender_.reject(rejected.revision); }
  // The hub has a view of another vision node, or from before this node joined: the scene is shown in that pose, as it is felt, and the
  // dials continue from it. If dials were given at the start, the view is ignored until these have been sent to the hub.
  void receive(const ViewTransform& view);
  // The hub was joined, for the first time or again.
  void note_join();
  // The hub no longer replies.
  void note_loss() {
    is_connected_ = false;
    preparing_s_ = 0.0;
    plots_.forget_force();
  }
  // Handles an event of the window. p_WQ: the visible point of the scene under the pointer, if wants_surface(event); none: there is none.
  void handle(const WindowEvent& event, const Screen& where, const std::optional<Vec3>& p_WQ = {});
  // Moves the led hand on towards the pointer, around obstacles. visible: the visible surface; null: the hand goes straight to the pointer.
  void lead_hand(const VisibleDepth* visible);
  // Whether handle() would use the surface under the pointer.
  bool wants_surface(const WindowEvent& event) const;
  // Turns the dials of the knob box by these angles, degrees.
  void turn_dials(const Vec3& degrees);
  // Sets the pose of the head. Pre: is_possible().
  void set_head(const Head& head) { head_.track(head); }
  // Moves the head, as keys do. by_m: to the right, up, away from the screen.
  void move_head(const Vec3& by_m) { head_.move(by_m); }
  // Sets a line that says what is wrong with the head's tracker; empty: nothing.
  void set_head_notice(std::string line) { head_notice_ = std::move(line); }
  // Sets a line that says why the scene file in its present content is not shown; empty: it is shown.
  void set_scene_problem(std::string line) {
    if (line == scene_problem_) return;
    scene_problem_ = std::move(line);
    request_redraw();
  }
  const std::string& scene_problem() const { return scene_problem_; }
  // The next frame must be drawn whether or not something moved (the window was uncovered or resized).
  void request_redraw() { needs_redraw_ = true; }
  // Another scene is shown. home: its initial view; is_view_new: the viewer's own turns, pans and zoom are reset.
  void change_scene(const Framing& home, const Vec3& p_SO, double radius_m, std::vector<ObjectName> names, bool is_view_new);
  // The scene has another shape: a frame is drawn, and full detail only once the scene has kept its shape for a while.
  void reshape_scene() { needs_redraw_ = has_new_shape_ = true; }

  UserRequests take_requests();
  // Another stereo mode is used from now on. name, always_changing: see VisionStepSettings.
  void set_stereo(std::string_view name, bool always_changing);
  // haptics_node has been building its scene for this long; 0: it is done. Ignored from 3 s after now_ns on, if it is not repeated.
  void set_preparing(double seconds, std::int64_t now_ns) {
    preparing_s_ = seconds;
    preparing_set_ns_ = now_ns;
  }
  void set_detail_progress(double progress) { detail_progress_ = progress; }

  // The next message to send; call until empty: view transform, hand target.
  std::optional<Message> take_message(std::int64_t now_ns);

  // True if the present picture is outdated and max_rate_hz allows another frame.
  bool wants_picture(std::int64_t now_ns, const Screen& where);
  // Whether max_rate_hz allows a frame now.
  bool may_draw(std::int64_t now_ns) const;
  // What is to be drawn next. The numbers in its texts usually change at most ten times a second, so that they can be read.
  Shown compose(std::int64_t now_ns);
  // The texts of the newest state, for a screenshot; valid until the next call of this or compose().
  Texts compose_texts(std::int64_t now_ns);
  // The newest probe, for a frame that is being drawn.
  std::optional<ProbeShown> newest_probe() const;
  // True: nothing but the probe has moved for 0.15 s, so that it is worth drawing the scene in full detail.
  bool is_scene_at_rest(std::int64_t now_ns) const;
  // The frame of the last compose() is in the window. Returns its acknowledgement for the hub.
  std::optional<FrameAck> end_frame(std::int64_t start_ns, std::int64_t end_ns, const Screen& where);
  // Records the motion to photon of the frame of the last end_frame().
  void record_motion(std::int64_t motion_to_photon_ns, std::int64_t now_ns) {
    frames_.record_motion_to_photon(motion_to_photon_ns);
    plots_.record_motion_to_photon(motion_to_photon_ns, now_ns);
  }
  // The acknowledgement of a state that wants_picture() found to look the same as the picture; once for each such state.
  std::optional<FrameAck> take_unchanged_ack();

  // The pose of the scene with which the forces of that revision were computed; the present pose if the revision is not known.
  Pose find_scene_pose(std::uint32_t view_revision) const { return sender_.find_pose(view_revision).value_or(scene_pose()); }
  const Vec3& workspace_centre() const { return settings_.p_WC; }
  // Strokes or measures have changed; line: about them, for the picture's corner. Does not renew the image of the scene or other numbers.
  void set_annotations(std::string line) {
    annotations_ = std::move(line);
    has_new_annotations_ = true;
  }
  Pose scene_pose() const { return recorded_X_WS_ ? *recorded_X_WS_ : dialled_pose(); }
  // A recording is shown, in which the static scene had this pose; the dials have no effect. line, recent_event: see HudFacts.
  void set_recording(const Pose& X_WS, std::string line, std::string recent_event) {
    recorded_X_WS_ = X_WS;
    recording_ = std::move(line);
    recent_event_ = std::move(recent_event);
  }
  // Sets what has just happened, see HudFacts.
  void set_recent_event(std::string line) {
    recent_event_ = std::move(line);
    request_redraw();
  }
  const std::string& recent_event() const { return recent_event_; }
  // The picture of the teaching view has changed; line: see HudFacts::teaching.
  void set_teaching(std::string line) {
    teaching_ = std::move(line);
    request_redraw();
  }
  bool shows_plots() const { return plots_.is_shown(); }
  // The object that the stylus has picked up; -1: none.
  void set_held_object(std::int32_t object) {
    held_object_ = object;
    request_redraw();
  }
  std::int32_t held_object() const { return held_object_; }
  // Whether haptics_node has another scene, or another rigid tool, than the one shown.
  void set_other_scene(bool is_other) { is_other_scene_ = is_other; }
  void set_other_tool(bool is_other) { is_other_tool_ = is_other; }
  const FrameLog& frames() const { return frames_; }
  const ViewTransformSender& view_transform() const { return sender_; }
  const Interaction& interaction() const { return interaction_; }
  // Whether a surface is touched.
  bool contact() const { return state_ && touches_surface(*state_); }
  // The number of the object touched, in haptics_node's scene; -1: none, or not known.
  std::int32_t touched_object() const { return contact() ? state_->object : -1; }

 private:
  Pose dialled_pose() const { return interaction_.dials().compute_pose(settings_.p_WC, home_WS_); }
  void send_dials(const Dials& before);
  bool may_send_view(std::int64_t now_ns);
  // True: dials were given at the start, and no view has been sent to the hub yet.
  bool keeps_own_dials() const { return settings_.dials != Dials{} && sender_.sent() == 0; }
  HudFacts hud_facts(std::int64_t now_ns) const;
  std::string_view help() const;
  bool has_head_moved(const Screen& where) const;
  ProbeShown probe_shown() const { return make_shown_probe(*state_, settings_.stylus_lean); }

  VisionStepSettings settings_;
  Interaction interaction_;
  ViewTransformSender sender_;
  PictureWatch watch_;
  FrameLog frames_;
  std::optional<ProbeState> state_;
  bool is_connected_ = false;
  bool is_other_scene_ = false;
  bool is_other_tool_ = false;
  std::int32_t held_object_ = -1;
  std::string annotations_;
  bool has_new_annotations_ = false;  // since the last frame
  bool needs_redraw_ = true;
  bool has_new_state_ = false;     // a new state has come since the last frame
  bool has_unseen_state_ = false;  // that state would look the same
  bool culls_;
  bool shows_help_;
  bool shows_depth_cues_;
  std::optional<Pose> recorded_X_WS_;  // none: live
  Pose home_WS_ = Pose::Identity();    // of the scene with all dials at zero; not the identity if a program moved it
  // Since the hub was joined:
  bool has_state_since_joining_ = false;
  bool knows_view_ = false;                     // what view the hub has, or that it has none
  bool has_sent_view_ = false;                  // this node has sent one
  std::optional<std::int64_t> waits_until_ns_;  // end of the wait for the hub's view
  std::string recording_;
  std::string recent_event_;
  std::string teaching_;
  Pose X_WS_shown_ = Pose::Identity();
  CameraView camera_shown_;
  LivePlots plots_;
  ViewerHead head_;
  Head head_shown_;
  bool is_head_at_rest_ = true;
  bool has_new_shape_ = false;
  std::string head_notice_;
  std::string scene_problem_;
  std::int64_t scene_moved_ns_ = 0;
  double detail_progress_ = 1.0;
  double preparing_s_ = 0.0;
  std::int64_t preparing_set_ns_ = 0;  // when it was set
  std::string hud_shown_;
  std::string notice_shown_;
  bool hud_contact_ = false;
  std::int32_t hud_object_ = -1;
  std::int64_t hud_ns_ = 0;
  std::int64_t last_start_ns_ = 0;
};

}  // namespace hapton
