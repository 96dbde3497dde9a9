#pragma once

#include <string_view>

#include "scene/scene_file.h"
#include "vision_node/stereo_camera.h"
#include "vision_node/vision_options.h"

namespace hapton {

// A sphere around all objects: round the middle of their box. Frame S. Radius 0: the scene is one point, or none.
struct SceneSphere {
  Vec3 p_SO = Vec3::Zero();
  double radius_m = 0.0;
};
SceneSphere bound_scene(const Scene& scene);

// The initial view. A scene in the workspace: the screen's plane goes through the workspace's centre, and the whole scene stays in the
// picture for any dial positions, as does the workspace with its ground; both are in the middle. One that lies apart: the scene and the
// workspace, or, if it is too far away for both, the scene alone. A speck: the scene alone, filling the picture. "In the picture" is meant
// for a viewer at a desk, wherever the head is. With options.screen: what is seen of scene and workspace through that screen.
// With the scene's [camera]: what it sees, with the angles and the size of the picture that options give in its place.
Framing frame_scene(const Scene& scene, const VisionOptions& options);

// The flag that says from where the scene is seen, so that its [camera] does not apply; empty: none does.
std::string_view find_view_flag(const VisionOptions& options);

}  // namespace hapton
