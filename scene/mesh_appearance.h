#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// What is read of a mesh file: its colours and textures, for pictures; its normal maps too, for forces. Each includes those before it.
enum class AppearanceReading : std::uint8_t { off, on, with_normals };

// A picture as it is in a mesh file or in a file beside it, PNG or JPEG, not decoded.
struct TextureImage {
  std::string name;
  std::string bytes;
};

// What a texture shows beyond its edges.
enum class TextureWrap : std::uint8_t { repeat, mirror, clamp };

// What a material's alpha means: nothing; visible or not, by a cutoff; how much of what is behind is covered. As in glTF.
enum class AlphaMode : std::uint8_t { opaque, mask, blend };

struct VisualMaterial {
  std::string name;
  std::optional<Eigen::Vector3f> colour = {};           // sRGB, 0 to 1; multiplies the image. None: the file does not say
  std::optional<Eigen::Vector3f> colour_no_image = {};  // sRGB, 0 to 1; in place of both where the image cannot be decoded. None: colour
  std::optional<std::size_t> image = {};                // of MeshAppearance::images
  std::array<TextureWrap, 2> wrap = {};                 // of the image, to the right and down
  // The image's place at a corner is its texcoord, multiplied by this, plus that; both to the right and down.
  Eigen::Vector2f image_scale = Eigen::Vector2f::Ones();
  Eigen::Vector2f image_shift = Eigen::Vector2f::Zero();
  std::optional<std::size_t> normals = {};  // of MeshAppearance::images: its normal map, with the image's texture coordinates
  float normal_scale = 1.0F;                // multiplies the slopes of these
  AlphaMode alpha_mode = AlphaMode::opaque;
  bool is_double_sided = false;  // glTF: its triangles are drawn from behind, too
  float alpha = 1.0F;            // 0 to 1; multiplies those of the image and of the corner
  float alpha_cutoff = 0.5F;     // mask: what has less is not there; above 1, nothing is. Not negative
};

// One corner of one triangle.
struct CornerAppearance {
  Eigen::Vector2f texcoord = Eigen::Vector2f::Zero();    // from the image's upper left corner, right and down; beyond 0 to 1 it wraps
  std::array<std::uint8_t, 3> colour = {255, 255, 255};  // sRGB; multiplies the material's
  std::uint8_t alpha = 255;                              // multiplies the material's
};

struct TriangleAppearance {
  static constexpr std::uint32_t kNoMaterial = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t material = kNoMaterial;  // of MeshAppearance::materials
  bool has_colours = false;              // the corners' colours are the file's
  std::array<CornerAppearance, 3> corners = {};
};

// Appearance of the triangles of a mesh file: colours, textures and transparency. Its lights and bump maps are not read.
struct MeshAppearance {
  std::vector<TextureImage> images;
  std::vector<VisualMaterial> materials;
  std::vector<TriangleAppearance> triangles;  // as many as the mesh has

  // Whether any triangle has a colour or an image.
  bool has_colours_or_images() const;
  // Whether any triangle has an area in the images.
  bool has_texcoords() const;
  // Leaves to materials that no triangle has no image, and to images that no material has then no bytes. All keep their numbers.
  void drop_unused_images();
  // Brings the number of triangles to that of the mesh; new ones have no appearance.
  void resize(std::size_t count) { triangles.resize(count); }
};

// A place in a texture that a file counts from the lower left corner. What is not finite, or so far outside that nothing of it would be
// left in single precision, is the origin.
Eigen::Vector2f texcoord_of(double right, double up);

// glTF's linear light to sRGB, 0 to 1.
float to_srgb(double linear);

}  // namespace hapton
