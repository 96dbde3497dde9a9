#pragma once

#include <cstdint>
#include <vector>

#include "core/math/types.h"
#include "scene/gltf/accessor.h"
#include "scene/gltf/primitive.h"
#include "scene/raw_mesh.h"

namespace hapton::gltf {

// Where a material's texture gets its coordinates from [3.9.2], with KHR_texture_transform.
struct TexturePlace {
  std::size_t set = 0;                                  // number of the attribute, TEXCOORD_set
  Eigen::Affine2f place = Eigen::Affine2f::Identity();  // from the values of that attribute to coordinates in the image
};

// Reads the place of a texture from its textureInfo. Error: a number that is not valid.
Result<TexturePlace> read_texture_place(const Json& info, const std::string& where);

// Adds the file's materials to raw.appearance: base colour and its texture (find_base_colour), alpha mode and cutoff, the wrap modes of the
// texture's sampler; also normal maps if `appearance` asks for them. Returns the texture place of each material, in their order. What
// cannot be read becomes a note in `raw`, never an error, because the shape can be used without it.
std::vector<TexturePlace> read_materials(const Document& document, const std::filesystem::path& folder, AppearanceReading appearance,
                                         RawMesh& raw);

// Material, colours (COLOR_0) and texture coordinates of the vertices of a primitive, which was read from the same `json`. `vertices` is
// empty if the primitive has neither a material nor colours. places: as read_materials returned them.
struct VertexAppearances {
  std::uint32_t material = TriangleAppearance::kNoMaterial;
  bool has_colours = false;
  std::vector<CornerAppearance> vertices;
};
VertexAppearances read_vertex_appearances(const Document& document, const Json& json, const Primitive& primitive,
                                          const std::vector<TexturePlace>& places, const std::string& where);

}  // namespace hapton::gltf
