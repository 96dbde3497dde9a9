#include "core/force/sphere/centre_path.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapton {
namespace {

constexpr double kMinStep = 0x1p-50;     // share of a path's time
constexpr double kAtCorner = 0x1p-44;    // local units: a contact that is beyond the end of an edge by less is still on the edge
constexpr double kSlopeError = 0x1p-11;  // share of the slope's length

double rate_error(const ContactTriangle& triangle, const Separation& at, const Vec3& velocity) {
  constexpr double kSmall = 0x1p-20;  // share of the rate: an error too small to slow a search
  const double most = normal_error(at) * velocity.norm();
  if (at.feature != Feature::edge || most <= kSmall * std::fabs(at.normal.dot(velocity))) return most;
  const int k = triangle.boundary(at.nearest).edge;
  const Vec3 along = triangle.edge(k) / triangle.length(k);
  constexpr double kDirectionError = 0x1p-51;  // rounding of a unit direction
  return normal_error(at) * (velocity - along.dot(velocity) * along).norm() + kDirectionError * velocity.norm();
}

// How long a distance that begins `gap` above a level stays above it, if it changes at the rate `approach` and bends by at most `bend`.
double time_above(double gap, double approach, double bend) {
  const double root = std::sqrt(approach * approach + 2.0 * bend * std::max(gap, 0.0));
  return approach < 0.0 ? 2.0 * std::max(gap, 0.0) / (root - approach) : bend > 0.0 ? (approach + root) / bend : 1.0;
}

int nearest_corner(const ContactTriangle& triangle, const Vec3& p) {
  const auto off = [&](int k) { return (triangle.corner(k) - p).squaredNorm(); };
  return off(0) <= std::min(off(1), off(2)) ? 0 : off(1) <= off(2) ? 1 : 2;
}

}  // namespace

CentrePath CentrePath::straight(const Vec3& from, const Vec3& to) noexcept {
  CentrePath path;
  path.start_ = from;
  path.end_ = to;
  path.rate_ = {to - from, Vec3::Zero(), Vec3::Zero()};
  return path;
}

CentrePath CentrePath::curved(const Vec3& from, const Vec3& to, const Vec3& slope_from, const Vec3& slope_to) noexcept {
  CentrePath path;
  path.start_ = from;
  path.end_ = to;
  const Vec3 chord = to - from;
  path.rate_ = {slope_from, 3.0 * chord - 2.0 * slope_from - slope_to, slope_from + slope_to - 2.0 * chord};
  constexpr double kCurveToCubic = 1.0625;  // upper bound: second derivative of the true curve over that of the cubic
  const Vec3 first = kCurveToCubic * 2.0 * path.rate_[1];
  const Vec3 last = first + kCurveToCubic * 6.0 * path.rate_[2];
  path.bend_ = std::max(first.norm(), last.norm());
  path.bend_across_ = path.bend_;
  path.bulge_bend_ = path.bend_;
  const double length = chord.norm();
  if (!(length > 0.0)) return path;
  const Vec3 along = chord / length;
  const double pace[2] = {along.dot(slope_from), along.dot(slope_to)};
  const double turn = slope_from.cross(slope_to).norm() / (slope_from.norm() * slope_to.norm());
  path.bend_along_ = std::max(std::fabs(along.dot(first)), std::fabs(along.dot(last)));
  // Where the curve turns, an uneven speed also has a component across the chord.
  const double across =
      std::max((first - along.dot(first) * along).norm(), (last - along.dot(last) * along).norm()) + turn * path.bend_along_;
  if (!(across < path.bend_)) {
    path.bend_along_ = 0.0;
    return path;
  }
  path.chord_ = along;
  path.bend_across_ = across;
  // The cubic is monotonic along the chord, so it stays between the ends (Fritsch and Carlson 1980).
  if (std::min(pace[0], pace[1]) > 0.0 && std::max(pace[0], pace[1]) <= 3.0 * length) path.bulge_bend_ = across;
  return path;
}

