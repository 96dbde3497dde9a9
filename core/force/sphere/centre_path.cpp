#include "core/force/sphere/centre_path.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

constexpr double kLeastStep = 0x1p-50;   // of a path's time
constexpr double kSlopeError = 0x1p-11;  // of its length

// What the normal's error may add to the rate at which the distance changes along `way`. An edge's normal is square to the edge whatever
// rounding does: along the edge it adds nothing.
double rate_error(const ContactTriangle& triangle, const Separation& at, const Vec3& way) {
  constexpr double kSmall = 0x1p-20;  // of the rate: that slows no search
  const double most = normal_error(at) * way.norm();
  if (at.feature != Feature::edge || most <= kSmall * std::fabs(at.normal.dot(way))) return most;
  const int k = triangle.boundary(at.nearest).edge;
  const Vec3 along = triangle.edge(k) / triangle.length(k);
  constexpr double kDirectionError = 0x1p-51;
  return normal_error(at) * (way - along.dot(way) * along).norm() + kDirectionError * way.norm();
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
  constexpr double kOfTheCurve = 1.0625;  // the curve itself bends by as much more than the cubic, at most
  const Vec3 first = kOfTheCurve * 2.0 * path.rate_[1];
  const Vec3 last = first + kOfTheCurve * 6.0 * path.rate_[2];
  path.bend_ = std::max(first.norm(), last.norm());
  path.bend_across_ = path.bend_;
  path.bulge_ = path.bend_;
  const double length = chord.norm();
  if (!(length > 0.0)) return path;
  const Vec3 along = chord / length;
  const double pace[2] = {along.dot(slope_from), along.dot(slope_to)};
  const double turn = slope_from.cross(slope_to).norm() / (slope_from.norm() * slope_to.norm());
  path.bend_along_ = std::max(std::fabs(along.dot(first)), std::fabs(along.dot(last)));
  // Where the curve turns, what it is gone along unevenly shows across, too.
  const double across =
      std::max((first - along.dot(first) * along).norm(), (last - along.dot(last) * along).norm()) + turn * path.bend_along_;
  if (!(across < path.bend_)) {
    path.bend_along_ = 0.0;
    return path;
  }
  path.chord_ = along;
  path.bend_across_ = across;
  // Along the chord it does not go back, nor beyond its ends (Fritsch and Carlson 1980).
  if (std::min(pace[0], pace[1]) > 0.0 && std::max(pace[0], pace[1]) <= 3.0 * length) path.bulge_ = across;
  return path;
}

Vec3 CentrePath::at(double time) const noexcept {
  if (time >= 1.0) return end_;
  if (time <= 0.0) return start_;
  Vec3 p = start_ + time * (rate_[0] + time * (rate_[1] + time * rate_[2]));
  if (guide_count_ > 0) bring_back(p);
  return p;
}

// Newton's method. One step is exact on one guide. On two guides the first step leaves the square of the cubic's error over their radius,
// which rounding does not explain.
void CentrePath::bring_back(Vec3& p) const noexcept {
  constexpr int kMostRounds = 3;
  constexpr double kConverged = 0x1p-30;  // an error this small leaves less than rounding
  for (int round = 0; round < kMostRounds; ++round) {
    if (bring_nearer(p) <= kConverged || guide_count_ == 1) return;
  }
}

double CentrePath::Guide::distance_to(const Vec3& p, Vec3& normal) const noexcept {
  Vec3 off = p - origin;
  if (round == Round::plane) {
    normal = direction;
    return direction.dot(off);
  }
  if (round == Round::line) off -= direction.dot(off) * direction;
  const double distance = off.norm();
  normal = distance > 0.0 ? Vec3(off / distance) : Vec3::Zero();
  return distance;
}

// Returns how far p was off.
double CentrePath::bring_nearer(Vec3& p) const noexcept {
  std::array<Vec3, 2> normal;
  std::array<double, 2> short_by{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(guide_count_); ++i) {
    short_by[i] = guides_[i].offset - guides_[i].distance_to(p, normal[i]);
  }
  if (guide_count_ == 1) {
    p += short_by[0] * normal[0];
    return std::fabs(short_by[0]);
  }
  constexpr double kParallel = 0x1p-24;
  const double cosine = normal[0].dot(normal[1]);
  const double sine_squared = (1.0 - cosine) * (1.0 + cosine);
  if (!(sine_squared > kParallel)) return 0.0;
  p +=
      ((short_by[0] - cosine * short_by[1]) / sine_squared) * normal[0] + ((short_by[1] - cosine * short_by[0]) / sine_squared) * normal[1];
  return std::max(std::fabs(short_by[0]), std::fabs(short_by[1]));
}

Vec3 CentrePath::slope(double time) const noexcept { return guide_count_ > 0 ? slope(time, at(time)) : cubic_slope(time); }

