#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"
#include "scene/gltf/accessor.h"

namespace hapton::gltf {

// A primitive's triangles in the frame of its node.
struct Primitive {
  std::vector<Vec3> positions;            // finite; with the morph targets by their weights at rest
  std::vector<Vec3> normals;              // one a position, any length; empty: none, or they cannot be read
  std::vector<Triangle> triangles;        // of positions
  std::vector<std::vector<Vec3>> morphs;  // displacements by morph target, then by position; empty: none, or they cannot be read
  bool has_bad_morphs = false;
  bool has_bad_normals = false;
};

// Lists, strips and fans [3.7.2.1], with KHR_draco_mesh_compression or without. weights: of its morph targets at rest [3.7.2.2]; those that
// are missing are 0. None: points or lines, or no positions. Error: whatever is out of range or not finite; more than max_triangles.
Result<std::optional<Primitive>> read_primitive(const Document& document, const Json& json, std::span<const double> weights,
                                                const std::string& where, std::size_t max_triangles);

}  // namespace hapton::gltf
