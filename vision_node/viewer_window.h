#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "runtime/clock.h"
#include "runtime/stop_signal.h"
#include "vision_node/head_tracker.h"
#include "vision_node/space_head.h"
#include "vision_node/stereo_view.h"
#include "vision_node/teach_builder.h"
#include "vision_node/vision_options.h"
#include "vision_node/vision_step.h"

namespace hapton {

// The window of a session, live or recorded: events, head, stereo, level of detail, screenshots. Threads: the window's. RT: no.
class ViewerWindow {
 public:
  // Returns true if it has used the event; the window then ignores it.
  using TakeEvent = std::function<bool(const WindowEvent&)>;
  // The surface under the pointer, frame W.
  using FindSurface = std::function<std::optional<Vec3>(const WindowEvent&)>;

  // Pre: all outlive this.
  ViewerWindow(StereoView& view, Clock& clock, const VisionOptions& options);

  void set_head_tracker(HeadTracker* tracker) { head_tracker_ = tracker; }
  void set_space_head(SpaceHead* head) { space_head_ = head; }

  // The maker of teaching views; null: no teaching views. Pre: it outlives this.
  void set_teacher(TeachBuilder* teacher) { teacher_ = teacher; }
  // Call it after options and view were given another scene, with the teacher of that scene. is_view_new: see VisionStep::change_scene.
  void change_scene(TeachBuilder* teacher, bool is_view_new);
  // Takes the radius of the probe (unless options give one) and the size of the local set from the method in use.
  void use_setup(const HapticsSetup& setup);

  StereoView& view() { return view_; }
  VisionStep& step() { return step_; }
  const VisionStep& step() const { return step_; }
  VisionStep::Screen where() const { return {view_.screen(), view_.picture_size(), view_.probe_sizes()}; }

  // Handles all events of the window since the last call. Returns the user's requests; window and step() have carried out theirs already.
  UserRequests poll_events(const TakeEvent& take, const FindSurface& find_surface);
  // Before a screenshot: waits for the teaching view that is being made, or if none is, for that of the present probe, and shows it.
  // Returns early if a stop is requested.
  void finish_teaching(const StopSignal& stop);
  // Gives the view all of `shown` except the probe.
  void show(const VisionStep::Shown& shown);
  // If the scene is at rest, draws one more part of it in full detail: a short one, so that a probe that begins to move is drawn at once.
  void refine_scene();

  // Call it right after a draw: renews the texts, so that they fit the probe and force bar drawn. Error: a file that cannot be written.
  Result<void> take_screenshot(const std::filesystem::path& file);
  // Writes hapton_001.png, or the next free number. Returns a line for the picture that says why it could not be written; empty: it was.
  std::string take_numbered_screenshot();

 private:
  void handle_events(const TakeEvent& take, const FindSurface& find_surface);
  void follow_head();
  void check_aspect();
  void change_stereo(const UserRequests& requests);
  void choose_teach(const UserRequests& requests);
  void update_teaching();
  bool wants_teach(const TeachProbe& probe) const;
  std::optional<TeachProbe> find_teach_probe() const;

  StereoView& view_;
  Clock& clock_;
  const VisionOptions& options_;
  VisionStep step_;
  HeadTracker* head_tracker_ = nullptr;
  SpaceHead* space_head_ = nullptr;
  PictureSize checked_size_;
  bool is_aspect_wrong_ = false;
  int screenshots_ = 0;
  double probe_radius_m_ = 0.0;  // of the haptics node
  int set_size_ = 64;
  TeachBuilder* teacher_ = nullptr;
  TeachChoice teach_choice_;
  TeachChoice requested_choice_;
  TeachProbe requested_probe_;  // of the newest request
};

}  // namespace hapton
