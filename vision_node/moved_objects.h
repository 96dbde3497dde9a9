#pragma once

#include <vector>

#include "link/messages.h"
#include "scene/scene_file.h"
#include "vision_node/stereo_view.h"

namespace hapton {

// Draws objects where the haptics node has them: one that the stylus picked up at the stylus, others where they were put down, and those
// that move by keyframes where they were at the time of the sample that is shown. Threads: the window's. RT: no.
class MovedObjects {
 public:
  // Pre: both outlive this; the view was opened with the scene's objects.
  MovedObjects(StereoView& view, const Scene& scene);

  // True if the picture has changed. A pose of an object that the scene does not have is left out.
  bool take(const ObjectPose& pose);

  // Some move by keyframes.
  bool has_motion() const { return has_motion_; }
  // The time of ProbeState: true if one of them is then elsewhere than it is drawn. place_moving() draws them there.
  bool set_time(std::int64_t scene_time_ns);
  void place_moving();
  // By object, at the time set last: X_SO; the identity for what does not move by keyframes.
  const std::vector<Pose>& moving() const { return X_SO_; }

  // The object that is held; -1: none.
  std::int32_t held() const;

 private:
  StereoView& view_;
  const Scene& scene_;
  std::vector<ObjectPose> known_;  // by object
  bool has_motion_ = false;
  std::vector<Pose> X_SO_;
};

}  // namespace hapton
