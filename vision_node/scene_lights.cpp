#include "vision_node/scene_lights.h"

#include <fmt/format.h>

namespace hapton {

// The shaders compute in the eye's frame; their unit of length is the distance of the eyes from the screen.
void set_lights(const GlProgram& program, const std::vector<SceneLight>& lights, const StereoScreen& screen, Eye eye) {
  if (lights.empty()) return program.set("light", screen.light_V);
  const Mat4 X_EW = compute_view_matrix(screen, eye);
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const SceneLight& light = lights[i];
    const Vec3 turned = X_EW.topLeftCorner<3, 3>() * light.towards_or_p_W;
    const Vec3 at = light.has_position ? Vec3((turned + X_EW.topRightCorner<3, 1>()) / screen.distance_m) : turned;
    program.set(fmt::format("light_at[{}]", i).c_str(), at);
    program.set(fmt::format("light_has_position[{}]", i).c_str(), light.has_position ? 1.0 : 0.0);
    program.set(fmt::format("light_colours[{}]", i).c_str(), light.colour);
  }
}

}  // namespace hapton
