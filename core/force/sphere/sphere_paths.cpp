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

bool SphereFollower::make_leg(const Vec3& from, const Vec3& to, double time, Leg& leg) const noexcept {
  constexpr int kMostHalvings = 40;
  constexpr double kLeastTime = 0x1p-44;
  constexpr double kNearZero = 0x1p-50;  // rounding of a multiplier
  constexpr int kMostGrowing = 8;
  constexpr double kUneven = 0x1p-20;       // of the offset
  constexpr double kUnevenShare = 0x1p-24;  // of the length of the piece
  const Vec3 device = on_path(from, to, time);
  const Vec3 motion = to - from;
  if (minimum().is_on_axis(device)) {
    leg.time = minimum().time_off_axis(from, to, time);
    leg.released = -1;
    const OffsetContact& contact = contacts_[0];
    const Vec3 along = contact.part == Part::edge ? Vec3(contact.axis() * contact.axis().dot(motion)) : Vec3(Vec3::Zero());
    leg.path = CentrePath::straight(centre_, centre_ + (leg.time - time) * along);
    return true;
  }
  const bool is_straight = !contacts_[0].is_curved() && (contacts_.active_count() == 1 || !contacts_[1].is_curved());
  const auto multiplier = [&](const Vec3& c, const Vec3& at, int i) {
    ContactFrame frame;
    return contacts_.find_frame(c, frame) ? frame.dual[i].dot(c - at) : 0.0;
  };
  const Vec3 rate = is_straight ? Vec3::Zero() : minimum().find_rate(centre_, device, motion);
  // How far the centre is from the minimum for the device here: contacts at a small angle make a large distance of a small tolerance.
  double off = -1.0;
  const auto find_off = [&] {
    Vec3 here = centre_;
    if (off < 0.0) off = minimum().solve(device, here, work_) ? (here - centre_).norm() : 0.0;
    return off;
  };
  // Whether the piece turns by little and a cubic keeps time with it: its speed changes by at most a factor of two, or its middle is
  // checked. The piece begins at the centre, and no middle is nearer to the path from there than the centre is to the minimum.
  const auto is_even = [&](const Vec3& c, double then) {
    if (minimum().find_turn(c - centre_) > 2.0 * LocalMinimum::kTurn) return false;
    const double part = then - time;
    const Vec3 rate_there = minimum().find_rate(c, on_path(from, to, then), motion);
    const double slow = rate.norm();
    const double fast = rate_there.norm();
    if (std::max(slow, fast) <= 2.0 * std::min(slow, fast)) return true;
    Vec3 middle = 0.5 * (centre_ + c) + 0.125 * part * (rate - rate_there);
    const Vec3 guess = middle;
    if (!minimum().solve(on_path(from, to, time + 0.5 * part), middle, work_)) return false;
    const double uneven = (middle - guess).norm();
    const double most = kUneven * clearance().offset + kUnevenShare * (c - centre_).norm();
    return uneven <= most || uneven <= most + find_off();
  };
  double span = 1.0 - time;
  if (!is_straight) span = std::min(span, LocalMinimum::kTurn / std::max(minimum().find_turn(rate), 0x1p-100));
  Vec3 end;
  for (int i = 0;; ++i) {
    if (i == kMostHalvings || !(span > kLeastTime || span >= 1.0 - time)) return false;
    leg.time = span >= 1.0 - time ? 1.0 : time + span;
    end = centre_;
    if (minimum().solve(on_path(from, to, leg.time), end, work_) && (is_straight || is_even(end, leg.time))) break;
    if (i == 0 && contacts_.active_count() == 2 && !is_straight && make_curve_leg(from, to, time, leg)) return true;
    span *= 0.5;
  }
  // The first multiplier that reaches zero ends the leg.
  leg.released = -1;
  for (int i = 0; i < contacts_.active_count(); ++i) {
    const double at_end = multiplier(end, on_path(from, to, leg.time), i);
    if (!(at_end < -LocalMinimum::kAtMinimum)) continue;
    const auto multiplier_then = [&](double then) {
      Vec3 c = centre_ + (then - time) / (leg.time - time) * (end - centre_);
      return minimum().solve(on_path(from, to, then), c, work_) ? multiplier(c, on_path(from, to, then), i)
                                                                : std::numeric_limits<double>::quiet_NaN();
    };
    double begin = time;
    double at_start = std::max(0.0, multiplier(centre_, device, i));
    // The multiplier of a new contact begins at zero, and may rise before it falls to zero again.
    for (int k = 1; k <= kMostGrowing && at_start <= LocalMinimum::kAtMinimum; ++k) {
      const double then = time + std::ldexp(leg.time - time, -2 * k);
      const double grown = multiplier_then(then);
      if (!(grown > LocalMinimum::kAtMinimum)) continue;
      begin = then;
      at_start = grown;
    }
    const double zero = find_zero(begin, at_start, leg.time, at_end, kNearZero, multiplier_then);
    leg.released = i;
    leg.time = zero;
    end = centre_;
    if (zero > time && !minimum().solve(on_path(from, to, zero), end, work_)) return false;
  }
  if (is_straight) {
    leg.path = CentrePath::straight(centre_, end);
    return true;
  }
  const double part = leg.time - time;
  if (!(part > 0.0)) {
    leg.path = CentrePath::straight(centre_, end);
    return true;
  }
  const Vec3 rate_end = minimum().find_rate(end, on_path(from, to, leg.time), motion);
  leg.path = CentrePath::curved(centre_, end, part * rate, part * rate_end);
  contacts_.guide(leg.path);
  return true;
}

