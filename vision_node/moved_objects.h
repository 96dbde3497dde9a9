#pragma once

#include <vector>

#include "link/messages.h"
#include "scene/scene_file.h"
#include "vision_node/stereo_view.h"

namespace hapton {

// Draws the objects that the stylus picks up where the haptics node has them: one that is held at the stylus, the
// others where they were put down. Threads: the window's. RT: no.
class MovedObjects {
 public:
  // Pre: both outlive this; the view was opened with the scene's objects.
  MovedObjects(StereoView& view, const Scene& scene) : view_(view), scene_(scene), known_(scene.objects.size()) {}

  // True if the picture has changed. A pose of an object that the scene does not have is left out.
  bool take(const ObjectPose& pose);

  // The object that is held; -1: none.
  std::int32_t held() const;

 private:
  StereoView& view_;
  const Scene& scene_;
  std::vector<ObjectPose> known_;  // by object
};

}  // namespace hapton
