#pragma once

#include <vector>

#include "scene/scene_view.h"
#include "vision_node/gl_program.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// Sets the lights in a program of lit triangles (scene_shaders.h, made for as many lights): those of the scene, or, if it has none, the one
// that moves with the viewer. Pre: the program is in use. Threads: the window's. RT: no.
void set_lights(const GlProgram& program, const std::vector<SceneLight>& lights, const StereoScreen& screen, Eye eye);

}  // namespace hapton