Vec3 CentrePath::at(double time) const noexcept {
  if (time >= 1.0) return end_;
  if (time <= 0.0) return start_;
  Vec3 p = cubic_at(time);
  if (guide_count_ > 0) project_onto_guides(p);
  return p;
}

// Newton's method. One step is exact on one guide. On two guides the first step leaves an error of the square of the cubic's error over
// their radius, which is above rounding.
void CentrePath::project_onto_guides(Vec3& p) const noexcept {
  constexpr int kMaxRounds = 3;           // a bound; see above
  constexpr double kConverged = 0x1p-30;  // an error this small leaves less than rounding
  for (int round = 0; round < kMaxRounds; ++round) {
    if (project_once(p) <= kConverged || guide_count_ == 1) return;
  }
}

double CentrePath::Guide::distance_to(const Vec3& p, Vec3& normal) const noexcept {
  Vec3 off = p - origin;
  if (part == Feature::face) {
    normal = direction;
    return direction.dot(off);
  }
  if (part == Feature::edge) off -= direction.dot(off) * direction;
  const double distance = off.norm();
  normal = distance > 0.0 ? Vec3(off / distance) : Vec3::Zero();
  return distance;
}

// Returns the distance of p from the guides before the step.
double CentrePath::project_once(Vec3& p) const noexcept {
  std::array<Vec3, 2> normal;
  std::array<double, 2> short_by{};
  for (int i = 0; i < guide_count_; ++i) {
    short_by[i] = guides_[i].offset - guides_[i].distance_to(p, normal[i]);
  }
  if (guide_count_ == 1) {
    p += short_by[0] * normal[0];
    return std::fabs(short_by[0]);
  }
  constexpr double kParallel = 0x1p-24;  // of sine^2: normals within 0.014 degrees count as parallel
  const double cosine = normal[0].dot(normal[1]);
  const double sine_squared = (1.0 - cosine) * (1.0 + cosine);
  if (!(sine_squared > kParallel)) return 0.0;
  p +=
      ((short_by[0] - cosine * short_by[1]) / sine_squared) * normal[0] + ((short_by[1] - cosine * short_by[0]) / sine_squared) * normal[1];
  return std::max(std::fabs(short_by[0]), std::fabs(short_by[1]));
}

Vec3 CentrePath::slope(double time) const noexcept { return guide_count_ > 0 ? slope(time, at(time)) : cubic_slope(time); }

Vec3 CentrePath::slope(double time, const Vec3& p) const noexcept {
  const Vec3 velocity = cubic_slope(time);
  if (guide_count_ == 0) return velocity;
  Vec3 normal;
  guides_[0].distance_to(p, normal);
  const Vec3 over_first = velocity - normal.dot(velocity) * normal;
  if (guide_count_ == 1) return over_first;
  Vec3 other;
  guides_[1].distance_to(p, other);
  const Vec3 along = normal.cross(other);
  const double squared = along.squaredNorm();
  return squared > 0.0 ? Vec3(along * (along.dot(velocity) / squared)) : over_first;
}

CentrePath::Prefix CentrePath::prefix(double until) const noexcept {
  const Vec3 end = at(until);
  return {until, end, slope(until, end)};
}

double CentrePath::time_to_cross(const Vec3& origin, const Vec3& direction, double margin, double from, double until) const noexcept {
  const Plane plane{origin, direction, margin};
  return find_crossing(plane, {from, until, plane.height(at(from)), plane.height(at(until))});
}

double CentrePath::time_to_cross(const Vec3& origin, const Vec3& direction, double margin, const Prefix& prefix) const noexcept {
  const Plane plane{origin, direction, margin};
  const Range range{0.0, prefix.until, plane.height(start_), plane.height(prefix.end)};
  const auto turns_back = [&] { return !is_straight() && direction.dot(rate_[0]) > 0.0 && direction.dot(prefix.slope) < 0.0; };
  return range.at_high > 0.0 || turns_back() ? find_crossing(plane, range) : kNever;
}

