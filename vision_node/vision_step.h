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
  Dials dials;                // at the start
  double max_rate_hz = 60.0;  // frames a second; 0: no limit
  Quat stylus_lean = Quat::Identity();
  bool always_changing = false;  // draw even when nothing moved: modes that alternate the eyes
  bool cull = true;
  bool help = true;
  bool depth_cues = true;
  std::string stereo;        // the mode's name, for the HUD
  Framing home;              // the initial view
  Vec3 p_SO = Vec3::Zero();  // a sphere around the scene
  double scene_radius_m = 0.0;
  double threshold_px = 0.5;      // smaller motion causes no frame
  std::vector<ObjectName> names;  // of the objects shown
  bool plots = false;
  Head head;                    // at the start
  double ipd_m = kEyeDistance;  // the viewer's own
};

// All decisions of the vision node, without a window, socket or clock. Inputs: messages of the hub and the user's requests; outputs: when
// to draw, what to draw and what to send. Times: any one monotonic clock, ns. RT: no.
class VisionStep {
 public:
  // The present position of the picture in the world.
  struct Screen {
    StereoScreen screen;
    PictureSize picture;
    ProbeSizes sizes;
  };
  // Content of the next frame.
  struct Shown {
    Pose X_WS = Pose::Identity();
    Framing framing;
    std::optional<ProbeShown> probe;  // none before the hub has spoken
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

  // The newest state received. Pre: never older than the one before (newest wins at the caller). received_ns: for plots.
  void receive(const ProbeState& state, std::int64_t received_ns = 0);
  // The hub rejected a view transform of ours: one line in the log for each.
  void receive(const ViewRejected& rejected) { sender_.reject(rejected.revision); }
  // The hub has a view of another vision node, or from before this one joined: the scene is shown as it is felt, and the dials go on from
  // there. After joining, where dials were given at the start, these go to the hub.
  void receive(const ViewTransform& view);
  // The hub was joined, for the first time or again.
  void joined();
  // The hub no longer replies.
  void lost() {
    connected_ = false;
    preparing_s_ = 0.0;
    plots_.forget_force();
  }
  // p_WQ: the surface of the scene seen under the pointer, where the event wants it.
  void handle(const WindowEvent& event, const Screen& where, const std::optional<Vec3>& p_WQ = {});
  // Moves the held hand on towards the pointer. seen: the picture of the scene; null: it goes straight there.
  void lead_hand(const VisibleDepth* seen);
  // Whether handle() would use the surface under the pointer.
  bool wants_surface(const WindowEvent& event) const;
  // Turns the dials of the knob box by these angles, degrees.
  void turn_dials(const Vec3& degrees);
  // Sets the pose of the head. Pre: is_possible().
  void set_head(const Head& head) { head_.track(head); }
  // Moves the head, as keys do. by_m: to the right, up, backwards.
  void move_head(const Vec3& by_m) { head_.move(by_m); }
  // Sets a line on what is wrong with the head's tracker; empty: nothing is.
  void set_head_notice(std::string line) { head_notice_ = std::move(line); }
  // Sets a line on why the scene file as it was saved is not shown; empty: it is.
  void set_scene_problem(std::string line) {
    if (line == scene_problem_) return;
    scene_problem_ = std::move(line);
    request_redraw();
  }
  const std::string& scene_problem() const { return scene_problem_; }
  // The next frame must be drawn whether or not something moved (the window was uncovered or resized).
  void request_redraw() { needs_redraw_ = true; }
  // Another scene is shown. home: the view that it begins with; the viewer's own turns, pans and zoom stay unless is_view_new.
  void change_scene(const Framing& home, const Vec3& p_SO, double radius_m, std::vector<ObjectName> names, bool is_view_new);
  // The scene has another shape: drawn as it is while it moves, and in full detail when it has kept that for a while.
  void reshape_scene() { needs_redraw_ = has_new_shape_ = true; }

  UserRequests take_requests();
  // The mode of stereo is another one from now on.
  void set_stereo(std::string_view name, bool always_changing);
  // haptics_node has been building its scene for this long; 0: it is done. Counts until haptics_node has been silent for 3 s.
  void set_preparing(double seconds, std::int64_t now_ns) {
    preparing_s_ = seconds;
    preparing_ns_ = now_ns;
  }
  void set_detail_progress(double progress) { detail_progress_ = progress; }

  // The next message to send; call until empty: view transform, hand target.
  std::optional<Message> take_message(std::int64_t now_ns);

