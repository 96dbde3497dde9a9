// Continuous motion of the proxy: until what blocks it, and what it touches there.
#include <algorithm>
#include <cmath>

#include "core/force/proxy/proxy_method.h"

namespace hapton {

// Moves the proxy along `motion` until something blocks it; true when blocked. Afterwards touching_ holds what it touches.
bool ProxyMethod::advance(const Vec3& motion) noexcept {
  const double t = sweep(proxy_, motion);
  const bool blocked = t <= 1.0;
  proxy_ += (blocked ? t : 1.0) * motion;
  keep_touching(blocked ? Vec3((1.0 - t) * motion) : Vec3::Zero());
  return blocked;
}

// The first time a moving proxy must stop, > 1 for never. A long way is searched piece by piece, because what blocks is mostly
// near the start: first through the neighbourhood, then through the tree in pieces that grow.
double ProxyMethod::sweep(const Vec3& from, const Vec3& motion) noexcept {
  ++counters_.sweeps;
  --sweeps_left_;
  blocker_count_ = 0;
  const double length = motion.norm();
  double far_piece = std::max(2.0 * (stride_ + near_reach_), 0x1p-6 * length);
  double done = 0.0;
  for (int piece = 0; done < 1.0; ++piece) {
    const Vec3 start = from + done * motion;
    const bool is_near = piece < kNearPieces && stay_near(start, (1.0 - done) * motion, clearance_.rest, 0.0);
    double end = 1.0;
    if (is_near) {
      end = done + near().time_inside(start, motion, clearance_.rest);
    } else if (length > 0.0) {
      end = done + far_piece / length;
      far_piece *= 4.0;
    }
    if (!(end < 1.0)) end = 1.0;
    const Vec3 part = (end - done) * motion;
    const Box way = Box::around(start, start + part).inflated(clearance_.rest);
    double first = kNever;
    const auto test = [&](const auto& shape, std::uint32_t triangle) {
      ++counters_.tests;
      if (!is_point_) note_grazed(shape.separation(from), triangle);
      const double t = time_to_block(shape, from, motion, std::min(end, first), clearance_);
      if (t > 1.0 || !can_touch(triangle, from)) return;
      first = std::min(first, t);
      note_blocker(triangle, t);
    };
    if (is_near) {
      const int count = near().find_meetings(start, part, clearance_.rest, way, meetings_);
      for (int i = 0; i < count; ++i) {
        if (done + static_cast<double>(meetings_[i].earliest) * (end - done) <= first)
          test(near().shape(meetings_[i].place), meetings_[i].triangle);
      }
    } else {
      geometry_.for_each_overlapping(way, [&](std::uint32_t triangle) { test(TriangleView{geometry_, triangle}, triangle); });
    }
    if (first <= end) return first;
    blocker_count_ = 0;
    done = end;
  }
  return kNever;
}

// A sphere at rest on a face touches what lies in one plane with it, though that never blocks its way.
void ProxyMethod::note_grazed(const Separation& at, std::uint32_t triangle) noexcept {
  if (at.distance > clearance_.rest + 2.0 * clearance_.tolerance || touching_count_ == kMaxTouching) return;
  for (int i = 0; i < touching_count_; ++i) {
    if (touching_[i].triangle == triangle) return;
  }
  touching_[touching_count_++] = {.triangle = triangle, .shape = shape_of(triangle), .separation = at};
}

void ProxyMethod::note_blocker(std::uint32_t triangle, double t) noexcept {
  int at = blocker_count_;
  if (at == kMaxTouching) {  // full: the latest gives way
    const auto latest =
        std::max_element(blockers_.begin(), blockers_.end(), [](const Blocker& a, const Blocker& b) { return a.time < b.time; });
    if (t >= latest->time) return;
    at = static_cast<int>(latest - blockers_.begin());
  } else {
    ++blocker_count_;
  }
  blockers_[at] = {triangle, t};
}

// After a motion: keeps what is still touched, adds what stopped it.
void ProxyMethod::keep_touching(const Vec3& blocked_motion) noexcept {
  const double reach = clearance_.rest + 2.0 * clearance_.tolerance;
  const auto blockers_end = blockers_.begin() + blocker_count_;
  int kept = 0;
  for (int i = 0; i < touching_count_; ++i) {
    Touch& touch = touching_[i];
    if (std::any_of(blockers_.begin(), blockers_end, [&](const Blocker& b) { return b.triangle == touch.triangle; })) continue;
    touch.separation = touch.shape.separation(proxy_);
    if (touch.separation.distance > reach) continue;
    if (kept != i) touching_[kept] = touch;
    ++kept;
  }
  for (int b = 0; b < blocker_count_ && kept < kMaxTouching; ++b) {
    const std::uint32_t triangle = blockers_[b].triangle;
    Touch& touch = touching_[kept];
    touch.triangle = triangle;
    touch.shape = shape_of(triangle);
    touch.separation = blocking_separation(touch.shape, proxy_, blocked_motion, clearance_);
    if (touch.separation.distance <= reach) ++kept;
  }
  touching_count_ = kept;
}

}  // namespace hapton
