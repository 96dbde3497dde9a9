#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton::gltf {

// The attributes that are wanted of a Draco mesh, by their unique ids; and the most triangles that it may have.
struct DracoRequest {
  std::uint32_t position = 0;
  std::optional<std::uint32_t> normal = {};
  std::size_t max_triangles = 0;
  std::vector<std::uint32_t> others = {};
};

// The values of one attribute, not converted.
struct DracoValues {
  std::size_t components = 0;
  std::size_t component_type = 0;  // as in an accessor [3.6.2.2]
  std::string bytes;               // one item for each position, without gaps; empty: there is none of that id, or it cannot be read
};

struct DracoMesh {
  std::vector<Eigen::Vector3f> positions;  // as the file has them, normalised integers converted; may hold values that are not finite
  std::vector<Eigen::Vector3f> normals;    // one for each position; empty: there are none, or they cannot be read
  std::vector<std::uint32_t> corners;      // three for each triangle, each below the number of positions
  std::vector<DracoValues> others;         // the `others` of the request, in its order
};

// Decompresses a Draco bitstream of version 2.2, as KHR_draco_mesh_compression has it.
// Error: broken data; no positions with three components; more triangles, points or attributes than wanted, or than so many bytes can hold
// (found before memory is taken for them); a build without Draco. RT: set-up only.
Result<DracoMesh> decode_draco(std::string_view bytes, const DracoRequest& request, const std::string& where);

}  // namespace hapton::gltf
