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

bool SphereFollower::find_frame(const Vec3& c, ContactFrame& frame) const noexcept {
  frame.count = active_count_;
  for (int i = 0; i < active_count_; ++i) frame.normal[i] = contacts_[i].proximity(c).normal;
  return frame.prepare();
}

void SphereFollower::guide(CentrePath& path) const noexcept {
  for (int i = 0; i < active_count_; ++i) path.add_guide(contacts_[i].guide(clearance_.offset));
}

// Projects onto the offset of all active contacts.
bool SphereFollower::restore(Vec3& c) const noexcept {
  ContactFrame frame;
  bool has_normals = false;
  return restore(c, frame, has_normals);
}

// The same, and the frame there.
bool SphereFollower::restore_to_frame(Vec3& c, ContactFrame& frame) const noexcept {
  bool has_normals = false;
  return restore(c, frame, has_normals) && (has_normals ? frame.prepare() : find_frame(c, frame));
}

// `has_normals`: whether the frame's normals are those there.
bool SphereFollower::restore(Vec3& c, ContactFrame& frame, bool& has_normals) const noexcept {
  constexpr int kMostRounds = 8;
  frame.count = active_count_;
  for (int round = 0; round < kMostRounds; ++round) {
    std::array<double, 3> short_by{};
    double most = 0.0;
    ++work_;
    for (int i = 0; i < active_count_; ++i) {
      const OffsetContact::Proximity proximity = contacts_[i].proximity(c);
      frame.normal[i] = proximity.normal;
      short_by[i] = clearance_.offset - proximity.distance;
      most = std::max(most, std::fabs(short_by[i]));
    }
    has_normals = most <= 0x1p-51;
    if (has_normals) return true;
    if (most > clearance_.offset || !frame.prepare()) return false;
    for (int i = 0; i < active_count_; ++i) c += short_by[i] * frame.dual[i];
    if (most <= 0x1p-26 * clearance_.offset && active_count_ == 1) return true;
  }
  for (int i = 0; i < active_count_; ++i) {
    if (!(std::fabs(clearance_.offset - contacts_[i].proximity(c).distance) <= clearance_.tolerance)) return false;
  }
  return true;
}

// Second derivative of half the squared distance to the device along the free directions, the least of all. 1: all active parts are flat.
double SphereFollower::find_stability(const Vec3& c, const Vec3& device) const noexcept {
  ContactFrame frame;
  return find_frame(c, frame) ? find_stability(frame, c, device) : 1.0;
}

double SphereFollower::find_stability(const ContactFrame& frame, const Vec3& c, const Vec3& device) const noexcept {
  if (active_count_ == 1) return contacts_[0].is_curved() ? 1.0 - frame.normal[0].dot(c - device) / clearance_.offset : 1.0;
  double stability = 1.0;
  for (int i = 0; i < active_count_; ++i) {
    stability -= std::max(0.0, frame.dual[i].dot(c - device)) * contacts_[i].curvature(frame.along, clearance_.offset);
  }
  return stability;
}

// The angle by which a displacement turns the centre about the active edges and vertices, rad.
double SphereFollower::find_turn(const Vec3& displacement) const noexcept {
  double most = 0.0;
  for (int i = 0; i < active_count_; ++i) {
    if (!contacts_[i].is_curved()) continue;
    const Vec3 axis = contacts_[i].part == Part::edge ? contacts_[i].axis() : Vec3(Vec3::Zero());
    most = std::max(most, (displacement - axis.dot(displacement) * axis).norm());
  }
  return most / clearance_.offset;
}

