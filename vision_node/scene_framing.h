#pragma once

#include <string_view>

#include "scene/scene_file.h"
#include "vision_node/stereo_camera.h"
#include "vision_node/vision_options.h"

namespace hapton {

// A sphere around all objects, with its centre in the middle of their common box. Frame S. Radius 0: the scene is one point, or empty.
struct SceneSphere {
  Vec3 p_SO = Vec3::Zero();
  double radius_m = 0.0;
};
SceneSphere bound_scene(const Scene& scene);

// The initial view. A scene in the workspace: the screen's plane goes through the workspace's centre, and the whole scene stays in the
// picture for any dial positions, as does the workspace with its ground; both are in the middle. A scene that lies apart: the scene and the
// workspace, or, if it is too far away for both, the scene alone. A scene that is a speck in the workspace: the scene alone, filling the
// picture. All this is for a viewer at a desk, wherever the head is. With options.screen: what is seen of both through that screen.
// With the scene's [camera]: what the camera sees, with the angles and the size of the picture from the options, if these give them.
Framing frame_scene(const Scene& scene, const VisionOptions& options);

// The flag that decides from where the scene is seen, so that the scene's [camera] does not apply; empty: there is no such flag.
std::string_view find_view_flag(const VisionOptions& options);

}  // namespace hapton
