#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "core/base/result.h"
#include "runtime/clock.h"
#include "vision_node/head_tracker.h"
#include "vision_node/space_head.h"
#include "vision_node/stereo_view.h"
#include "vision_node/teach_builder.h"
#include "vision_node/vision_options.h"
#include "vision_node/vision_step.h"

namespace hapton {

// What a session does with its window, whether it is live or recorded: events, head, stereo, detail, screenshots. Threads: the window's.
// RT: no.
class ViewerWindow {
 public:
  // True: the event was meant for something else, and is used up.
  using TakeEvent = std::function<bool(const WindowEvent&)>;
  // The surface under the pointer, frame W.
  using FindSurface = std::function<std::optional<Vec3>(const WindowEvent&)>;

  // Pre: all outlive this.
  ViewerWindow(StereoView& view, Clock& clock, const VisionOptions& options);

  void set_head_tracker(HeadTracker* tracker) { head_tracker_ = tracker; }
  void set_space_head(SpaceHead* head) { space_head_ = head; }

  // What makes teaching views; null: there are none. Pre: it outlives this.
  void set_teacher(TeachBuilder* teacher) { teacher_ = teacher; }
  // options and the view have another scene, with a teacher of its own. is_view_new: see VisionStep::change_scene.
  void change_scene(TeachBuilder* teacher, bool is_view_new);
  // The method in use: the radius of the probe, the size of the local set.
  void use_setup(const HapticsSetup& setup);

  StereoView& view() { return view_; }
  VisionStep& step() { return step_; }
  const VisionStep& step() const { return step_; }
  VisionStep::Screen where() const { return {view_.screen(), view_.picture_size(), view_.probe_sizes()}; }

  // All that happened in the window since the last call. Returns the user's requests; those on stereo are done.
  UserRequests attend(const TakeEvent& take, const FindSurface& find_surface);
  // Waits until a teaching view shows the present probe, for a picture that stays.
  void finish_teaching();
  // Gives the view all of it but the probe.
  void show(const VisionStep::Shown& shown);
  // A little at a time, so that a probe that begins to move is drawn at once.
  void refine_scene();

  // Texts, probe and bar of the force are those of the newest state. Error: a file that cannot be written.
  Result<void> take_screenshot(const std::filesystem::path& file);
  // hapton_001.png and so on, the first that does not exist.
  Result<void> take_numbered_screenshot();

 private:
  void handle_events(const TakeEvent& take, const FindSurface& find_surface);
  void follow_head();
  void check_aspect();
  void change_stereo(const UserRequests& requests);
  void choose_teach(const UserRequests& requests);
  void teach();
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
  TeachChoice teach_;
  TeachChoice teach_requested_;
  TeachProbe teach_probe_;  // of the newest request
};

}  // namespace hapton
