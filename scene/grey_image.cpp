#include "scene/grey_image.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "scene/image_texels.h"

namespace hapton {

Result<SurfaceImage> decode_grey_image(const std::string& bytes) {
  const auto image = decode_image(bytes, TexelKind::grey);
  if (!image) return tl::unexpected(image.error());
  std::vector<float> texels;
  texels.reserve(image->values.size());
  for (const std::uint8_t value : image->values) texels.push_back(static_cast<float>(value) / 255.0F);
  return SurfaceImage(image->width, image->height, std::move(texels));
}

Result<SurfaceImage> read_grey_image(const std::filesystem::path& path) {
  const Result<std::string> bytes = read_image_bytes(path);
  if (!bytes) return tl::unexpected(bytes.error());
  auto image = decode_grey_image(*bytes);
  if (!image) return fail("{}: {}", path.string(), image.error().what);
  return image;
}

}  // namespace hapton
