#pragma once

#include <optional>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// From where a scene is seen at first. Frame W: as touched, after fit_m, whatever the dials do. Metres.
struct SceneCamera {
  Vec3 p_WE = Vec3::Zero();      // between the eyes; elsewhere than p_WC
  Vec3 p_WC = Vec3::Zero();      // in the middle of the picture, without parallax
  Vec3 up = Vec3::UnitY();       // upwards in the picture; not along the line of sight
  double view_angle_deg = 30.0;  // of the picture's smaller side

  friend bool operator==(const SceneCamera&, const SceneCamera&) = default;
};

// A light that stands still in the world. Frame W, metres.
struct SceneLight {
  bool has_position = false;
  Vec3 towards_or_p_W = Vec3::UnitY();  // towards the light, of length 1; or where it is
  Vec3 colour = Vec3::Ones();           // sRGB, 0..1, times the intensity

  friend bool operator==(const SceneLight&, const SceneLight&) = default;
};

// How vision nodes show a scene. Nothing of it is felt.
struct SceneView {
  static constexpr std::size_t kMaxLights = 4;

  std::optional<SceneCamera> camera = {};  // none: vision_node finds a view
  std::vector<SceneLight> lights = {};     // empty: one that goes with the viewer
};

}  // namespace hapton
