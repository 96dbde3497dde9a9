#pragma once

#include <array>
#include <cstdint>

#include "vision_node/detail_levels.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// Which sides of triangles are drawn.
enum class DrawnSides : std::uint8_t { both, fronts, backs };

// Decides which clusters of a level an eye may see. Make one for each eye and picture. Frame: U of the level. RT: no.
class ViewCulling {
 public:
  // to_clip: from U to clip coordinates; p_UE: position of the eye.
  ViewCulling(const Mat4& to_clip, const Vec3& p_UE, DrawnSides sides);

  // False: no triangle of the cluster is seen in the picture. True: some may be seen, but need not be.
  bool may_see(const DetailCluster& cluster) const;

 private:
  std::array<Eigen::Vector4f, 6> planes_;  // of the frustum, with normals inwards, of length 1
  Vec3f p_UE_;
  DrawnSides sides_;
};

}  // namespace hapton