// Where both ends are below the plane, the path can only cross it before it turns back.
double CentrePath::find_crossing(const Plane& plane, Range range) const noexcept {
  if (!(range.at_high > 0.0)) {
    if (std::max(range.at_low, range.at_high) + bulge() * plane.direction.norm() < 0.0) return kNever;
    const double until = std::exchange(range.high, find_turning_point(plane.direction, range.low, range.high));
    if (range.high < until) range.at_high = plane.height(at(range.high));
  }
  auto [low, high, at_low, at_high] = range;
  if (!(at_high > 0.0)) return kNever;
  if (at_low >= 0.0) return at_high > at_low ? low : kNever;
  if (is_straight()) return std::min(low + (high - low) * (at_low / (at_low - at_high)), range.high);
  // False position with the Illinois modification, from the time at which the cubic crosses.
  constexpr int kMaxRounds = 40;
  double time = guess_crossing(plane, range);
  for (int i = 0; i < kMaxRounds; ++i) {
    if (!(high - low > 0x1p-50)) return std::min(time, range.high);
    const Vec3 p = at(time);
    const double here = plane.height(p);
    if (std::fabs(here) <= 0x1p-52 || time <= low || time >= high) return time;
    if (here > 0.0) {
      high = time;
      at_high = here;
      at_low *= 0.5;
    } else {
      low = time;
      at_low = here;
      at_high *= 0.5;
    }
    // Newton's step, if it stays in the bracket.
    const double rate = plane.direction.dot(cubic_slope(time));
    const double next = time - here / rate;
    time = rate > 0.0 && next > low && next < high ? next : low + (high - low) * (at_low / (at_low - at_high));
  }
  return high;
}

// The time at which the cubic crosses the plane, which is near the time at which the path does.
double CentrePath::guess_crossing(const Plane& plane, Range range) const noexcept {
  constexpr int kMaxRounds = 12;           // a bound on the work: the time is a guess
  constexpr double kNearEnough = 0x1p-24;  // of the whole path
  auto [low, high, at_low, at_high] = range;
  double time = low + (high - low) * (at_low / (at_low - at_high));
  for (int i = 0; i < kMaxRounds; ++i) {
    const double here = plane.height(cubic_at(time));
    (here > 0.0 ? high : low) = time;
    const double next = time - here / plane.direction.dot(cubic_slope(time));
    const double step = (next > low && next < high ? next : 0.5 * (low + high)) - time;
    time += step;
    if (std::fabs(step) <= kNearEnough) break;
  }
  return time;
}

// The time at which the path is farthest along the direction, if that is inside the interval; else `high`.
double CentrePath::find_turning_point(const Vec3& direction, double low, double high) const noexcept {
  if (is_straight() || !(direction.dot(slope(low)) > 0.0) || !(direction.dot(slope(high)) < 0.0)) return high;
  constexpr int kRounds = 24;  // halvings: to 2^-24 of the interval
  double before = low;
  double after = high;
  for (int i = 0; i < kRounds; ++i) {
    const double middle = 0.5 * (before + after);
    (direction.dot(slope(middle)) > 0.0 ? before : after) = middle;
  }
  return before;
}

// The corner at `nearest`, if it guides the path; -1: none. An edge beyond this corner, in line with the touched edge, is as near as the
// corner all along the path.
int CentrePath::find_guiding_corner(const ContactTriangle& triangle, unsigned guiding, const Vec3& nearest) const noexcept {
  for (int k = 0; k < 3; ++k) {
    if ((guiding >> k & 1U) != 0 && (triangle.corner(k) - nearest).squaredNorm() <= kAtCorner * kAtCorner) return k;
  }
  return -1;
}

// When another point of the triangle becomes nearer than the corner.
double CentrePath::time_to_leave_corner(const ContactTriangle& triangle, int corner, double from, double until) const noexcept {
  double time = kNever;
  const int before = (corner + 2) % 3;
  const auto leave = [&](const Vec3& direction) {
    time = std::min(time, time_to_cross(triangle.corner(corner), direction, kAtCorner, from, std::min(until, time)));
  };
  if (triangle.length(corner) > 0.0) leave(triangle.edge(corner) / triangle.length(corner));
  if (triangle.length(before) > 0.0) leave(triangle.edge(before) / -triangle.length(before));
  return time;
}

