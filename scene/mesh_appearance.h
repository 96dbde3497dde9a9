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

// What is read from a mesh file: no appearance; colours and textures, for pictures; normal maps as well, for forces.
enum class AppearanceReading : std::uint8_t { off, on, with_normals };

// A picture as it is in a mesh file or in a file beside it, PNG or JPEG, not decoded.
struct TextureImage {
  std::string name;
  std::string bytes;
};

// What a texture shows beyond its edges.
enum class TextureWrap : std::uint8_t { repeat, mirror, clamp };

// What a material's alpha means, as in glTF: nothing; visible or invisible, by a cutoff; the share of the background that is covered.
enum class AlphaMode : std::uint8_t { opaque, mask, blend };

struct VisualMaterial {
  std::string name;
  std::optional<Eigen::Vector3f> colour = {};           // sRGB, 0 to 1; multiplies the image. None: the file gives no colour
  std::optional<Eigen::Vector3f> colour_no_image = {};  // sRGB, 0 to 1; replaces both if the image cannot be decoded. None: `colour`
  std::optional<std::size_t> image = {};                // index in MeshAppearance::images
  std::array<TextureWrap, 2> wrap = {};                 // wrapping of the image, to the right and down
  // Coordinates of a corner in the image: image_scale times its texcoord, plus image_shift; both count to the right and down.
  Eigen::Vector2f image_scale = Eigen::Vector2f::Ones();
  Eigen::Vector2f image_shift = Eigen::Vector2f::Zero();
  std::optional<std::size_t> normals = {};  // the normal map's index in MeshAppearance::images; it has the texture coordinates of `image`
  float normal_scale = 1.0F;                // factor of the slopes of the normal map
  AlphaMode alpha_mode = AlphaMode::opaque;
  bool is_double_sided = false;  // glTF: its triangles are drawn from behind as well
  float alpha = 1.0F;            // 0 to 1; multiplies the alpha of the image and of the corner
  float alpha_cutoff = 0.5F;     // mask: a smaller alpha is invisible; above 1, everything is. Not negative
};

// One corner of one triangle.
struct CornerAppearance {
  Eigen::Vector2f texcoord = Eigen::Vector2f::Zero();  // from the image's upper left corner, to the right and down; outside 0 to 1 it wraps
  std::array<std::uint8_t, 3> colour = {255, 255, 255};  // sRGB; multiplies the colour of the material
  std::uint8_t alpha = 255;                              // multiplies the alpha of the material
};

struct TriangleAppearance {
  static constexpr std::uint32_t kNoMaterial = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t material = kNoMaterial;  // index in MeshAppearance::materials
  bool has_colours = false;              // the corners' colours are those of the file
  std::array<CornerAppearance, 3> corners = {};
};

// Appearance of the triangles of a mesh file: colours, textures and transparency. Lights and images of heights are not read.
struct MeshAppearance {
  std::vector<TextureImage> images;
  std::vector<VisualMaterial> materials;
  std::vector<TriangleAppearance> triangles;  // as many as the mesh has, or none

  // Whether any triangle has a colour, an image or transparency.
  bool has_colours_or_images() const;
  // Whether any triangle has texture coordinates that span an area.
  bool has_texcoords() const;
  // Removes the images of materials that no triangle has, and the bytes of images that no material has after that. Indices stay valid.
  void drop_unused_images();
  // Makes the number of triangles `count`; new ones have no appearance.
  void resize(std::size_t count) { triangles.resize(count); }
};

// Texture coordinates from those of a file that counts from the lower left corner. Coordinates that are not finite, or so far outside that
// single precision would keep no digits of them, give (0, 0).
Eigen::Vector2f texcoord_of(double right, double up);

// Converts the linear light of glTF to sRGB, 0 to 1. Values outside 0 to 1 are clamped; values that are not finite give 0.
float to_srgb(double linear);

}  // namespace hapton
