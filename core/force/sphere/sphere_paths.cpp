// The pieces of path that a sphere's centre takes over the offset surface without friction.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/force/sphere/sphere_follower.h"
#include "core/math/find_zero.h"
#include "core/math/straight_motion.h"

namespace hapton {
namespace {

using Part = OffsetContact::Part;

}  // namespace

// Gathers triangles so that they cover the path, or its beginning up to that time.
bool SphereFollower::cover(const CentrePath& path, double& until) noexcept {
  constexpr int kMostHalvings = 40;
  const double room = clearance().offset + path.bulge() + 2.0 * clearance().slop;
  const Vec3 end = path.at(until);
  if (near_.covers(path.start(), room) && near_.covers(end, room)) return true;
  if (!gather(end - path.start())) return false;
  for (int i = 0; i < kMostHalvings; ++i, until *= 0.5) {
    if (near_.covers(path.start(), room) && near_.covers(path.at(until), room)) return true;
  }
  return false;
}

// Whether a ball of half that radius would hold nearly as many triangles: of even ones it would hold half, of slivers side by side seven
// tenths, and at the tip of a fan all. Then a wider ball gathers fewer on the way.
bool SphereFollower::are_slivers(double radius) const noexcept { return near_.share_within(clearance().offset + 0.5 * radius) > 0.625; }

// The ball's centre lies ahead on the path. Its radius is adapted so that it holds some dozens of triangles. False: within the least radius
// there are too many. Then it is not tried again before the centre has gone some way.
bool SphereFollower::gather(const Vec3& towards) noexcept {
  constexpr double kSamePlace = 0.25;
  if ((centre_ - crowd_).norm() <= kSamePlace * clearance().offset) return false;
  constexpr int kMostGuesses = 2;
  constexpr int kFew = 24;
  constexpr int kMostFew = 256;
  constexpr double kWidest = 0.25;
  constexpr double kDenser = 0.35;
  constexpr double kMuchWider = 4.0;
  constexpr double kWider = 1.4;
  constexpr double kLess = 0.7;
  constexpr double kWidestOfSlivers = 4.0;  // offsets
  constexpr int kMostHalvings = 2;
  const double least = (is_point_ ? 64.0 : 0x1p-6) * clearance().offset;
  if (!(gather_radius_ > 0.0)) gather_radius_ = std::max(least, 0.5 * clearance().offset);
  const double given = gather_radius_;
  const double length = towards.norm();
  const double enough = std::max(least, length);
  bool is_guess = false;
  bool has_room = true;
  int overflows = 0;
  for (int i = 0; has_room; ++i) {
    // Where the triangles are much smaller than at the last place, the radius was too large.
    is_guess = i < kMostGuesses && gathered_count_ <= kMostFew && gather_radius_ > least;
    const Vec3 ahead = length > 0.0 ? Vec3(towards * (0.6 * gather_radius_ / length)) : Vec3::Zero();
    int queried = 0;
    ++gathered_;
    const bool fits = near_.gather(geometry_, centre_ + ahead, clearance().offset + gather_radius_ + 4.0 * clearance().slop, queried,
                                   is_guess ? kMostFew : NearTriangles::kCapacity);
    const int in_fans = near_.queried_in_fans();
    work_ += queried + queried / 4 - in_fans + in_fans / 4;  // in a large mesh each of the others waits for memory
    if (!fits) {
      has_room = is_guess || gather_radius_ > least;
      const bool are_narrow = are_slivers(gather_radius_);
      if (is_guess && gather_radius_ > enough && !are_narrow) {
        gather_radius_ = std::max(kDenser * gather_radius_, enough);
      } else if (is_guess) {
        i = kMostGuesses - 1;
      } else {
        gather_radius_ =
            are_narrow && overflows++ < kMostHalvings ? std::max(0.5 * gather_radius_, least) : std::min(0.5 * gather_radius_, least);
      }
      continue;
    }
    gathered_count_ = near_.count();
    // Where the tree visits many triangles for each one that is near, as among slivers, a wider ball saves most.
    const int few = std::max(kFew, std::min(queried / 8, kMostFew));
    if (near_.count() < few) gather_radius_ = std::min((near_.count() < few / 4 ? kMuchWider : kWider) * gather_radius_, kWidest);
    if (near_.count() > 3 * few) {
      const double wider = std::max(given, std::min(kWider * gather_radius_, kWidestOfSlivers * clearance().offset));
      const double smaller = std::max(kLess * gather_radius_, std::min(gather_radius_, enough));
      if (overflows == 0) gather_radius_ = are_slivers(gather_radius_) ? wider : smaller;
    }
    return true;
  }
  crowd_ = centre_;
  return false;
}

}  // namespace hapton
