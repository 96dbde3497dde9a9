#pragma once

#include "core/base/result.h"
#include "link/hub_client.h"
#include "runtime/clock.h"
#include "runtime/stop_signal.h"
#include "scene/scene_file.h"
#include "vision_node/annotator.h"
#include "vision_node/carved_objects.h"
#include "vision_node/live_scene.h"
#include "vision_node/marker_key.h"
#include "vision_node/moved_objects.h"
#include "vision_node/other_hand.h"
#include "vision_node/scene_framing.h"
#include "vision_node/shown_notice.h"
#include "vision_node/space_head.h"
#include "vision_node/space_knobs.h"
#include "vision_node/state_acks.h"
#include "vision_node/stereo_view.h"
#include "vision_node/viewer_window.h"
#include "vision_node/vision_options.h"
#include "vision_node/vision_step.h"
#include "vision_node/xr/headset_show.h"

namespace hapton {

// Opens the window for the scene as options say, and sets in options what follows from scene and renderer. Error: see StereoView::open.
Result<std::unique_ptr<StereoView>> open_view(const Scene& scene, VisionOptions& options);

// The limit of frames a second: the requested one; otherwise 60, or 30 if the CPU draws, because the force may be computed on it as well.
double choose_rate_limit(const VisionOptions& options, std::string_view renderer_name);

// One vision node at work: hub, window and VisionStep joined in one loop. RT: no.
class VisionSession {
 public:
  VisionSession(StereoView& view, HubClient& hub, Clock& clock, const VisionOptions& options);

  // What turns the dials besides keys and mouse. Pre: it outlives the session.
  void set_knobs(SpaceKnobs* knobs) { knobs_ = knobs; }

  // The tracker of the viewer's head. Pre: it outlives the session.
  void set_head_tracker(HeadTracker* tracker) { window_.set_head_tracker(tracker); }

  // What moves the viewer's head besides keys. Pre: it outlives the session.
  void set_space_head(SpaceHead* head) { window_.set_space_head(head); }

  // What makes teaching views. Pre: it outlives the session.
  void set_teacher(TeachBuilder* teacher) { window_.set_teacher(teacher); }

  // The headset that gets the pictures as well as the window. Pre: it outlives the session.
  void set_headset(HeadsetShow* headset) { headset_ = headset; }

  // Another hand to show. Pre: it outlives the session.
  void set_other_hand(OtherHand* other) { other_hand_ = other; }

  // The hash of the scene that is shown (Scene::given_hash), to be compared with that of haptics_node's scene.
  void set_scene(std::uint64_t given_hash) { scene_hash_ = given_hash; }

  // What draws the objects that the stylus moves. Pre: it outlives the session.
  void set_moved_objects(MovedObjects* moved) { moved_ = moved; }

  // What draws the objects that the stylus carves. Pre: it outlives the session.
  void set_carved_objects(CarvedObjects* carved) { carved_ = carved; }

  // In place of set_scene, set_teacher, set_moved_objects and set_carved_objects: a scene that may be replaced while the session runs. Pre:
  // it outlives the session.
  void set_live_scene(LiveScene* scene);

  // SceneTool::given_hash of the rigid tool that is drawn; without this call a probe is drawn.
  void set_tool(std::uint64_t given_hash) { tool_hash_ = given_hash; }

  // What makes strokes and measures. Pre: it outlives the session.
  void set_annotator(Annotator* annotator) { annotator_ = annotator; }

  // Runs until the window or headset is closed, --seconds are over, a signal requests the stop, or the picture of --screenshot cannot be
  // written; then finishes the annotator. Error: that picture or the annotations were not written; if both, the latter is only in the log.
  Result<void> run(const StopSignal& stop);

  const VisionStep& step() const { return step_; }

 private:
  Result<void> show_until_end(const StopSignal& stop);
  Result<void> take_last_screenshot();
  void note_join();
  void receive_from_hub(std::int64_t deadline_ns);
  void take_states(std::int64_t deadline_ns);
  void take_state(const ProbeState& state);
  void take_pose(const ObjectPose& pose);
  void annotate(const UserRequests& requests);
  std::optional<Vec3> find_surface(const WindowEvent& event);
  bool begin_headset_turn();
  void move_in_headset(const UserRequests& requests);
  void lead_hand();
  void take_scene(const SceneFacts& haptic_scene);
  void follow_scene();
  void compare_scene();
  void compare_tool(std::uint64_t held_hash);
  void attend_window();
  void show_notice(std::string newest);
  void send_pending();
  Result<void> draw_if_wanted();
  void draw();
  bool other_wants_picture(std::int64_t now_ns);
  void report_frame(std::int64_t begin_ns, std::int64_t end_ns);
  void acknowledge(FrameAck ack, std::int64_t end_ns);

  StereoView& view_;
  SpaceKnobs* knobs_ = nullptr;
  HeadsetShow* headset_ = nullptr;
  bool is_for_headset_ = false;  // the next frame is drawn for the headset
  MovedObjects* moved_ = nullptr;
  CarvedObjects* carved_ = nullptr;
  OtherHand* other_hand_ = nullptr;
  Annotator* annotator_ = nullptr;
  std::uint64_t shown_annotations_revision_ = 0;
  ShownNotice notice_;
  HubClient& hub_;
  Clock& clock_;
  const VisionOptions& options_;
  ViewerWindow window_;
  VisionStep& step_;  // the window's
  MarkerKey marker_key_;
  ScreenshotMoment screenshot_moment_;
  std::uint64_t scene_hash_ = 0;
  std::uint64_t haptic_hash_ = 0;          // as haptics_node announced it last; 0: not announced yet
  std::int64_t other_scene_since_ns_ = 0;  // since when haptics_node has another scene; 0: it has not
  bool is_other_scene_ = false;            // as last reported to the user
  std::uint64_t tool_hash_ = SceneFacts::kNoTool;
  bool is_other_tool_ = false;  // as last reported to the user
  LiveScene* live_scene_ = nullptr;
  std::int64_t next_scene_facts_ns_ = 0;  // when the facts of our scene are sent to the hub again
  std::uint64_t joins_ = 0;
  bool was_joined_ = false;
  bool quit_ = false;
  bool is_absence_reported_ = false;
  std::int64_t start_ns_ = 0;
  std::int64_t received_ns_ = 0;  // arrival of the state that is drawn next
  StateAcks acks_;
};

// Draws frames with turning dials: until all levels of detail are made, then `frames`, then as many with a moving probe. Returns the rates.
std::string run_bench(StereoView& view, Clock& clock, int frames, bool with_plots = false);

}  // namespace hapton
