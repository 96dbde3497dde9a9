#include "vision_node/flat_level.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hapton {
namespace {

constexpr float kUnitNormal = 511.0F;  // 1 as a signed number of 10 bits
constexpr std::uint32_t kMask = 1023;  // 10 bits
// Marks a vertex that is not yet the last corner of a triangle. A packed normal never has the top bits set.
constexpr std::uint32_t kNoNormal = 0xFFFFFFFFU;

}  // namespace

std::uint32_t pack_normal(const Vec3f& unit) {
  std::uint32_t packed = 0;
  for (int k = 0; k < 3; ++k) {
    const float exact = std::clamp(unit[k], -1.0F, 1.0F) * kUnitNormal;
    const auto step = static_cast<int>(exact + std::copysign(0.5F, exact));  // as std::lround, but without a function call for each
    packed |= (static_cast<std::uint32_t>(step) & kMask) << (10 * k);
  }
  return packed;
}

Vec3f unpack_normal(std::uint32_t packed) {
  Vec3f unit;
  for (int k = 0; k < 3; ++k) {
    const auto bits = static_cast<int>((packed >> (10 * k)) & kMask);
    unit[k] = static_cast<float>(bits > 511 ? bits - 1024 : bits) / kUnitNormal;
  }
  return unit;
}

FlatLevel make_flat(const DetailLevel& level) {
  FlatLevel flat;
  flat.clusters = level.clusters;
  flat.error = level.error;
  flat.indices.reserve(level.indices.size());
  flat.vertices.reserve(2 * level.positions.size());
  for (const Vec3f& p : level.positions) flat.vertices.push_back({p, kNoNormal});
  flat.paints = level.paints;
  for (std::size_t i = 0; i < level.indices.size(); i += 3) {
    std::array<std::uint32_t, 3> corner = {level.indices[i], level.indices[i + 1], level.indices[i + 2]};
    const Vec3f& a = level.positions[corner[0]];
    const Vec3f across = (level.positions[corner[1]] - a).cross(level.positions[corner[2]] - a);
    const float length = across.norm();
    const std::uint32_t normal = pack_normal(length > 0.0F ? Vec3f(across / length) : Vec3f::UnitZ());
    int last = -1;
    for (int k = 0; k < 3 && last < 0; ++k) {
      const std::uint32_t present_normal = flat.vertices[corner[k]].normal;
      if (present_normal == normal || present_normal == kNoNormal) last = k;
    }
    if (last < 0) {
      flat.vertices.push_back({a, normal});
      if (!level.paints.empty()) flat.paints.push_back(level.paints[corner[0]]);
      corner[0] = static_cast<std::uint32_t>(flat.vertices.size() - 1);
      last = 0;
    }
    flat.vertices[corner[last]].normal = normal;
    for (int k = 1; k <= 3; ++k) flat.indices.push_back(corner[(last + k) % 3]);
  }
  for (FlatVertex& vertex : flat.vertices) {
    if (vertex.normal == kNoNormal) vertex.normal = 0;
  }
  return flat;
}

}  // namespace hapton