// The local minimum for the device on all active contacts. `c`: in, near it.
bool SphereFollower::solve(const Vec3& device, Vec3& c) const noexcept {
  constexpr double kLeastOff = 0x1p-40;
  if (active_count_ > 1) return active_count_ == 3 || solve_on_curve(device, c);
  const OffsetContact& contact = contacts_[0];
  if (contact.part == Part::face) {
    c = device + (clearance_.offset - contact.proximity(device).distance) * contact.normal;
    return true;
  }
  const OffsetContact::Proximity at = contact.proximity(device);
  if (!(at.distance > kLeastOff) || !(at.normal.dot(contact.proximity(c).normal) > 0.0)) return false;
  c = device + (clearance_.offset - at.distance) * at.normal;
  return true;
}

bool SphereFollower::solve_on_curve(const Vec3& device, Vec3& c) const noexcept {
  constexpr int kMostRounds = 16;
  constexpr double kMostSheer = 64.0;  // faces at a larger angle reach their common line in one step
  const bool is_line = !contacts_[0].is_curved() && !contacts_[1].is_curved();
  Vec3 along = Vec3::Zero();
  for (int round = 0; round < kMostRounds; ++round) {
    ++work_;
    ContactFrame frame;
    std::array<double, 2> short_by{};
    frame.count = 2;
    for (int i = 0; i < 2; ++i) {
      const OffsetContact::Proximity proximity = contacts_[i].proximity(c);
      frame.normal[i] = proximity.normal;
      short_by[i] = clearance_.offset - proximity.distance;
    }
    if (!frame.prepare()) return false;
    // Two offset surfaces can meet in two curves, one on either side of a crest: stay on the same one.
    if (round == 0) along = frame.along;
    if (!(frame.along.dot(along) > 0.0)) return false;
    double stability = 1.0;
    for (int i = 0; i < 2 && !is_line; ++i) {
      stability -= std::max(0.0, frame.dual[i].dot(c - device)) * contacts_[i].curvature(frame.along, clearance_.offset);
    }
    if (!(stability > kLeastStability)) return false;
    const double ahead = frame.along.dot(device - c) / stability;
    if (!is_line && find_turn(ahead * frame.along) > 2.0 * kTurn) return false;
    c += ahead * frame.along + short_by[0] * frame.dual[0] + short_by[1] * frame.dual[1];
    if (is_line && frame.dual[0].squaredNorm() <= kMostSheer) return true;
    const double step = std::max({std::fabs(ahead), std::fabs(short_by[0]), std::fabs(short_by[1])});
    if (step <= std::max(0x1p-26 * clearance_.offset, 0x1p-50)) return step <= clearance_.tolerance || restore(c);
  }
  return restore(c);
}

// Velocity of the local minimum for a device that moves.
Vec3 SphereFollower::find_rate(const Vec3& c, const Vec3& device, const Vec3& motion) const noexcept {
  ContactFrame frame;
  if (!find_frame(c, frame)) return Vec3::Zero();
  if (active_count_ == 2) {
    const double stability = find_stability(frame, c, device);
    return frame.along * (frame.along.dot(motion) / (stability > 0.0 ? std::max(stability, 0x1p-20) : std::min(stability, -0x1p-20)));
  }
  const OffsetContact& contact = contacts_[0];
  const Vec3& normal = frame.normal[0];
  const Vec3 sideways = motion - normal.dot(motion) * normal;
  if (contact.part == Part::face) return sideways;
  const double near = clearance_.offset - normal.dot(c - device);
  const double gain = clearance_.offset / std::max(near, 0x1p-40);
  if (contact.part == Part::vertex) return gain * sideways;
  const Vec3 axis = contact.axis();
  const double straight = axis.dot(motion);
  return gain * (sideways - straight * axis) + straight * axis;
}

