// The triangles near the proxy, copied before they are needed.
#include <algorithm>

#include "core/force/proxy/proxy_method.h"

namespace hapton {

void ProxyMethod::forget_near() noexcept {
  for (Neighbourhood& neighbourhood : neighbourhoods_) neighbourhood.clear();
  ahead_ = Ahead::nothing;
  if (sphere_ != nullptr) sphere_->forget_near();
}

// Makes the neighbourhood cover the beginning of a motion with some room around it: all of a short one, a fair part of a long one. Its
// size follows what fits, its centre lies `ahead` of its reach before the start.
bool ProxyMethod::stay_near(const Vec3& start, const Vec3& motion, double room, double ahead) noexcept {
  near_reach_ = std::min(std::max(near_reach_, stride_), kLargestReach);
  const double length = motion.norm();
  const Vec3 beginning = length > 0.5 * near_reach_ ? Vec3(motion * (0.5 * near_reach_ / length)) : motion;
  const Box needed = Box::around(start, start + beginning).inflated(room);
  if (near().covers(needed)) return true;
  ++counters_.refills;
  if (next_near().will_cover(needed)) {
    ++counters_.foreseen;
    here_ = 1 - here_;
    near().take();
  } else {
    const double half = near_reach_ + room;
    const Vec3 center = start + (ahead > 0.0 && length > 0.0 ? Vec3(motion * (ahead * near_reach_ / length)) : Vec3(0.5 * beginning));
    if (!near().fill(geometry_, Box{center.array() - half, center.array() + half})) {
      near_reach_ *= 0.5;
      return false;
    }
  }
  ahead_ = Ahead::begun;
  if (near().count() < kFewNear) near_reach_ *= 1.5;
  if (near().count() > kManyNear && near_reach_ > clearance_.rest) near_reach_ *= 0.8;
  return true;
}

// Whoever goes on as in this step leaves the neighbourhood soon: what lies beyond is looked up now, its corners fetched in the next step,
// so that the copy finds everything at hand.
void ProxyMethod::look_ahead(const Vec3& motion) noexcept {
  const Ahead was = ahead_;
  if (was == Ahead::begun) ahead_ = Ahead::nothing;
  if (was == Ahead::found) {
    next_near().fetch();
    ahead_ = Ahead::fetched;
  }
  const double length = motion.norm();
  if (was != Ahead::nothing || !(length > 0.0)) return;
  const double room = kAround * length + kBeside * hover_ + clearance_.rest;
  const double steps_left = near().time_inside(proxy_, motion, room);
  if (!(steps_left <= kForesight)) return;
  const double half = near_reach_ + room;
  const Vec3 center = proxy_ + (std::max(steps_left - 1.0, 0.0) + kAhead * near_reach_ / length) * motion;
  ahead_ = next_near().look_for(geometry_, Box{center.array() - half, center.array() + half}) ? Ahead::found : Ahead::too_much;
}

}  // namespace hapton
