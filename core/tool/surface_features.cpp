#include "core/tool/surface_features.h"

namespace hapton {

SurfaceFeatures::SurfaceFeatures(const ObjectGeometry& surface) : surface_(&surface), owned_(surface.triangle_count(), 0) {
  const std::uint32_t count = surface.triangle_count();
  first_.assign(surface.vertices().size() + 1, 0);
  std::vector<bool> is_owned(surface.vertices().size(), false);
  for (std::uint32_t t = 0; t < count; ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = surface.triangle(t)[k];
      first_[v + 1] += 2;
      if (!is_owned[v]) owned_[t] |= static_cast<std::uint8_t>(1U << k);
      is_owned[v] = true;
      const SurfaceAdjacency::Adjacent across = surface.adjacency().adjacent(t, k);
      if (!across.exists || t < across.triangle || (t == across.triangle && k <= across.edge)) {
        owned_[t] |= static_cast<std::uint8_t>(8U << k);
      }
    }
  }
  for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
  ring_.resize(first_.back());
  std::vector<std::uint32_t> filled(first_.begin(), first_.end() - 1);
  for (std::uint32_t t = 0; t < count; ++t) {
    const Triangle& corners = surface.triangle(t);
    for (int k = 0; k < 3; ++k) {
      for (const int other : {1, 2}) ring_[filled[corners[k]]++] = corners[(k + other) % 3];
    }
  }
}

bool SurfaceFeatures::is_local_maximum(std::uint32_t v, const Vec3& outward, double slope) const noexcept {
  const Vec3& at = surface_->vertices()[v];
  for (const std::uint32_t u : ring(v)) {
    const Vec3 edge = surface_->vertices()[u] - at;
    if (outward.dot(edge) > slope * edge.norm()) return false;
  }
  return true;
}

bool SurfaceFeatures::is_local_maximum(std::uint32_t t, int k, const Vec3& outward, double slope) const noexcept {
  const Vec3& at = surface_->corner(t, k);
  const auto rises = [&](const Vec3& opposite) {
    const Vec3 across = opposite - at;
    return outward.dot(across) > slope * across.norm();
  };
  if (rises(surface_->corner(t, (k + 2) % 3))) return false;
  const SurfaceAdjacency::Adjacent across = surface_->adjacency().adjacent(t, k);
  return !across.exists || !rises(surface_->corner(across.triangle, (across.edge + 2) % 3));
}

}  // namespace hapton
