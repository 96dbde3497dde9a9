#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "vision_node/detail_levels.h"

namespace hapton {

// A corner of triangles. With flat shading the last corner of a triangle determines its plane.
struct FlatVertex {
  Vec3f position = Vec3f::Zero();  // frame U
  std::uint32_t normal = 0;        // normal of the triangles whose last corner it is: x, y, z in ten bits each, signed, packed as in OpenGL
};

// A level of detail as sent to the graphics driver: the last corner of each triangle has the triangle's normal. Pixels then need no
// normals of their own, which halves the time of a frame drawn in software.
struct FlatLevel {
  std::vector<FlatVertex> vertices;
  std::vector<VertexPaint> paints;  // one for each vertex; empty: the mesh has one colour
  std::vector<std::uint32_t> indices;
  std::vector<DetailCluster> clusters;  // as in the DetailLevel: the triangles keep their order
  double error = 0.0;
  std::size_t triangles() const { return indices.size() / 3; }
};

// Makes a flat level: the same triangles in the same order, with corners rotated and vertices duplicated where necessary. RT: set-up only.
FlatLevel make_flat(const DetailLevel& level);

std::uint32_t pack_normal(const Vec3f& unit);
Vec3f unpack_normal(std::uint32_t packed);

}  // namespace hapton
