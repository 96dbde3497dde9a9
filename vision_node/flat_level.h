#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "vision_node/detail_levels.h"

namespace hapton {

// A corner of triangles. Flat shading takes what the last corner of a triangle says for all of it.
struct FlatVertex {
  Vec3f position = Vec3f::Zero();  // frame U
  std::uint32_t normal = 0;        // of the triangles whose last corner this is: x, y, z in ten bits each, signed, as OpenGL packs them
};

// A level of detail as it is sent to the graphics driver: every triangle's last corner is of its plane. A picture's pixels then need no
// normal of their own, which halves the time of a picture drawn in software.
struct FlatLevel {
  std::vector<FlatVertex> vertices;
  std::vector<std::uint32_t> indices;
  std::vector<DetailCluster> clusters;  // those of the level
  double error = 0.0;
  std::size_t triangles() const { return indices.size() / 3; }
};

// The same triangles in the same order, their corners turned round and doubled where that is needed. RT: set-up only.
FlatLevel make_flat(const DetailLevel& level);

std::uint32_t pack_normal(const Vec3f& unit);
Vec3f unpack_normal(std::uint32_t packed);

}  // namespace hapton
