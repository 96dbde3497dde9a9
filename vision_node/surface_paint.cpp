#include "vision_node/surface_paint.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <unordered_map>

namespace hapton {
namespace {

std::uint8_t to_byte(double channel) { return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(channel, 0.0, 1.0))); }

// A mask with a cutoff above 1 gets alpha 0, so that it is never drawn. A blended surface gets cutoff 1: only invisible parts are left out.
void set_alpha(const VisualMaterial& material, const CornerAppearance& corner, VertexPaint& paint) {
  if (material.alpha_mode == AlphaMode::opaque) return;
  paint.alpha = to_byte(material.alpha * corner.alpha / 255.0);
  paint.is_blended = material.alpha_mode == AlphaMode::blend ? 1 : 0;
  const std::uint8_t min_cutoff = material.alpha_cutoff > 0.0F ? 1 : 0;
  paint.cutoff = paint.is_blended != 0 ? 1 : std::max(min_cutoff, to_byte(material.alpha_cutoff));
  if (paint.is_blended == 0 && material.alpha_cutoff > 1.0F) paint.alpha = 0;
}

VertexPaint compute_paint(const MeshAppearance& appearance, const TriangleAppearance& triangle, const CornerAppearance& corner,
                          const Vec3& colour, const std::vector<std::uint8_t>& layer_of) {
  const bool has_material = triangle.material < appearance.materials.size();
  const VisualMaterial material = has_material ? appearance.materials[triangle.material] : VisualMaterial();
  VertexPaint paint;
  if (material.image && *material.image < layer_of.size()) paint.layer = layer_of[*material.image];
  Vec3 tint = triangle.has_colours || paint.layer > 0 ? Vec3(Vec3::Ones()) : colour;
  if (material.colour) tint = material.colour->cast<double>();
  if (material.image && paint.layer == 0 && material.colour_no_image) tint = material.colour_no_image->cast<double>();
  for (int k = 0; k < 3; ++k)
    paint.tint[static_cast<std::size_t>(k)] = to_byte(tint[k] * corner.colour[static_cast<std::size_t>(k)] / 255.0);
  if (paint.layer > 0) {
    paint.texcoord = corner.texcoord.cwiseProduct(material.image_scale) + material.image_shift;
    paint.set_wrap(material.wrap);
  }
  set_alpha(material, corner, paint);
  return paint;
}

struct Key {
  std::uint32_t vertex;
  VertexPaint paint;
  bool operator==(const Key& other) const { return vertex == other.vertex && paint == other.paint; }
};

struct HashKey {
  std::size_t operator()(const Key& key) const {
    std::array<std::uint32_t, 4> words = {};
    static_assert(sizeof key.paint == sizeof words);
    std::memcpy(words.data(), &key.paint, sizeof words);
    std::uint64_t h = key.vertex;
    for (const std::uint32_t word : words) h = (h ^ word) * 0x9E3779B97F4A7C15ULL ^ (h >> 29);
    return h ^ (h >> 32);
  }
};

}  // namespace

DetailLevel make_painted_level(const TriangleMesh& mesh, const DetailFrame& frame, const MeshAppearance& appearance, const Vec3& colour,
                               const std::vector<std::uint8_t>& layer_of) {
  const DetailLevel plain = make_full_level(mesh, frame);
  DetailLevel level;
  level.clusters = plain.clusters;
  level.indices.reserve(plain.indices.size());
  std::unordered_map<Key, std::uint32_t, HashKey> known;
  known.reserve(2 * plain.positions.size());
  for (std::size_t i = 0; i < plain.indices.size(); ++i) {
    const TriangleAppearance& triangle = appearance.triangles[i / 3];
    const Key key = {plain.indices[i], compute_paint(appearance, triangle, triangle.corners[i % 3], colour, layer_of)};
    const auto [found, is_new] = known.emplace(key, static_cast<std::uint32_t>(level.positions.size()));
    if (is_new) {
      level.positions.push_back(plain.positions[key.vertex]);
      level.paints.push_back(key.paint);
    }
    level.indices.push_back(found->second);
  }
  return level;
}

}  // namespace hapton