// A step, from a time at which the corner is the nearest point, in which the distance stays above `level` less its tolerance. It is convex,
// so above its tangent less the bend of the path. Its rate is zero where the path rolls around the corner, but not where it only passes.
double CentrePath::step_past_corner(const ContactTriangle& triangle, const Level& level, int corner, double time) const noexcept {
  if (!(bend_ > 0.0)) return kMinStep;
  const double most = std::sqrt(level.tolerance / bend_);  // the bend takes half of the tolerance
  const Vec3 point = at(time);
  const Vec3 off = point - triangle.corner(corner);
  const double distance = off.norm();
  const double approach = -off.dot(slope(time, point)) / distance;
  const double room = distance - level.distance + 0.5 * level.tolerance;
  return std::max(approach * most > room ? room / approach : most, kMinStep);
}

// How long the centre stays on the inner side of a plane, at least. `inwards` is a unit vector.
double CentrePath::time_within(const Vec3& origin, const Vec3& inwards, const Place& here) const noexcept {
  constexpr double kRounding = 0x1p-50;  // local units: rounding of a height over a plane
  const double room = inwards.dot(here.point - origin);
  return room >= -kRounding ? time_above(room, inwards.dot(here.velocity), bend_) : 0.0;
}

// How long the nearest point of the triangle stays on that edge, ends included, at least. At each end the region is bounded by the plane
// through the end across this edge, or by the plane through the end across the other edge at it, whichever is farther.
double CentrePath::time_on_edge(const ContactTriangle& triangle, int edge, const Place& here) const noexcept {
  const int next = (edge + 1) % 3;
  const int before = (edge + 2) % 3;
  if (!(std::min({triangle.length(0), triangle.length(1), triangle.length(2)}) > 0.0)) return 0.0;
  const auto along = [&](int k) { return Vec3(triangle.edge(k) / triangle.length(k)); };
  const Vec3& start = triangle.corner(edge);
  const Vec3& end = triangle.corner(next);
  return std::min({time_within(start, along(edge).cross(triangle.normal()), here),
                   std::max(time_within(start, along(edge), here), time_within(start, along(before), here)),
                   std::max(time_within(end, -along(edge), here), time_within(end, -along(next), here))});
}

// How long the nearest point of the triangle stays at that corner, at least.
double CentrePath::time_at_corner(const ContactTriangle& triangle, int corner, const Place& here) const noexcept {
  const int before = (corner + 2) % 3;
  if (!(std::min(triangle.length(corner), triangle.length(before)) > 0.0)) return 0.0;
  return std::min(time_within(triangle.corner(corner), -triangle.edge(corner) / triangle.length(corner), here),
                  time_within(triangle.corner(corner), triangle.edge(before) / triangle.length(before), here));
}

// How long the distance from a line or point stays above `level`, at least, if it lies beside a line or point that guides the path. `off`:
// from the nearest point of the former to the centre. `sine`: that of the angle between the lines.
//
// Let P be the projection across the axis of the guide, or the identity for a point, r = P (c - origin) with |r| the guide's offset,
// n = r / |r|, and P', r' = off, n' and f = |r'| the same for the other. As n . c' = 0 and n . c'' = -|P c'|^2 / |r|, with D = |r' - r|
//
//   f'' = n' . c'' + (|P' c'|^2 - (n' . c')^2) / f  >=  -2 D / f |c''| - |c'|^2 / f (|P' - P| + D / |r| + (2 D / f)^2)
double CentrePath::time_beside(const Guide& guide, const Vec3& off, double sine, const Level& level, const Place& here) const noexcept {
  constexpr double kRounding = 0x1p-50;  // local units: rounding of a position
  const double distance = off.norm();
  if (!(distance > level.distance)) return 0.0;
  Vec3 normal;
  guide.distance_to(here.point, normal);
  const double speed = here.velocity.norm() + bend_;
  const double radial_difference = (off - guide.offset * normal).norm() + sine * speed + kRounding;
  const double share = radial_difference / level.distance;
  const double bend =
      2.0 * share * bend_ + speed * speed / level.distance * (sine + radial_difference / guide.offset + 4.0 * share * share);
  const double rate = off.dot(here.velocity) / distance;
  const double doubt = here.separation.normal.dot(here.velocity) - here.approach + kSlopeError * std::fabs(rate);
  return time_above(distance - level.distance, rate - doubt, bend);
}