bool SphereFollower::make_leg(const Vec3& from, const Vec3& to, double time, Leg& leg) const noexcept {
  constexpr int kMostHalvings = 40;
  constexpr double kLeastTime = 0x1p-44;
  constexpr double kNearZero = 0x1p-50;  // rounding of a multiplier
  constexpr int kMostGrowing = 8;
  constexpr double kUneven = 0x1p-20;       // of the offset
  constexpr double kUnevenShare = 0x1p-24;  // of the length of the piece
  const Vec3 device = on_path(from, to, time);
  const Vec3 motion = to - from;
  if (is_on_axis(device)) {
    leg.time = time_off_axis(from, to, time);
    leg.released = -1;
    const OffsetContact& contact = contacts_[0];
    const Vec3 along = contact.part == Part::edge ? Vec3(contact.axis() * contact.axis().dot(motion)) : Vec3(Vec3::Zero());
    leg.path = CentrePath::straight(centre_, centre_ + (leg.time - time) * along);
    return true;
  }
  const bool is_straight = !contacts_[0].is_curved() && (active_count_ == 1 || !contacts_[1].is_curved());
  const auto multiplier = [&](const Vec3& c, const Vec3& at, int i) {
    ContactFrame frame;
    return find_frame(c, frame) ? frame.dual[i].dot(c - at) : 0.0;
  };
  const Vec3 rate = is_straight ? Vec3::Zero() : find_rate(centre_, device, motion);
  // How far the centre is from the minimum for the device here: contacts at a small angle make a large distance of a small tolerance.
  double off = -1.0;
  const auto find_off = [&] {
    Vec3 here = centre_;
    if (off < 0.0) off = solve(device, here) ? (here - centre_).norm() : 0.0;
    return off;
  };
  // Whether the piece turns by little and a cubic keeps time with it: its speed changes by at most a factor of two, or its middle is
  // checked. The piece begins at the centre, and no middle is nearer to the path from there than the centre is to the minimum.
  const auto is_even = [&](const Vec3& c, double then) {
    if (find_turn(c - centre_) > 2.0 * kTurn) return false;
    const double part = then - time;
    const Vec3 rate_there = find_rate(c, on_path(from, to, then), motion);
    const double slow = rate.norm();
    const double fast = rate_there.norm();
    if (std::max(slow, fast) <= 2.0 * std::min(slow, fast)) return true;
    Vec3 middle = 0.5 * (centre_ + c) + 0.125 * part * (rate - rate_there);
    const Vec3 guess = middle;
    if (!solve(on_path(from, to, time + 0.5 * part), middle)) return false;
    const double uneven = (middle - guess).norm();
    const double most = kUneven * clearance_.offset + kUnevenShare * (c - centre_).norm();
    return uneven <= most || uneven <= most + find_off();
  };
  double span = 1.0 - time;
  if (!is_straight) span = std::min(span, kTurn / std::max(find_turn(rate), 0x1p-100));
  Vec3 end;
  for (int i = 0;; ++i) {
    if (i == kMostHalvings || !(span > kLeastTime || span >= 1.0 - time)) return false;
    leg.time = span >= 1.0 - time ? 1.0 : time + span;
    end = centre_;
    if (solve(on_path(from, to, leg.time), end) && (is_straight || is_even(end, leg.time))) break;
    if (i == 0 && active_count_ == 2 && !is_straight && make_curve_leg(from, to, time, leg)) return true;
    span *= 0.5;
  }
  // The first multiplier that reaches zero ends the leg.
  leg.released = -1;
  for (int i = 0; i < active_count_; ++i) {
    const double at_end = multiplier(end, on_path(from, to, leg.time), i);
    if (!(at_end < -kAtMinimum)) continue;
    const auto multiplier_then = [&](double then) {
      Vec3 c = centre_ + (then - time) / (leg.time - time) * (end - centre_);
      return solve(on_path(from, to, then), c) ? multiplier(c, on_path(from, to, then), i) : std::numeric_limits<double>::quiet_NaN();
    };
    double begin = time;
    double at_start = std::max(0.0, multiplier(centre_, device, i));
    // The multiplier of a new contact begins at zero, and may rise before it falls to zero again.
    for (int k = 1; k <= kMostGrowing && at_start <= kAtMinimum; ++k) {
      const double then = time + std::ldexp(leg.time - time, -2 * k);
      const double grown = multiplier_then(then);
      if (!(grown > kAtMinimum)) continue;
      begin = then;
      at_start = grown;
    }
    const double zero = find_zero(begin, at_start, leg.time, at_end, kNearZero, multiplier_then);
    leg.released = i;
    leg.time = zero;
    end = centre_;
    if (zero > time && !solve(on_path(from, to, zero), end)) return false;
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
  const Vec3 rate_end = find_rate(end, on_path(from, to, leg.time), motion);
  leg.path = CentrePath::curved(centre_, end, part * rate, part * rate_end);
  guide(leg.path);
  return true;
}

bool SphereFollower::make_descent(const Vec3& device, bool is_unstable, CentrePath& path) const noexcept {
  if (active_count_ == 2) return descend_along_curve(device, is_unstable, path);
  if (active_count_ != 1) return false;
  const OffsetContact& contact = contacts_[0];
  if (contact.is_curved()) {
    path = roll(contact, device);
    return true;
  }
  Vec3 end = centre_;
  solve(device, end);
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
  if (side <= kAtMinimum) {
    if (ahead < 0.0) sideways = hint_ - normal.dot(hint_) * normal - axis.dot(hint_) * axis;
    side = ahead < 0.0 ? 0.0 : side;
    if (!(sideways.norm() > 0.0)) sideways = is_edge ? axis.cross(normal) : normal.unitOrthogonal();
  }
  const Vec3 direction = sideways.normalized();
  const double angle = distance > kAtMinimum ? std::atan2(side, ahead) : 0.0;
  double turn = std::min(angle, kTurn);
  double share = 1.0;
  if (side > kAtMinimum) {
    share = std::min(1.0, turn * clearance_.offset / side);
    if (std::fabs(rise) > kAtMinimum) turn = share * side / clearance_.offset;
  }
  const Vec3 up = share * rise * axis;
  const double sine = std::sin(turn);
  const double cosine = std::cos(turn);
  const Vec3 end = centre_ + up + clearance_.offset * (sine * direction - (1.0 - cosine) * normal);
  CentrePath path = CentrePath::curved(centre_, end, up + clearance_.offset * turn * direction,
                                       up + clearance_.offset * turn * (cosine * direction - sine * normal));
  guide(path);
  return path;
}

// Along the curve where two offset surfaces meet. From a minimum that has vanished: along hint_ or against it, whichever leads nearer to
// the device. False: neither does.
bool SphereFollower::descend_along_curve(const Vec3& device, bool is_unstable, CentrePath& path) const noexcept {
  ContactFrame frame;
  if (!find_frame(centre_, frame)) return false;
  const double ahead = frame.along.dot(device - centre_);
  if (!is_unstable) return make_curve_piece(ahead < 0.0 ? Vec3(-frame.along) : frame.along, std::fabs(ahead), device, false, path);
  const Vec3 direction = frame.along.dot(hint_) < 0.0 ? Vec3(-frame.along) : frame.along;
  return make_curve_piece(direction, 2.0 * kAtMinimum, device, true, path) ||
         make_curve_piece(-direction, 2.0 * kAtMinimum, device, true, path);
}

bool SphereFollower::make_curve_piece(const Vec3& direction, double length, const Vec3& device, bool is_unstable,
                                      CentrePath& path) const noexcept {
  constexpr int kMostHalvings = 24;
  constexpr double kRounding = 0x1p-50;
  const bool is_straight = !contacts_[0].is_curved() && !contacts_[1].is_curved();
  ContactFrame here;
  if (!find_frame(centre_, here)) return false;
  const double sense = here.along.dot(direction);
  // A piece of that length. False: it ends on another curve, or no nearer.
  const auto go = [&](double ahead, bool must_lead_on) {
    Vec3 end = centre_ + ahead * direction;
    ContactFrame there;
    if (is_straight) {
      if (!restore(end)) return false;
      path = CentrePath::straight(centre_, end);
      return true;
    }
    if (!restore_to_frame(end, there)) return false;
    const Vec3 chord = end - centre_;
    const Vec3 pull = device - centre_;
    // Half of what the squared distance loses. Within rounding nothing may be lost at the end of a descent.
    const double gain = chord.dot(pull - 0.5 * chord);
    if (!(gain > (is_unstable || must_lead_on ? 0.0 : -kRounding * pull.norm()))) return false;
    const Vec3 direction_there = sense < 0.0 ? Vec3(-there.along) : there.along;  // opposite: the curve on the other side of a crest
    if (!(direction_there.dot(direction) > 1.0 - 2.0 * kTurn * kTurn)) return false;
    if (must_lead_on && !(direction_there.dot(device - end) > 0.0)) return false;
    const double length_there = chord.norm();
    if (!(direction.dot(chord) > 0.5 * length_there)) return false;  // surfaces at a small angle: brought back to a place behind
    path = CentrePath::curved(centre_, end, length_there * direction, length_there * direction_there);
    guide(path);
    return true;
  };
  if (!is_straight) {
    // As far as a piece may turn, or to the minimum if that is nearer.
    const double stability = find_stability(here, centre_, device);
    const double most = longest_on_curve(here, direction);
    const double to_minimum = !is_unstable && stability > kLeastStability ? length / stability : most;
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
  const double room = clearance_.offset + path.bulge() + 2.0 * clearance_.slop;
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
bool SphereFollower::are_slivers(double radius) const noexcept { return near_.share_within(clearance_.offset + 0.5 * radius) > 0.625; }

// The ball's centre lies ahead on the path. Its radius is adapted so that it holds some dozens of triangles. False: within the least radius
// there are too many. Then it is not tried again before the centre has gone some way.
bool SphereFollower::gather(const Vec3& towards) noexcept {
  constexpr double kSamePlace = 0.25;
  if ((centre_ - crowd_).norm() <= kSamePlace * clearance_.offset) return false;
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
  const double least = (is_point_ ? 64.0 : 0x1p-6) * clearance_.offset;
  if (!(gather_radius_ > 0.0)) gather_radius_ = std::max(least, 0.5 * clearance_.offset);
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
    const bool fits = near_.gather(geometry_, centre_ + ahead, clearance_.offset + gather_radius_ + 4.0 * clearance_.slop, queried,
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
      const double wider = std::max(given, std::min(kWider * gather_radius_, kWidestOfSlivers * clearance_.offset));
      const double smaller = std::max(kLess * gather_radius_, std::min(gather_radius_, enough));
      if (overflows == 0) gather_radius_ = are_slivers(gather_radius_) ? wider : smaller;
    }
    return true;
  }
  crowd_ = centre_;
  return false;
}

bool SphereFollower::holds_part_of(const ObjectGeometry::Corners& corners, std::uint32_t triangle) const noexcept {
  for (int i = 0; i < active_count_; ++i) {
    if (contacts_[i].triangle == triangle || contacts_[i].is_shared_with(corners.a, corners.b, corners.c)) return true;
  }
  return false;
}

// A bit for each corner of the triangle that belongs to an active edge or vertex.
unsigned SphereFollower::guiding_corners(const ContactTriangle& shape) const noexcept {
  unsigned guiding = 0;
  for (int i = 0; i < active_count_; ++i) {
    const OffsetContact& contact = contacts_[i];
    if (!contact.is_curved()) continue;
    for (int k = 0; k < 3; ++k) {
      const Vec3& corner = shape.corner(k);
      const bool is_end = contact.part == Part::edge && corner == contact.shape.corner((contact.index + 1) % 3);
      if (is_end || corner == contact.origin()) guiding |= 1U << k;
    }
  }
  return guiding;
}

}  // namespace hapton