  // True if the present picture is outdated, and the rate allows another frame.
  bool wants_picture(std::int64_t now_ns, const Screen& where);
  // Whether the rate allows a frame now.
  bool may_draw(std::int64_t now_ns) const;
  // What is to be drawn. The numbers of its texts are renewed ten times a second, so that they can be read.
  Shown compose(std::int64_t now_ns);
  // The texts of the newest state, for a picture that stays; valid until the next call or compose().
  Texts compose_texts(std::int64_t now_ns);
  // The newest probe, for a frame that is being drawn.
  std::optional<ProbeShown> newest_probe() const;
  // Nothing but the probe has moved for long enough that the scene is worth drawing in full detail.
  bool is_scene_at_rest(std::int64_t now_ns) const;
  // The frame of the last compose() is in the window. Returns its acknowledgement for the hub.
  std::optional<FrameAck> end_frame(std::int64_t start_ns, std::int64_t end_ns, const Screen& where);
  // Records the age of that frame's probe when it was in the window.
  void record_motion(std::int64_t motion_to_photon_ns, std::int64_t now_ns) {
    frames_.record_motion_to_photon(motion_to_photon_ns);
    plots_.record_motion_to_photon(motion_to_photon_ns, now_ns);
  }
  // The acknowledgement of a state that wants_picture() found to look the same; once for each.
  std::optional<FrameAck> take_unseen();

  // The pose of the scene that the forces of that revision were computed with; the newest where that is not known.
  Pose find_scene_pose(std::uint32_t view_revision) const { return sender_.find_pose(view_revision).value_or(scene_pose()); }
  const Vec3& workspace_centre() const { return settings_.p_WC; }
  // What is drawn and measured has changed; its line for the picture's corner. The scene and the other numbers have not.
  void set_annotations(std::string line) {
    annotations_ = std::move(line);
    is_annotated_ = true;
  }
  Pose scene_pose() const { return recorded_X_WS_ ? *recorded_X_WS_ : dialled_pose(); }
  // What is shown is recorded, and the static scene had this pose: the dials mean nothing. line, happened: see HudFacts.
  void set_recording(const Pose& X_WS, std::string line, std::string happened) {
    recorded_X_WS_ = X_WS;
    recording_ = std::move(line);
    happened_ = std::move(happened);
  }
  // What has just happened, see HudFacts.
  void set_happened(std::string line) {
    happened_ = std::move(line);
    request_redraw();
  }
  const std::string& happened() const { return happened_; }
  // The line of a teaching view, see HudFacts; it has another picture.
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
  // Whether haptics_node has another scene than the one shown.
  void set_other_scene(bool is_other) { is_other_scene_ = is_other; }
  void set_other_tool(bool is_other) { is_other_tool_ = is_other; }
  const FrameLog& frames() const { return frames_; }
  const ViewTransformSender& view_transform() const { return sender_; }
  const Interaction& interaction() const { return interaction_; }
  // A surface is touched.
  bool contact() const { return state_ && touches_surface(*state_); }
  // The number of the object touched, in haptics_node's scene; -1: none, or not known.
  std::int32_t touched_object() const { return contact() ? state_->object : -1; }

 private:
  Pose dialled_pose() const { return interaction_.dials().compute_pose(settings_.p_WC, home_WS_); }
  void send_dials(const Dials& before);
  bool may_send_view(std::int64_t now_ns);
  // Those that were given at the start go to the hub once.
  bool keeps_own_dials() const { return settings_.dials != Dials{} && sender_.sent() == 0; }
  HudFacts hud_facts(std::int64_t now_ns) const;
  std::string_view help() const;
  bool has_head_moved(const Screen& where) const;
  ProbeShown probe_shown() const { return show_probe(*state_, settings_.stylus_lean); }

  VisionStepSettings settings_;
  Interaction interaction_;
  ViewTransformSender sender_;
  PictureWatch watch_;
  FrameLog frames_;
  std::optional<ProbeState> state_;
  bool connected_ = false;
  bool is_other_scene_ = false;
  bool is_other_tool_ = false;
  std::int32_t held_object_ = -1;
  std::string annotations_;
  bool is_annotated_ = false;  // since the last frame
  bool needs_redraw_ = true;
  bool moved_ = false;   // a new state has come since the last frame
  bool unseen_ = false;  // and would look the same
  bool cull_;
  bool help_;
  bool depth_cues_;
  std::optional<Pose> recorded_X_WS_;  // none: live
  Pose home_WS_ = Pose::Identity();    // of the scene at dials zero: not the identity where a program has moved it
  // Since the hub was joined:
  bool has_state_since_joining_ = false;
  bool knows_view_ = false;                     // the view that the hub has, or that it has none
  bool has_sent_view_ = false;                  // this node
  std::optional<std::int64_t> waits_until_ns_;  // for the view that the hub has
  std::string recording_;
  std::string happened_;
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
  std::int64_t preparing_ns_ = 0;  // when it was set
  std::string hud_shown_;
  std::string notice_shown_;
  bool hud_contact_ = false;
  std::int32_t hud_object_ = -1;
  std::int64_t hud_ns_ = 0;
  std::int64_t last_start_ns_ = 0;
};

}  // namespace hapton
