#include "core/force/sphere/gathered_triangles.h"

namespace hapton {

bool GatheredTriangles::is_clear(const Vec3& c, double short_by, int& work) noexcept {
  bool clear = true;
  visit_near(c, c, clearance_.offset - short_by, [&](int slot) {
    if (!clear) return;
    ++work;
    const ContactTriangle& near = shape(slot);
    clear = near.separation(c).distance >= clearance_.offset - short_by || !can_touch(triangle(slot), near, c);
  });
  return clear;
}

bool GatheredTriangles::is_clear_here(const Vec3& c, double short_by, int& work) noexcept {
  return reach(c, clearance_.offset, work) && is_clear(c, short_by, work);
}

bool GatheredTriangles::cover(const CentrePath& path, double& until, int& work) noexcept {
  constexpr int kMaxHalvings = 40;  // of the path; after these, it counts as impossible to cover
  const double needed_distance = clearance_.offset + path.bulge() + 2.0 * clearance_.slop;
  const Vec3 end = path.at(until);
  if (covers(path.start(), needed_distance) && covers(end, needed_distance)) return true;
  if (!gather(path.start(), end - path.start(), work)) return false;
  for (int i = 0; i < kMaxHalvings; ++i, until *= 0.5) {
    if (covers(path.start(), needed_distance) && covers(path.at(until), needed_distance)) return true;
  }
  return false;
}

// Whether a ball of half this radius would hold nearly as many triangles. It would hold half of triangles of even shape, seven tenths of
// slivers side by side, and all of those at the tip of a fan. If so, larger balls gather fewer triangles in total along a path.
bool GatheredTriangles::are_slivers(double radius) const noexcept { return share_within(clearance_.offset + 0.5 * radius) > 0.625; }

// The ball's centre lies ahead on the path. Its radius is adapted so that it holds some dozens of triangles.
bool GatheredTriangles::gather(const Vec3& c, const Vec3& towards, int& work) noexcept {
  constexpr double kSamePlace = 0.25;  // offsets
  if ((c - crowded_at_).norm() <= kSamePlace * clearance_.offset) return false;
  constexpr int kMaxGuesses = 2;  // attempts that stop at kMaxFew triangles; after these, one may fill the cache
  // With fewer triangles the next radius is larger, with more than three times as many smaller. This and kMaxFew are free choices.
  constexpr int kFew = 24;
  constexpr int kMaxFew = 256;
  constexpr double kWidest = 0.25;  // local units
  constexpr double kDenser = 0.35;  // this and the next three: factors of the radius; free choices
  constexpr double kMuchWider = 4.0;
  constexpr double kWider = 1.4;
  constexpr double kLess = 0.7;
  constexpr double kWidestOfSlivers = 4.0;  // offsets
  constexpr int kMaxHalvings = 2;           // of the radius, among slivers; after these, it may fall below the least radius
  const double least = least_radius_;
  if (!(radius_ > 0.0)) radius_ = std::max(least, 0.5 * clearance_.offset);
  const double first_radius = radius_;
  const double length = towards.norm();
  const double sufficient_radius = std::max(least, length);
  bool is_guess = false;
  bool has_room = true;
  int overflows = 0;
  for (int i = 0; has_room; ++i) {
    // If the triangles here are much smaller than at the last place, the radius is too large: the first attempts stop early.
    is_guess = i < kMaxGuesses && last_count_ <= kMaxFew && radius_ > least;
    const Vec3 ahead = length > 0.0 ? Vec3(towards * (0.6 * radius_ / length)) : Vec3::Zero();
    int queried = 0;
    ++gather_count_;
    const bool fits = NearTriangles::gather(geometry_, c + ahead, clearance_.offset + radius_ + 4.0 * clearance_.slop, queried,
                                            is_guess ? kMaxFew : NearTriangles::kCapacity);
    const int in_fans = queried_in_fans();
    work += queried + queried / 4 - in_fans + in_fans / 4;  // in a large mesh, each triangle outside of fans waits for memory
    if (!fits) {
      has_room = is_guess || radius_ > least;
      const bool are_narrow = are_slivers(radius_);
      if (is_guess && radius_ > sufficient_radius && !are_narrow) {
        radius_ = std::max(kDenser * radius_, sufficient_radius);
      } else if (is_guess) {
        i = kMaxGuesses - 1;
      } else {
        radius_ = are_narrow && overflows++ < kMaxHalvings ? std::max(0.5 * radius_, least) : std::min(0.5 * radius_, least);
      }
      continue;
    }
    last_count_ = count();
    // Where the tree visits many triangles for each one that is near, as among slivers, a larger ball saves the most work.
    const int few = std::max(kFew, std::min(queried / 8, kMaxFew));
    if (count() < few) radius_ = std::min((count() < few / 4 ? kMuchWider : kWider) * radius_, kWidest);
    if (count() > 3 * few) {
      const double wider = std::max(first_radius, std::min(kWider * radius_, kWidestOfSlivers * clearance_.offset));
      const double smaller = std::max(kLess * radius_, std::min(radius_, sufficient_radius));
      if (overflows == 0) radius_ = are_slivers(radius_) ? wider : smaller;
    }
    return true;
  }
  crowded_at_ = c;
  return false;
}

}  // namespace hapton