// How long the triangle's distance stays above `level`, at least, if one of its edges or corners lies beside a line that guides the path.
double CentrePath::time_beside_line(const Guide& guide, const ContactTriangle& triangle, const Level& level,
                                    const Place& here) const noexcept {
  const auto by_edge = [&](int k) {
    const double sine = guide.direction.cross(triangle.edge(k)).norm() / triangle.length(k);
    Vec3 off = here.point - triangle.corner(k);
    off -= triangle.along(k, here.point) * triangle.edge(k);
    return std::min(time_on_edge(triangle, k, here), time_beside(guide, off, sine, level, here));
  };
  if (here.separation.feature == Feature::edge) return by_edge(triangle.boundary(here.separation.nearest).edge);
  const int k = nearest_corner(triangle, here.separation.nearest);
  Vec3 off = here.point - triangle.corner(k);  // from the line through the corner that is parallel to the guide
  off -= guide.direction.dot(off) * guide.direction;
  return std::max(
      {by_edge(k), by_edge((k + 2) % 3), std::min(time_at_corner(triangle, k, here), time_beside(guide, off, 0.0, level, here))});
}

// A step in which the distance stays above `level`, for a triangle with an edge, corner or face that lies beside a guide of the path: the
// distance of such a triangle hardly changes, however much the path bends.
double CentrePath::step_beside_guides(const ContactTriangle& triangle, const Level& level, const Place& here) const noexcept {
  const Separation& at = here.separation;
  double most = 0.0;
  for (int i = 0; i < guide_count_; ++i) {
    const Guide& guide = guides_[i];
    double time = 0.0;
    if (guide.part == Feature::face) {
      time = time_above(at.distance - level.distance, here.approach, (at.normal - guide.direction).norm() * bend_);
    } else if (guide.part == Feature::edge && at.feature != Feature::face) {
      time = time_beside_line(guide, triangle, level, here);
    } else if (guide.part == Feature::vertex && at.feature == Feature::vertex) {
      const int k = nearest_corner(triangle, at.nearest);
      time = std::min(time_at_corner(triangle, k, here), time_beside(guide, here.point - triangle.corner(k), 0.0, level, here));
    }
    most = std::max(most, time);
  }
  return most;
}

// When the distance falls to `level`, within a tolerance.
CentrePath::Block CentrePath::find_below(const ContactTriangle& triangle, const Level& level, unsigned guiding, double from, double until,
                                         int& tests) const noexcept {
  constexpr int kMaxRounds = 64;  // after these the path is known to be free up to the time reached, and no farther
  constexpr int kFewRounds = 32;  // these decide all ordinary cases
  const double slope_error = guide_count_ > 0 ? kSlopeError : 0.0;
  double time = from;
  for (int i = 0; i < kMaxRounds; ++i) {
    ++tests;
    const Vec3 point = at(time);
    const Separation now = triangle.separation(point);
    if (guiding != 0 && now.feature != Feature::face) {
      if (const int corner = find_guiding_corner(triangle, guiding, now.nearest); corner >= 0) {
        time = std::max(time_to_leave_corner(triangle, corner, time, until), time);
        if (!(time < until)) return {};
        time += step_past_corner(triangle, level, corner, time);
        if (!(time < until)) return {};
        continue;
      }
    }
    const Vec3 velocity = slope(time, point);
    const double rate = now.normal.dot(velocity);
    const double approach = rate - rate_error(triangle, now, velocity) - slope_error * std::fabs(rate);
    const double gap = now.distance - level.distance;
    if (gap <= level.tolerance && (approach < 0.0 || gap < 0.0)) return {time, true};
    // gap + approach x - bend / 2 x^2 = 0
    double step = 0.0;
    if (bend_ > 0.0) {
      step = time_above(gap, approach, bend_towards(now.normal));
      if (i >= kFewRounds) step = std::max(step, step_beside_guides(triangle, level, {point, velocity, now, approach}));
    } else {
      if (!(approach < 0.0)) return {};
      step = gap / -approach;
    }
    time += std::max(step, kMinStep);
    if (!(time < until)) return {};
  }
  return {time, false};
}