bool SphereFollower::make_descent(const Vec3& device, bool is_unstable, CentrePath& path) const noexcept {
  if (contacts_.active_count() == 2) return descend_along_curve(device, is_unstable, path);
  if (contacts_.active_count() != 1) return false;
  const OffsetContact& contact = contacts_[0];
  if (contact.is_curved()) {
    path = roll(contact, device);
    return true;
  }
  Vec3 end = centre_;
  minimum().solve(device, end, work_);
  path = CentrePath::straight(centre_, end);
  return true;
}

// Around an edge or a vertex in the steepest direction: along a helix, until it is level with the device along the edge, or closest to it
// around the edge. The squared distance is the sum of both parts, and neither rises.
CentrePath SphereFollower::roll(const OffsetContact& contact, const Vec3& device) const noexcept {
  const bool is_edge = contact.part == Part::edge;
  const Vec3 normal = contact.proximity(centre_).normal;
  const Vec3 axis = is_edge ? contact.axis() : Vec3(Vec3::Zero());
  const Vec3 off = device - contact.origin();
  const double rise = is_edge ? axis.dot(device - centre_) : 0.0;
  const Vec3 across = off - axis.dot(off) * axis;
  Vec3 sideways = across - normal.dot(across) * normal;
  const double ahead = normal.dot(across);
  const double distance = across.norm();
  double side = sideways.norm();
  if (side <= LocalMinimum::kAtMinimum) {
    if (ahead < 0.0) sideways = hint_ - normal.dot(hint_) * normal - axis.dot(hint_) * axis;
    side = ahead < 0.0 ? 0.0 : side;
    if (!(sideways.norm() > 0.0)) sideways = is_edge ? axis.cross(normal) : normal.unitOrthogonal();
  }
  const Vec3 direction = sideways.normalized();
  const double angle = distance > LocalMinimum::kAtMinimum ? std::atan2(side, ahead) : 0.0;
  double turn = std::min(angle, LocalMinimum::kTurn);
  double share = 1.0;
  if (side > LocalMinimum::kAtMinimum) {
    share = std::min(1.0, turn * clearance().offset / side);
    if (std::fabs(rise) > LocalMinimum::kAtMinimum) turn = share * side / clearance().offset;
  }
  const Vec3 up = share * rise * axis;
  const double sine = std::sin(turn);
  const double cosine = std::cos(turn);
  const Vec3 end = centre_ + up + clearance().offset * (sine * direction - (1.0 - cosine) * normal);
  CentrePath path = CentrePath::curved(centre_, end, up + clearance().offset * turn * direction,
                                       up + clearance().offset * turn * (cosine * direction - sine * normal));
  contacts_.guide(path);
  return path;
}

