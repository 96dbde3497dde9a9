#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"
#include "scene/gltf/accessor.h"

namespace hapton::gltf {

// What a compressed primitive says of its vertices beside positions and normals: texture coordinates and colours, by attribute.
using UnfoldedAttributes = std::map<std::string, Accessor>;

// A primitive's triangles in the frame of its node.
struct Primitive {
  std::vector<Vec3> positions;            // finite; with the morph targets by their weights at rest
  std::vector<Vec3> normals;              // one a position, any length; empty: none, or they cannot be read
  std::vector<Triangle> triangles;        // of positions
  std::vector<std::vector<Vec3>> morphs;  // displacements by morph target, then by position; empty: none, or they cannot be read
  bool has_bad_morphs = false;
  bool has_bad_normals = false;
  std::optional<UnfoldedAttributes> unfolded = {};  // none: it is not compressed with Draco
};

// Of the morph targets of a file, which may have so many triangles: as many as these have corners. More is rejected.
constexpr std::size_t most_morph_displacements(std::size_t max_triangles) { return 3 * max_triangles; }

// Lists, strips and fans [3.7.2.1], with KHR_draco_mesh_compression or without. weights: of its morph targets at rest [3.7.2.2]; those that
// are missing are 0. None: points or lines, or no positions. Error: whatever is out of range or not finite; more than max_triangles, or
// than most_morph_displacements.
Result<std::optional<Primitive>> read_primitive(const Document& document, const Json& json, std::span<const double> weights,
                                                const std::string& where, std::size_t max_triangles);

// Whether the primitive that was read from this JSON has that attribute for its vertices, such as TEXCOORD_0.
bool has_attribute(const Json& json, const Primitive& primitive, const std::string& attribute);

// That attribute, one item for each vertex: from an accessor, or from what was unfolded. Error: as read_accessor; another number of items.
Result<Accessor> read_attribute(const Document& document, const Json& json, const Primitive& primitive, const std::string& attribute,
                                const std::string& where, std::string_view type, std::size_t components);

}  // namespace hapton::gltf
