// Rebuilds and prefetches the proxy's triangle cache.
#include <algorithm>

#include "core/force/proxy/proxy_method.h"

namespace hapton {

void ProxyMethod::forget_near() noexcept {
  for (TriangleCache& each : caches_) each.clear();
  prefetch_ = Prefetch::nothing;
  if (sphere_ != nullptr) sphere_->forget_near();
}

// Makes the cache cover the start of a motion with `room` around it: all of a short motion, a part of a long one. The size adapts to the
// number of triangles. The centre lies `ahead` cache radii in front of the start.
bool ProxyMethod::keep_cached(const Vec3& start, const Vec3& motion, double room, double ahead) noexcept {
  cache_radius_ = std::min(std::max(cache_radius_, displacement_), kLargestCacheRadius);
  const double length = motion.norm();
  const Vec3 beginning = length > 0.5 * cache_radius_ ? Vec3(motion * (0.5 * cache_radius_ / length)) : motion;
  const Box needed = Box::around(start, start + beginning).inflated(room);
  if (cache().covers(needed)) return true;
  ++counters_.rebuilds;
  if (next_cache().will_cover(needed)) {
    ++counters_.prefetched;
    current_ = 1 - current_;
    cache().commit();
  } else {
    const double half = cache_radius_ + room;
    const Vec3 centre = start + (ahead > 0.0 && length > 0.0 ? Vec3(motion * (ahead * cache_radius_ / length)) : Vec3(0.5 * beginning));
    if (!cache().rebuild(geometry_, Box{centre.array() - half, centre.array() + half})) {
      cache_radius_ *= 0.5;
      return false;
    }
  }
  prefetch_ = Prefetch::rebuilt;
  if (cache().count() < kFewNear) cache_radius_ *= 1.5;
  if (cache().count() > kManyNear && cache_radius_ > clearance_.offset) cache_radius_ *= 0.8;
  return true;
}

// Predicts when the proxy leaves the cache if it goes on as in this step. Shortly before, one step queries the triangles of the next cache
// and the following one fetches their corners, so the rebuild finds them in the processor's cache.
void ProxyMethod::prefetch_cache(const Vec3& motion) noexcept {
  const Prefetch was = prefetch_;
  if (was == Prefetch::rebuilt) prefetch_ = Prefetch::nothing;
  if (was == Prefetch::found) {
    next_cache().fetch();
    prefetch_ = Prefetch::fetched;
  }
  const double length = motion.norm();
  if (was != Prefetch::nothing || !(length > 0.0)) return;
  const double room = kCacheMargin * length + kBeside * contact_offset_ + clearance_.offset;
  const double steps_left = cache().time_inside(proxy_, motion, room);
  if (!(steps_left <= kPrefetchSteps)) return;
  const double half = cache_radius_ + room;
  const Vec3 centre = proxy_ + (std::max(steps_left - 1.0, 0.0) + kCacheAhead * cache_radius_ / length) * motion;
  prefetch_ = next_cache().query(geometry_, Box{centre.array() - half, centre.array() + half}) ? Prefetch::found : Prefetch::too_much;
}

}  // namespace hapton
