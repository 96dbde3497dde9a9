#pragma once

#include <cstdint>
#include <vector>

#include "core/math/types.h"
#include "scene/gltf/accessor.h"
#include "scene/gltf/primitive.h"
#include "scene/raw_mesh.h"

namespace hapton::gltf {

// Where a material's texture finds its coordinates [3.9.2], with KHR_texture_transform.
struct TexturePlace {
  std::size_t set = 0;  // TEXCOORD_set
  Eigen::Affine2f place = Eigen::Affine2f::Identity();
};

// Of a textureInfo. Error: a number that is not valid.
Result<TexturePlace> read_texture_place(const Json& info, const std::string& where);

// The file's materials become those of raw.appearance: base colour and its texture (find_base_colour), alpha mode and
// cutoff, the wrap modes of the texture's sampler; if they are wanted, normal maps. Returns where each one's texture finds its
// coordinates. What cannot be read is a note, never an error: the shape is what matters.
std::vector<TexturePlace> read_materials(const Document& document, const std::filesystem::path& folder, AppearanceReading appearance,
                                         RawMesh& raw);

// Colours (COLOR_0) and texture coordinates of the vertices of a primitive, which was read from this JSON. Empty:
// nothing is said of them.
struct VertexAppearances {
  std::uint32_t material = TriangleAppearance::kNoMaterial;
  bool has_colours = false;
  std::vector<CornerAppearance> vertices;
};
VertexAppearances read_vertex_appearances(const Document& document, const Json& json, const Primitive& primitive,
                                          const std::vector<TexturePlace>& places, const std::string& where);

}  // namespace hapton::gltf
