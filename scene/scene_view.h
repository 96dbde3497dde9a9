#pragma once

#include <optional>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// From where a scene is seen at first. Frame W: of the scene as it is touched, after fit_m, however the dials are turned. Metres.
struct SceneCamera {
  Vec3 p_WE = Vec3::Zero();      // the point between the eyes; not equal to p_WC
  Vec3 p_WC = Vec3::Zero();      // the point at the centre of the picture, without parallax
  Vec3 up = Vec3::UnitY();       // upwards in the picture; not parallel to the line of sight
  double view_angle_deg = 30.0;  // angle across the shorter side of the picture

  friend bool operator==(const SceneCamera&, const SceneCamera&) = default;
};

// A light that does not move in the world. Frame W, metres.
struct SceneLight {
  bool has_position = false;
  Vec3 towards_or_p_W = Vec3::UnitY();  // has_position: position of the light; otherwise the direction towards it, of length 1
  Vec3 colour = Vec3::Ones();           // sRGB, 0..1, times the intensity

  friend bool operator==(const SceneLight&, const SceneLight&) = default;
};

// How vision nodes show a scene. It has no effect on forces.
struct SceneView {
  static constexpr std::size_t kMaxLights = 4;

  std::optional<SceneCamera> camera = {};  // none: vision_node chooses a view
  std::vector<SceneLight> lights = {};     // empty: one light that moves with the viewer
};

}  // namespace hapton
