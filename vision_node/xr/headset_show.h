#pragma once

#include <memory>

#include "vision_node/stereo_view.h"
#include "vision_node/xr/headset.h"
#include "vision_node/xr/workspace_place.h"

namespace hapton {

// Shows the workspace in a headset: connects the headset, the view that draws, and the place of the workspace in the room. While the
// runtime requests no frames, and after the headset is lost, the view draws for the window alone, in mono. Threads: the window's. RT: no.
class HeadsetShow {
 public:
  // X_OW: pose of the workspace relative to the viewer, see WorkspacePlace. Pre: view outlives this. Error: see Headset::open.
  static Result<std::unique_ptr<HeadsetShow>> open(std::unique_ptr<Headset> headset, StereoView& view, RoomSpace space, const Pose& X_OW);
  ~HeadsetShow();
  HeadsetShow(const HeadsetShow&) = delete;
  HeadsetShow& operator=(const HeadsetShow&) = delete;

  // Call it once in each turn of the loop, before anything is drawn: handles the events of the runtime and, while it requests frames, waits
  // until the next one is due. True: draw for the headset, then call show(). Logs a line when the headset begins, pauses, ends or is lost.
  bool begin_turn(const Framing& framing);
  // Passes the images that the view has drawn to the headset, and the left one to the window.
  void show();

  // Whether the runtime has ended the session, so that the program should end.
  bool has_ended() const { return headset_->has_ended(); }
  // Places the workspace before the viewer again, in the direction in which the viewer looks now.
  void recentre();
  // Moves the viewer relative to the workspace. by_m: to the right, up, backwards; metres.
  void move_viewer(const Vec3& by_m) { place_.move_viewer(by_m); }

 private:
  HeadsetShow(std::unique_ptr<Headset> headset, StereoView& view, const WorkspacePlace& place)
      : headset_(std::move(headset)), view_(view), place_(place) {}
  void aim(const Framing& framing);
  void set_shown(bool is_shown);
  void report_loss();

  std::unique_ptr<Headset> headset_;
  StereoView& view_;
  WorkspacePlace place_;
  bool is_shown_ = false;
  bool is_loss_reported_ = false;
};

// The pose of the head: midway between the eyes in position and orientation. Frame: F of the two eyes.
Pose find_head(const EyeInFrame& left, const EyeInFrame& right);

}  // namespace hapton