// A lower bound of the distance along the prefix. `start`: the separation at its start; `approach`: a lower bound of its rate there.
double CentrePath::least_by_ends(const ContactTriangle& triangle, const Separation& start, double approach,
                                 const Prefix& prefix) const noexcept {
  const double until = prefix.until;
  const Separation end = triangle.separation(prefix.end);
  const double rate = end.normal.dot(prefix.slope);
  const double recede = rate + normal_error(end) * prefix.slope.norm() + (guide_count_ > 0 ? kSlopeError * std::fabs(rate) : 0.0);
  // The distance is above start + approach t - bend_start / 2 t^2 and above end - recede (until - t) - bend_end / 2 (until - t)^2. The
  // first serves up to `time`, about where they cross, the second after it. Both are concave, so each is least at an end of its interval.
  const double bend_start = bend_towards(start.normal);
  const double bend_end = bend_towards(end.normal);
  const double bend = 0.5 * (bend_start + bend_end);
  const double crossing =
      (end.distance - recede * until - 0.5 * bend * until * until - start.distance) / (approach - recede - bend * until);
  const double time = crossing > 0.0 ? std::min(crossing, until) : 0.0;
  const double remaining = until - time;
  return std::min({start.distance, start.distance + time * (approach - 0.5 * bend_start * time),
                   end.distance - remaining * (recede + 0.5 * bend_end * remaining), end.distance});
}

CentrePath::Block CentrePath::find_block(const ContactTriangle& triangle, const Clearance& clearance, unsigned guiding,
                                         const Prefix& prefix, int& tests) const noexcept {
  ++tests;
  const double until = prefix.until;
  const Separation start = triangle.separation(start_);
  const Vec3 velocity = rate_[0];
  const double approach = start.normal.dot(velocity) - rate_error(triangle, start, velocity);
  const double gap = start.distance - clearance.offset;
  const double low = clearance.offset - 0.5 * clearance.slop;
  // The parabola at the start stays above `low`.
  const double bend_drop = 0.5 * bend_towards(start.normal) * until * until;
  const double lowest_gap = approach >= 0.0 ? gap + std::min(0.0, approach * until - bend_drop) : gap + approach * until - bend_drop;
  if (clearance.offset + lowest_gap > low) return {};
  // A centre at the lower bound may be below it by rounding. That alone does not stop it.
  if (start.distance < low + clearance.tolerance) {
    if (approach < 0.0) return {0.0, true};
    return find_below(triangle, {start.distance - 0.125 * clearance.slop, clearance.tolerance}, guiding, 0.0, until, tests);
  }
  ++tests;
  if (least_by_ends(triangle, start, approach, prefix) > low) return {};
  // Finds when the centre comes into contact, and whether it would come nearer than allowed after that.
  const double level = gap > clearance.tolerance ? clearance.offset
                                                 : std::min(clearance.offset - 0.25 * clearance.slop, start.distance - clearance.tolerance);
  const Block block = find_below(triangle, {level, clearance.tolerance}, guiding, 0.0, until, tests);
  if (block.time > until || !block.hits) return block;
  return find_below(triangle, {low, clearance.tolerance}, guiding, block.time, until, tests).time > until ? Block{} : block;
}

}  // namespace hapton