Vec3 CentrePath::slope(double time, const Vec3& p) const noexcept {
  const Vec3 way = cubic_slope(time);
  if (guide_count_ == 0) return way;
  Vec3 normal;
  guides_[0].distance_to(p, normal);
  const Vec3 over_first = way - normal.dot(way) * normal;
  if (guide_count_ == 1) return over_first;
  Vec3 other;
  guides_[1].distance_to(p, other);
  const Vec3 along = normal.cross(other);
  const double squared = along.squaredNorm();
  return squared > 0.0 ? Vec3(along * (along.dot(way) / squared)) : over_first;
}

CentrePath::Head CentrePath::head(double until) const noexcept {
  const Vec3 end = at(until);
  return {until, end, slope(until, end)};
}

double CentrePath::time_to_pass(const Vec3& origin, const Vec3& direction, double margin, double from, double until) const noexcept {
  const Border border{origin, direction, margin};
  Range range{from, until, border.beyond(at(from)), border.beyond(at(until))};
  if (!(range.at_high > 0.0)) {
    if (std::max(range.at_low, range.at_high) + bulge() * direction.norm() < 0.0) return kNever;
    range.high = find_crest(direction, from, until);
    range.at_high = range.high < until ? border.beyond(at(range.high)) : range.at_high;
  }
  return find_passing(border, range);
}

double CentrePath::time_to_pass(const Vec3& origin, const Vec3& direction, double margin, const Head& head) const noexcept {
  const Border border{origin, direction, margin};
  Range range{0.0, head.until, border.beyond(start_), border.beyond(head.end)};
  if (!(range.at_high > 0.0)) {
    // Beyond between its ends: only where it turns back.
    if (is_straight() || !(direction.dot(rate_[0]) > 0.0) || !(direction.dot(head.slope) < 0.0)) return kNever;
    if (std::max(range.at_low, range.at_high) + bulge() * direction.norm() < 0.0) return kNever;
    range.high = find_crest(direction, 0.0, head.until);
    range.at_high = range.high < head.until ? border.beyond(at(range.high)) : range.at_high;
  }
  return find_passing(border, range);
}

double CentrePath::find_passing(const Border& border, Range range) const noexcept {
  auto [low, high, at_low, at_high] = range;
  if (!(at_high > 0.0)) return kNever;
  if (at_low >= 0.0) return at_high > at_low ? low : kNever;
  if (is_straight()) return std::min(low + (high - low) * (at_low / (at_low - at_high)), range.high);
  // False position, with the end that stays halved (Illinois), from where the cubic passes.
  constexpr int kMostRounds = 40;
  double time = guess_passing(border, range);
  for (int i = 0; i < kMostRounds; ++i) {
    if (!(high - low > 0x1p-50)) return std::min(time, range.high);
    const Vec3 p = at(time);
    const double here = border.beyond(p);
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
    // Newton's step, where it stays between.
    const double rate = border.direction.dot(cubic_slope(time));
    const double next = time - here / rate;
    time = rate > 0.0 && next > low && next < high ? next : low + (high - low) * (at_low / (at_low - at_high));
  }
  return high;
}

// Where the cubic passes, which is next to where the path does.
double CentrePath::guess_passing(const Border& border, Range range) const noexcept {
  constexpr int kMostRounds = 12;
  constexpr double kNearEnough = 0x1p-24;
  auto [low, high, at_low, at_high] = range;
  double time = low + (high - low) * (at_low / (at_low - at_high));
  for (int i = 0; i < kMostRounds; ++i) {
    const double here = border.beyond(cubic_at(time));
    (here > 0.0 ? high : low) = time;
    const double next = time - here / border.direction.dot(cubic_slope(time));
    const double step = (next > low && next < high ? next : 0.5 * (low + high)) - time;
    time += step;
    if (std::fabs(step) <= kNearEnough) break;
  }
  return time;
}

// Where the path is farthest along the direction, if that is between; else `high`.
double CentrePath::find_crest(const Vec3& direction, double low, double high) const noexcept {
  if (is_straight() || !(direction.dot(slope(low)) > 0.0) || !(direction.dot(slope(high)) < 0.0)) return high;
  constexpr int kRounds = 24;
  double before = low;
  double after = high;
  for (int i = 0; i < kRounds; ++i) {
    const double middle = 0.5 * (before + after);
    (direction.dot(slope(middle)) > 0.0 ? before : after) = middle;
  }
  return before;
}

// When another place of the triangle becomes nearer than the corner.
double CentrePath::time_off_corner(const ContactTriangle& triangle, int corner, double from, double until) const noexcept {
  double time = kNever;
  const int before = (corner + 2) % 3;
  const auto leave = [&](const Vec3& direction) {
    time = std::min(time, time_to_pass(triangle.corner(corner), direction, 0.0, from, std::min(until, time)));
  };
  if (triangle.length(corner) > 0.0) leave(triangle.edge(corner) / triangle.length(corner));
  if (triangle.length(before) > 0.0) leave(triangle.edge(before) / -triangle.length(before));
  return time;
}

