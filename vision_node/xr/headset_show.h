#pragma once

#include <memory>

#include "vision_node/stereo_view.h"
#include "vision_node/xr/headset.h"
#include "vision_node/xr/workspace_place.h"

namespace hapton {

// Shows the workspace in a headset: joins its runtime, the view that draws, and the place of the workspace in the room. While the headset
// wants no frames, and after it is lost, the view draws for the window alone, in mono. Threads: the window's. RT: no.
class HeadsetShow {
 public:
  // Pre: view outlives this. Error: see Headset::open.
  static Result<std::unique_ptr<HeadsetShow>> open(std::unique_ptr<Headset> headset, StereoView& view, RoomSpace space, const Pose& X_OW);
  ~HeadsetShow();
  HeadsetShow(const HeadsetShow&) = delete;
  HeadsetShow& operator=(const HeadsetShow&) = delete;

  // Once in each turn of the loop, before anything is drawn: handles what the runtime has sent and, while it wants frames, waits until the
  // next is due. True: the view draws for the headset, and show() follows. Logs one line when the headset begins, pauses or is lost.
  bool begin_turn(const Framing& framing);
  // What the view has drawn goes to the headset, and one eye's image to the window.
  void show();

  // The runtime wants the program to end.
  bool has_ended() const { return headset_->has_ended(); }
  // The workspace comes before the viewer again, as he looks now.
  void recentre();
  // The viewer is moved by so much relative to the workspace: right, up, backwards. Metres.
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

// Midway between the eyes, as they are turned. Frame F of both.
Pose find_head(const EyeInFrame& left, const EyeInFrame& right);

}  // namespace hapton
