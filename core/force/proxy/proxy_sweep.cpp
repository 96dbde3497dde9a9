// Continuous collision of the proxy with triangles.
#include <algorithm>
#include <cmath>

#include "core/force/proxy/proxy_method.h"

namespace hapton {

// Moves the proxy along `motion` until something blocks it; returns true if blocked. contacts_ then has what it touches.
bool ProxyMethod::advance(const Vec3& motion) noexcept {
  const double t = sweep(proxy_, motion);
  const bool blocked = t <= 1.0;
  proxy_ += (blocked ? t : 1.0) * motion;
  update_contacts(blocked ? Vec3((1.0 - t) * motion) : Vec3::Zero());
  return blocked;
}

// The first time at which the moving proxy must stop; above 1: never. A long path is searched in pieces, because a blocker is mostly near
// the start: first in the triangle cache, then in the tree with growing pieces.
double ProxyMethod::sweep(const Vec3& from, const Vec3& motion) noexcept {
  ++counters_.sweeps;
  --sweeps_left_;
  blocker_count_ = 0;
  const double length = motion.norm();
  double far_piece = std::max(2.0 * (displacement_ + cache_radius_), 0x1p-6 * length);
  double done = 0.0;
  for (int piece = 0; done < 1.0; ++piece) {
    const Vec3 start = from + done * motion;
    const bool is_near = piece < kNearPieces && keep_cached(start, (1.0 - done) * motion, clearance_.offset, 0.0);
    double end = 1.0;
    if (is_near) {
      end = done + cache().time_inside(start, motion, clearance_.offset);
    } else if (length > 0.0) {
      end = done + far_piece / length;
      far_piece *= 4.0;
    }
    if (!(end < 1.0)) end = 1.0;
    const Vec3 part = (end - done) * motion;
    const Box path = Box::around(start, start + part).inflated(clearance_.offset);
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
      const int count = cache().find_candidates(start, part, clearance_.offset, path, candidates_);
      for (int i = 0; i < count; ++i) {
        if (done + static_cast<double>(candidates_[i].earliest) * (end - done) <= first)
          test(cache().shape(candidates_[i].slot), candidates_[i].triangle);
      }
    } else {
      geometry_.for_each_overlapping(path, [&](std::uint32_t triangle) { test(TriangleView{geometry_, triangle}, triangle); });
    }
    if (first <= end) return first;
    blocker_count_ = 0;
    done = end;
  }
  return kNever;
}

// A sphere on a face is also in contact with coplanar neighbours, although they never block its path.
void ProxyMethod::note_grazed(const Separation& at, std::uint32_t triangle) noexcept {
  if (at.distance > clearance_.offset + 2.0 * clearance_.tolerance || contact_count_ == kMaxContacts) return;
  for (int i = 0; i < contact_count_; ++i) {
    if (contacts_[i].triangle == triangle) return;
  }
  contacts_[contact_count_++] = {.triangle = triangle, .shape = shape_of(triangle), .separation = at};
}

void ProxyMethod::note_blocker(std::uint32_t triangle, double t) noexcept {
  int at = blocker_count_;
  if (at == kMaxContacts) {  // full: replace the latest
    const auto latest =
        std::max_element(blockers_.begin(), blockers_.end(), [](const Blocker& a, const Blocker& b) { return a.time < b.time; });
    if (t >= latest->time) return;
    at = static_cast<int>(latest - blockers_.begin());
  } else {
    ++blocker_count_;
  }
  blockers_[at] = {triangle, t};
}

// After a motion: keeps the contacts that still touch and adds the blockers.
void ProxyMethod::update_contacts(const Vec3& blocked_motion) noexcept {
  const double bound = clearance_.offset + 2.0 * clearance_.tolerance;
  const auto blockers_end = blockers_.begin() + blocker_count_;
  int kept = 0;
  for (int i = 0; i < contact_count_; ++i) {
    Contact& contact = contacts_[i];
    if (std::any_of(blockers_.begin(), blockers_end, [&](const Blocker& b) { return b.triangle == contact.triangle; })) continue;
    contact.separation = contact.shape.separation(proxy_);
    if (contact.separation.distance > bound) continue;
    if (kept != i) contacts_[kept] = contact;
    ++kept;
  }
  for (int b = 0; b < blocker_count_ && kept < kMaxContacts; ++b) {
    const std::uint32_t triangle = blockers_[b].triangle;
    Contact& contact = contacts_[kept];
    contact.triangle = triangle;
    contact.shape = shape_of(triangle);
    contact.separation = blocking_separation(contact.shape, proxy_, blocked_motion, clearance_);
    if (contact.separation.distance <= bound) ++kept;
  }
  contact_count_ = kept;
}

}  // namespace hapton