// Along the curve where two offset surfaces meet. From a minimum that has vanished: along hint_ or against it, whichever leads nearer to
// the device. False: neither does.
bool SphereFollower::descend_along_curve(const Vec3& device, bool is_unstable, CentrePath& path) const noexcept {
  ContactFrame frame;
  if (!contacts_.find_frame(centre_, frame)) return false;
  const double ahead = frame.along.dot(device - centre_);
  if (!is_unstable) return make_curve_piece(ahead < 0.0 ? Vec3(-frame.along) : frame.along, std::fabs(ahead), device, false, path);
  const Vec3 direction = frame.along.dot(hint_) < 0.0 ? Vec3(-frame.along) : frame.along;
  return make_curve_piece(direction, 2.0 * LocalMinimum::kAtMinimum, device, true, path) ||
         make_curve_piece(-direction, 2.0 * LocalMinimum::kAtMinimum, device, true, path);
}

bool SphereFollower::make_curve_piece(const Vec3& direction, double length, const Vec3& device, bool is_unstable,
                                      CentrePath& path) const noexcept {
  constexpr int kMostHalvings = 24;
  constexpr double kRounding = 0x1p-50;
  const bool is_straight = !contacts_[0].is_curved() && !contacts_[1].is_curved();
  ContactFrame here;
  if (!contacts_.find_frame(centre_, here)) return false;
  const double sense = here.along.dot(direction);
  // A piece of that length. False: it ends on another curve, or no nearer.
  const auto go = [&](double ahead, bool must_lead_on) {
    Vec3 end = centre_ + ahead * direction;
    ContactFrame there;
    if (is_straight) {
      if (!contacts_.restore(end, work_)) return false;
      path = CentrePath::straight(centre_, end);
      return true;
    }
    if (!contacts_.restore_to_frame(end, there, work_)) return false;
    const Vec3 chord = end - centre_;
    const Vec3 pull = device - centre_;
    // Half of what the squared distance loses. Within rounding nothing may be lost at the end of a descent.
    const double gain = chord.dot(pull - 0.5 * chord);
    if (!(gain > (is_unstable || must_lead_on ? 0.0 : -kRounding * pull.norm()))) return false;
    const Vec3 direction_there = sense < 0.0 ? Vec3(-there.along) : there.along;  // opposite: the curve on the other side of a crest
    if (!(direction_there.dot(direction) > 1.0 - 2.0 * LocalMinimum::kTurn * LocalMinimum::kTurn)) return false;
    if (must_lead_on && !(direction_there.dot(device - end) > 0.0)) return false;
    const double length_there = chord.norm();
    if (!(direction.dot(chord) > 0.5 * length_there)) return false;  // surfaces at a small angle: brought back to a place behind
    path = CentrePath::curved(centre_, end, length_there * direction, length_there * direction_there);
    contacts_.guide(path);
    return true;
  };
  if (!is_straight) {
    // As far as a piece may turn, or to the minimum if that is nearer.
    const double stability = minimum().find_stability(here, centre_, device);
    const double most = minimum().longest_on_curve(here, direction);
    const double to_minimum = !is_unstable && stability > LocalMinimum::kLeastStability ? length / stability : most;
    length = std::min(to_minimum, most);
    if (to_minimum < most && 8.0 * to_minimum > most && go(most, true)) return true;
  }
  for (int i = 0; i < kMostHalvings; ++i, length *= 0.5) {
    if (go(length, false)) return true;
  }
  return false;
}

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
