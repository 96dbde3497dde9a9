#include "core/force/map_finder.h"

#include <utility>

namespace hapton {

MapFinder::MapFinder(const SurfaceMaps& maps) : MapFinder(maps, std::make_shared<const MappedSurface>(maps.triangles)) {}

MapFinder::MapFinder(const SurfaceMaps& maps, std::shared_ptr<const MappedSurface> surface) : maps_(maps), surface_(std::move(surface)) {}

MapSample MapFinder::find(const Vec3& p) noexcept {
  if (surface_->is_empty() || !p.allFinite()) return {};
  return maps_.sample(surface_->find(p, last_));
}

}  // namespace hapton
