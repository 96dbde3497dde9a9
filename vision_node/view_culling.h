#pragma once

#include <array>
#include <cstdint>

#include "vision_node/detail_levels.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// Which sides of triangles are drawn.
enum class DrawnSides : std::uint8_t { both, fronts, backs };

// The visibility of a level's clusters for an eye. All in the level's frame U, made once for each eye and picture. RT: no.
class ViewCulling {
 public:
  // clip: U to clip coordinates; p_UE: the eye.
  ViewCulling(const Mat4& clip, const Vec3& p_UE, DrawnSides sides);

  // False if no triangle of the cluster is in the picture; true may be wrong.
  bool may_see(const DetailCluster& cluster) const;

 private:
  std::array<Eigen::Vector4f, 6> planes_;  // normal inwards, of length 1
  Vec3f p_UE_;
  DrawnSides sides_;
};

}  // namespace hapton
