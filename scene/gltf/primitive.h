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

// Texture coordinates and colours of the vertices of a compressed primitive, decompressed, by name of the attribute (TEXCOORD_0).
using UnfoldedAttributes = std::map<std::string, Accessor>;

// A primitive's triangles in the frame of its node.
struct Primitive {
  std::vector<Vec3> positions;            // finite; displaced by the morph targets with their weights at rest
  std::vector<Vec3> normals;              // one for each position, of any length; empty: none, or they cannot be read
  std::vector<Triangle> triangles;        // indices into positions
  std::vector<std::vector<Vec3>> morphs;  // displacements by morph target, then by position; empty: none, or they cannot be read
  bool has_bad_morphs = false;
  bool has_bad_normals = false;
  std::optional<UnfoldedAttributes> unfolded = {};  // none: the primitive is not compressed with Draco
};

// The largest number of morph displacements in a file that may have max_triangles triangles: one for each corner. More are rejected.
constexpr std::size_t most_morph_displacements(std::size_t max_triangles) { return 3 * max_triangles; }

// Reads triangle lists, strips and fans [3.7.2.1], with or without KHR_draco_mesh_compression. weights: those of the primitive's morph
// targets at rest [3.7.2.2]; missing ones are 0. None: points or lines, or no positions. Error: whatever is out of range, a position that
// is not finite, more than max_triangles, or more morph displacements than most_morph_displacements.
Result<std::optional<Primitive>> read_primitive(const Document& document, const Json& json, std::span<const double> weights,
                                                const std::string& where, std::size_t max_triangles);

// Whether the vertices of a primitive, which was read from `json`, have this attribute, such as TEXCOORD_0.
bool has_attribute(const Json& json, const Primitive& primitive, const std::string& attribute);

// Reads such an attribute, one item for each vertex. Error: as read_accessor; it is missing, or has another type or number of items.
Result<Accessor> read_attribute(const Document& document, const Json& json, const Primitive& primitive, const std::string& attribute,
                                const std::string& where, std::string_view type, std::size_t components);

}  // namespace hapton::gltf
