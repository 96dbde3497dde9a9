#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "recording/recording_index.h"
#include "recording/recording_rows.h"
#include "runtime/clock.h"
#include "runtime/stop_signal.h"
#include "vision_node/recorded_carves.h"
#include "vision_node/recorded_marks.h"
#include "vision_node/recorded_objects.h"
#include "vision_node/recorded_surfaces.h"
#include "vision_node/session_control.h"
#include "vision_node/session_player.h"
#include "vision_node/shown_notice.h"
#include "vision_node/time_line.h"
#include "vision_node/viewer_window.h"
#include "vision_node/window_export.h"

namespace hapton {

// Plays a recording in the window: what VisionSession does with a hub, plus a time line. Threads: the window's. RT: no.
class RecordedSession {
 public:
  // Pre: all outlive the session; rows and index are of the same file.
  RecordedSession(StereoView& view, Clock& clock, const VisionOptions& options, const RecordingIndex& index, RecordingRows& rows);

  void set_head_tracker(HeadTracker* tracker) { window_.set_head_tracker(tracker); }
  void set_space_head(SpaceHead* head) { window_.set_space_head(head); }
  void set_teacher(TeachBuilder* teacher) { window_.set_teacher(teacher); }
  // Scene::given_hash of the scene that is shown: a warning appears if the recorded one differs.
  void set_scene(std::uint64_t given_hash) { scene_hash_ = given_hash; }
  // Draws the objects that move. shapes: those of objects that programs deform, from the same file; null: these objects are at rest. Pre:
  // both outlive the session.
  void set_moved_objects(MovedObjects* moved, RecordingShapes* shapes = nullptr);
  // Draws the objects that were carved. Pre: it outlives the session.
  void set_carved_objects(CarvedObjects* carved);
  // Strokes and measures to show, and to export together with what is carved. Pre: set_moved_objects() was called with the objects on which
  // they are; both outlive the session.
  void set_marks(const Scene& scene, RecordedMarks* marks);

  // Runs until the window is closed, --seconds are over, the screenshot of --at or the pictures of --frames are written, or a signal
  // requests a stop; then the picture that is not complete yet is not written. Error: a picture of --screenshot or --frames could not be
  // written, or the file has changed.
  Result<void> run(const StopSignal& stop);

  const VisionStep& step() const { return window_.step(); }
  const SessionPlayer& player() const { return player_; }

 private:
  Result<void> show_moment();
  void show_carved();
  void compare_scene();
  void begin_export();
  bool show_notice(std::string newest);
  std::string attend_window();
  bool wants_picture(std::int64_t now_ns);
  Result<void> draw_if_wanted();
  void draw();
  Result<void> take_moment_screenshot(const StopSignal& stop);
  Result<bool> complete_moment(const StopSignal& stop);
  Result<void> write_frames(const StopSignal& stop);
  double moment_share() const { return find_time_line_share(index_, player_.moment_s()); }

  StereoView& view_;
  Clock& clock_;
  const VisionOptions& options_;
  const RecordingIndex& index_;
  RecordingRows& rows_;
  SessionPlayer player_;
  SessionControl control_;
  ViewerWindow window_;
  TimeLineShown time_line_;
  std::optional<RecordedObjects> objects_;
  std::optional<RecordedSurfaces> surfaces_;
  MovedObjects* moved_ = nullptr;
  std::optional<RecordedCarves> carves_;
  CarvedObjects* carved_ = nullptr;
  const Scene* scene_ = nullptr;
  RecordedMarks* marks_ = nullptr;
  WindowExport export_;
  ShownNotice notice_;
  ScreenshotMoment screenshot_moment_;
  std::uint64_t scene_hash_ = 0;
  bool is_other_scene_ = false;
  double drawn_share_ = -1.0;
  std::int64_t start_ns_ = 0;
  std::int64_t drawn_ns_ = 0;
  bool quit_ = false;
};

}  // namespace hapton
