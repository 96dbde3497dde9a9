#include "vision_node/texture_layers.h"

#include <algorithm>

#include "vision_node/decode_image.h"

namespace hapton {
namespace {

// A vertex stores the number of its layer in one byte (VertexPaint::layer), and 0 means no layer.
constexpr std::size_t kMaxLayers = 255;
// For all layers of one mesh together; more would make no visible difference in a picture of a few megapixels.
constexpr std::size_t kMaxBytes = std::size_t{256} << 20;
constexpr int kMaxSide = 4096;

// The size of every layer: the largest width and the largest height of the images, reduced until all layers are within the limits.
std::pair<int, int> choose_size(const std::vector<Texels>& images) {
  int width = 1;
  int height = 1;
  for (const Texels& image : images) {
    width = std::max(width, image.width);
    height = std::max(height, image.height);
  }
  GLint limit = kMaxSide;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
  width = std::min({width, static_cast<int>(limit), kMaxSide});
  height = std::min({height, static_cast<int>(limit), kMaxSide});
  while (4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * images.size() > kMaxBytes) {
    width = std::max(1, width / 2);
    height = std::max(1, height / 2);
  }
  return {width, height};
}

std::vector<bool> find_used(const MeshAppearance& appearance) {
  std::vector<bool> is_used(appearance.images.size(), false);
  for (const VisualMaterial& material : appearance.materials) {
    if (material.image && *material.image < is_used.size()) is_used[*material.image] = true;
  }
  return is_used;
}

// Whether both appearances give the same layers, with the same numbers.
bool have_same_images(const MeshAppearance& a, const MeshAppearance& b) {
  if (&a == &b) return true;
  const std::vector<bool> is_used = find_used(a);
  if (is_used != find_used(b)) return false;
  for (std::size_t i = 0; i < is_used.size(); ++i) {
    if (is_used[i] && (a.images[i].name != b.images[i].name || a.images[i].bytes != b.images[i].bytes)) return false;
  }
  return true;
}

}  // namespace

std::unique_ptr<TextureLayers> TextureLayers::make(const MeshAppearance& appearance, std::vector<std::string>& notes) {
  const std::vector<bool> is_used = find_used(appearance);
  std::vector<std::uint8_t> layer_of(appearance.images.size(), 0);
  std::vector<Texels> images;
  for (std::size_t i = 0; i < appearance.images.size(); ++i) {
    if (!is_used[i] || images.size() >= kMaxLayers) continue;
    auto decoded = decode_image(appearance.images[i]);
    if (!decoded) {
      notes.push_back(decoded.error().what);
      continue;
    }
    images.push_back(std::move(*decoded));
    layer_of[i] = static_cast<std::uint8_t>(images.size());
  }
  if (images.empty()) return nullptr;
  std::unique_ptr<TextureLayers> layers(new TextureLayers);
  layers->layer_of_ = std::move(layer_of);
  const auto [width, height] = choose_size(images);
  glGenTextures(1, &layers->texture_);
  layers->bind();
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_RGBA8, width, height, static_cast<GLsizei>(images.size()), 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  for (std::size_t i = 0; i < images.size(); ++i) {
    const bool fits = images[i].width == width && images[i].height == height;
    const Texels fitted = fits ? std::move(images[i]) : resize_image(images[i], width, height);
    glTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, static_cast<GLint>(i), width, height, 1, GL_RGBA, GL_UNSIGNED_BYTE, fitted.rgba.data());
  }
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_REPEAT);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_REPEAT);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glGenerateMipmap(GL_TEXTURE_2D_ARRAY);
  unbind();
  return layers;
}

TextureLayers::~TextureLayers() {
  if (texture_ != 0) glDeleteTextures(1, &texture_);
}

std::shared_ptr<const TextureLayers> SharedTextures::make(std::shared_ptr<const MeshAppearance> appearance,
                                                          std::vector<std::string>& notes) {
  const auto is_same = [&](const SharedLayers& one) { return have_same_images(*one.appearance, *appearance); };
  if (const auto found = std::ranges::find_if(shared_layers_, is_same); found != shared_layers_.end()) return found->layers;
  shared_layers_.push_back({appearance, TextureLayers::make(*appearance, notes)});
  return shared_layers_.back().layers;
}

void TextureLayers::bind() const { glBindTexture(GL_TEXTURE_2D_ARRAY, texture_); }
void TextureLayers::unbind() { glBindTexture(GL_TEXTURE_2D_ARRAY, 0); }

int TextureLayers::unit() {
  GLint active = GL_TEXTURE0;
  glGetIntegerv(GL_ACTIVE_TEXTURE, &active);
  return active - GL_TEXTURE0;
}

}  // namespace hapton