// When the distance falls to `level`, to a tolerance.
CentrePath::Block CentrePath::find_below(const ContactTriangle& triangle, const Level& level, unsigned held, double from, double until,
                                         int& tests) const noexcept {
  constexpr int kMostRounds = 64;
  const double slope_error = guide_count_ > 0 ? kSlopeError : 0.0;
  // Past a corner: the distance to an edge or face that begins there falls by less than the tolerance meanwhile.
  const double least_step = bend_ > 0.0 ? std::max(kLeastStep, std::sqrt(level.tolerance / bend_)) : kLeastStep;
  double time = from;
  for (int i = 0; i < kMostRounds; ++i) {
    ++tests;
    const Vec3 place = at(time);
    const Separation now = triangle.separation(place);
    if (held != 0 && now.feature == Feature::vertex) {
      int corner = 0;
      while (corner < 2 && triangle.corner(corner) != now.nearest) ++corner;
      if ((held >> corner & 1U) != 0) {
        const double off = time_off_corner(triangle, corner, time, until);
        time = std::max(off, time) + least_step;
        if (!(time < until)) return {};
        continue;
      }
    }
    const Vec3 way = slope(time, place);
    const double rate = now.normal.dot(way);
    const double approach = rate - rate_error(triangle, now, way) - slope_error * std::fabs(rate);
    const double gap = now.distance - level.distance;
    if (gap <= level.tolerance && (approach < 0.0 || gap < 0.0)) return {time, true};
    // gap + approach x - bend / 2 x^2 = 0
    double step = 0.0;
    if (bend_ > 0.0) {
      const double bend = bend_towards(now.normal);
      const double root = std::sqrt(approach * approach + 2.0 * bend * std::max(gap, 0.0));
      step = approach < 0.0 ? 2.0 * std::max(gap, 0.0) / (root - approach) : bend > 0.0 ? (approach + root) / bend : 1.0;
    } else {
      if (!(approach < 0.0)) return {};
      step = gap / -approach;
    }
    time += std::max(step, kLeastStep);
    if (!(time < until)) return {};
  }
  return {time, false};
}

// No distance on the path is less. `start`, `approach`: the distance there, and how fast it changes at least.
double CentrePath::least_by_ends(const ContactTriangle& triangle, const Separation& start, double approach,
                                 const Head& head) const noexcept {
  const double until = head.until;
  const Separation end = triangle.separation(head.end);
  const double rate = end.normal.dot(head.slope);
  const double recede = rate + normal_error(end) * head.slope.norm() + (guide_count_ > 0 ? kSlopeError * std::fabs(rate) : 0.0);
  // Above start + approach t - bend_start / 2 t^2, and above end - recede (until - t) - bend_end / 2 (until - t)^2. Both are concave: until
  // any time between, and from there on, each is least at an end. The time is about where they meet.
  const double bend_start = bend_towards(start.normal);
  const double bend_end = bend_towards(end.normal);
  const double bend = 0.5 * (bend_start + bend_end);
  const double meet = (end.distance - recede * until - 0.5 * bend * until * until - start.distance) / (approach - recede - bend * until);
  const double time = meet > 0.0 ? std::min(meet, until) : 0.0;
  const double left = until - time;
  return std::min({start.distance, start.distance + time * (approach - 0.5 * bend_start * time),
                   end.distance - left * (recede + 0.5 * bend_end * left), end.distance});
}

CentrePath::Block CentrePath::find_block(const ContactTriangle& triangle, const Keep& keep, unsigned held, const Head& head,
                                         int& tests) const noexcept {
  ++tests;
  const double until = head.until;
  const Separation start = triangle.separation(start_);
  const Vec3 way = rate_[0];
  const double approach = start.normal.dot(way) - rate_error(triangle, start, way);
  const double gap = start.distance - keep.offset;
  const double low = keep.offset - 0.5 * keep.slop;
  // Safe from the start: the parabola stays above.
  const double bent = 0.5 * bend_towards(start.normal) * until * until;
  const double bottom = approach >= 0.0 ? gap + std::min(0.0, approach * until - bent) : gap + approach * until - bent;
  if (keep.offset + bottom > low) return {};
  // What rounding took from a centre that is as near as can be does not hold it.
  if (start.distance < low + keep.tolerance) {
    if (approach < 0.0) return {0.0, true};
    return find_below(triangle, {start.distance - 0.125 * keep.slop, keep.tolerance}, held, 0.0, until, tests);
  }
  ++tests;
  if (least_by_ends(triangle, start, approach, head) > low) return {};
  // Where it comes in contact, and whether it would come nearer than may be from there.
  const double level = gap > keep.tolerance ? keep.offset : std::min(keep.offset - 0.25 * keep.slop, start.distance - keep.tolerance);
  const Block block = find_below(triangle, {level, keep.tolerance}, held, 0.0, until, tests);
  if (block.time > until || !block.hits) return block;
  return find_below(triangle, {low, keep.tolerance}, held, block.time, until, tests).time > until ? Block{} : block;
}

}  // namespace hapton
