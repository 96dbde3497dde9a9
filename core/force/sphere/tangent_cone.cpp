#include "core/force/sphere/tangent_cone.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace hapton {
namespace {

constexpr double kSameDirection = 0x1p-20;  // rad; closer directions count as equal
constexpr double kClosed = 0x1p-17;         // rad; a slit this narrow counts as closed, unless it is the wedge at the end of an arc

Vec3 tangent(const Vec3& normal, const Vec3& at, bool ahead) { return ahead ? Vec3(normal.cross(at)) : Vec3(at.cross(normal)); }

// The tangent at `at` towards the middle of an arc that has an end there. That end may be off `at` by an angle that counts as zero: then
// the arc's own tangent may be on the wrong side of another arc.
Vec3 heading_to_middle(const Vec3& middle, const Vec3& at) { return (middle - at.dot(middle) * at).normalized(); }

}  // namespace

void TangentCone::begin(const Vec3& apex) {
  apex_ = apex;
  arc_count_ = 0;
  piece_count_ = 0;
}

Vec3 TangentCone::snapped_to_end(const Vec3& direction) const {
  constexpr double kSame = 4.0 * kSameDirection * kSameDirection;  // the square of the distance 2 kSameDirection
  for (int i = 0; i < arc_count_; ++i) {
    const Arc& arc = arcs_[i];
    if ((arc.a - direction).squaredNorm() <= kSame) return arc.a;
    if ((arc.b - direction).squaredNorm() <= kSame) return arc.b;
  }
  return direction;
}

// Gives ends of arcs the same direction if their directions count as equal.
void TangentCone::join_ends() {
  const int count = std::exchange(arc_count_, 0);
  for (int i = 0; i < count; ++i) {
    const Arc arc = arcs_[i];
    (void)add_arc(snapped_to_end(arc.a), snapped_to_end(arc.b));
  }
}

bool TangentCone::add_arc(const Vec3& a, const Vec3& b) {
  const Vec3 normal = a.cross(b);
  const double length = normal.norm();
  if (!(length > kSameDirection)) return true;  // a needle covers no directions
  if (arc_count_ == kMaxArcs) return false;
  arcs_[arc_count_++] = {a, b, normal / length};
  return true;
}

bool TangentCone::add(const ContactTriangle& shape, double near) {
  if (shape.normal().isZero(0.0)) return true;
  const int before = arc_count_;
  if (add_arcs(shape, near)) return true;
  arc_count_ = before;
  return false;
}

// No arc is longer than a quarter circle, or than the angle at a corner of the triangle.
bool TangentCone::add_arcs(const ContactTriangle& shape, double near) {
  for (int k = 0; k < 3; ++k) {
    if ((shape.corner(k) - apex_).norm() > near) continue;
    return add_arc(shape.edge(k).normalized(), -shape.edge((k + 2) % 3).normalized());
  }
  for (int k = 0; k < 3; ++k) {
    if (std::fabs(shape.inside(k, apex_)) > near * shape.length(k)) continue;
    const Vec3 along = shape.edge(k) / shape.length(k);
    const Vec3 inward = shape.normal().cross(along);
    return add_arc(along, inward) && add_arc(inward, -along);
  }
  const Vec3 u = shape.edge(0) / shape.length(0);
  const Vec3 v = shape.normal().cross(u);
  return add_arc(u, v) && add_arc(v, -u) && add_arc(-u, -v) && add_arc(-v, u);
}

bool TangentCone::is_on(const Arc& arc, const Vec3& direction) {
  return arc.normal.cross(arc.a).dot(direction) > -kSameDirection && arc.b.cross(arc.normal).dot(direction) > -kSameDirection &&
         std::fabs(arc.normal.dot(direction)) <= kSameDirection;
}

// The end of the arc, or the place before it where another arc meets this one.
Vec3 TangentCone::find_end(int arc, bool ahead, const Vec3& from) const {
  const Arc& own = arcs_[arc];
  Vec3 stop = ahead ? own.b : own.a;
  double nearest = from.dot(stop) + kSameDirection * kSameDirection;
  const Vec3 forward = tangent(own.normal, from, ahead);
  for (int j = 0; j < arc_count_; ++j) {
    const Arc& other = arcs_[j];
    const Vec3 both = own.normal.cross(other.normal);
    const double length = both.norm();
    if (j == arc || !(length > kSameDirection)) continue;
    for (const double sign : {1.0, -1.0}) {
      const Vec3 at = both * (sign / length);
      if (!(at.dot(forward) > kSameDirection) || !(at.dot(from) > nearest) || !is_on(own, at) || !is_on(other, at)) continue;
      nearest = at.dot(from);
      stop = at;
    }
  }
  return stop;
}

// Goes from one piece to the next at the direction `at`: to the first arc that a rotation about `at`, from `back` through `up`, meets.
// Sheets that cross at a small angle are one within rounding for a long way, so the slit between them counts as closed. If two sheets meet
// at the end of one of them, the wedge between them has an exact tip, and counts as open.
TangentCone::Turn TangentCone::turn(const Vec3& at, const Vec3& back, const Vec3& up, bool is_end) const {
  Turn first;
  first.opening = std::numeric_limits<double>::infinity();
  for (int j = 0; j < arc_count_; ++j) {
    const Arc& arc = arcs_[j];
    const bool begins = (arc.a - at).norm() <= 2.0 * kSameDirection;
    const bool ends = (arc.b - at).norm() <= 2.0 * kSameDirection;
    if (!begins && !ends && !is_on(arc, at)) continue;
    for (const bool ahead : {true, false}) {
      if (ahead ? ends : begins) continue;
      const Vec3 heading = begins || ends ? heading_to_middle(arc.a + arc.b, at) : tangent(arc.normal, at, ahead);
      double angle = std::atan2(heading.dot(up), heading.dot(back));
      const bool is_tip = (is_end || begins || ends) && std::fabs(arc.normal.dot(at)) <= kSameDirection * angle;
      if (angle <= (is_tip ? kSameDirection : kClosed)) angle += 2.0 * std::numbers::pi;
      if (angle >= first.opening) continue;
      first = {{.arc = j, .ahead = ahead, .from = at}, angle};
    }
  }
  if (first.walk.arc < 0) return {};
  const Vec3 to_free = std::sin(first.opening) * back - std::cos(first.opening) * up;
  first.walk.on_normal = arcs_[first.walk.arc].normal.dot(to_free) > 0.0;
  return first;
}

// Starts at the direction on any arc that is closest to `inside`: no arc lies between. At an end, takes the arc that a turn meets first.
bool TangentCone::find_start(const Vec3& inside, Walk& start) const {
  double nearest = -2.0;
  bool is_end = false;
  for (int j = 0; j < arc_count_; ++j) {
    const Arc& arc = arcs_[j];
    const Vec3 below = inside - arc.normal.dot(inside) * arc.normal;
    const double length = below.norm();
    if (length > nearest && is_on(arc, below / length)) {
      nearest = length;
      is_end = false;
      start = {j, true, arc.normal.dot(inside) > 0.0, below / length};
    }
    for (const Vec3& end : {arc.a, arc.b}) {
      if (!(end.dot(inside) > nearest)) continue;
      nearest = end.dot(inside);
      is_end = true;
      start.from = end;
    }
  }
  if (!is_end) return nearest > -2.0;
  const Vec3 back = inside - start.from.dot(inside) * start.from;
  const double length = back.norm();
  if (!(length > kSameDirection)) return false;
  start = turn(start.from, back / length, start.from.cross(back / length), true).walk;
  return start.arc >= 0;
}

// The piece that began where the walk is now; -1: none.
int TangentCone::find_repeated_piece(const Walk& here) const {
  for (int i = 1; i < piece_count_; ++i) {
    const Walk& before = walks_[i];
    if (before.is_along(here) && (before.from - here.from).norm() <= 2.0 * kSameDirection) return i;
  }
  return -1;
}

// At a needle between two directions that count as equal, the walk turns back. So if the walk does not return to its start, the ends of
// arcs are joined and it is repeated. If that does not help, the ends stay as they were.
bool TangentCone::find_boundary(const Vec3& inside) {
  if (walk_boundary(inside) && is_around_start_) return true;
  const int count = arc_count_;
  std::copy(arcs_.begin(), arcs_.begin() + count, arcs_before_join_.begin());
  join_ends();
  if (walk_boundary(inside) && is_around_start_) return true;
  std::copy(arcs_before_join_.begin(), arcs_before_join_.begin() + count, arcs_.begin());
  arc_count_ = count;
  return walk_boundary(inside);
}

// Between arcs that cross at a very small angle, the start may be on a piece to which no other piece leads. The boundary is then the part
// that the walk repeats.
bool TangentCone::walk_boundary(const Vec3& inside) {
  piece_count_ = 0;
  is_around_start_ = true;
  Walk start;
  if (!find_start(inside, start)) return false;
  Walk here = start;
  while (piece_count_ < kMaxPieces) {
    if (const int repeated = find_repeated_piece(here); repeated > 0) {
      std::copy(pieces_.begin() + repeated, pieces_.begin() + piece_count_, pieces_.begin());
      piece_count_ -= repeated;
      is_around_start_ = false;
      return true;
    }
    walks_[piece_count_] = here;
    const Arc& own = arcs_[here.arc];
    Piece& piece = pieces_[piece_count_++];
    piece.from = here.from;
    piece.to = find_end(here.arc, here.ahead, here.from);
    piece.normal = here.on_normal ? own.normal : Vec3(-own.normal);
    const bool is_on_start_arc = piece_count_ > 1 && here.is_along(start);
    if (is_on_start_arc && (here.from - start.from).norm() <= 2.0 * kSameDirection) {  // the loop is closed
      --piece_count_;
      return true;
    }
    const bool is_to_start = (piece.to - start.from).norm() <= 2.0 * kSameDirection || start.from.dot(here.from) >= piece.to.dot(here.from);
    if (is_on_start_arc && is_to_start && start.from.dot(tangent(own.normal, here.from, here.ahead)) > 0.0) {
      piece.to = start.from;
      piece.back = tangent(own.normal, start.from, !here.ahead);
      piece.opening = std::numbers::pi;
      return true;
    }
    piece.back = tangent(own.normal, piece.to, !here.ahead);
    const bool is_end = (piece.to - (here.ahead ? own.b : own.a)).norm() <= 2.0 * kSameDirection;
    const Turn next_turn = turn(piece.to, piece.back, piece.normal, is_end);
    if (next_turn.walk.arc < 0) return false;
    piece.opening = next_turn.opening;
    here = next_turn.walk;
  }
  return false;
}

bool TangentCone::is_reentrant() const {
  return std::ranges::any_of(boundary(), [](const Piece& piece) { return piece.opening > std::numbers::pi + kClosed; });
}

bool TangentCone::contains(const Vec3& direction) const {
  Walk start;
  if (!find_start(direction, start)) return false;
  const Vec3& normal = arcs_[start.arc].normal;
  const Vec3 up = start.on_normal ? normal : Vec3(-normal);
  return std::ranges::any_of(boundary(), [&](const Piece& piece) {
    if ((piece.normal - up).squaredNorm() > kClosed * kClosed) return false;  // the piece is on another arc, or the other side of this one
    const Vec3 axis = piece.from.cross(piece.to);
    const bool is_past_from = piece.from.cross(start.from).dot(axis) >= 0.0 || (start.from - piece.from).norm() <= kSameDirection;
    const bool is_before_to = start.from.cross(piece.to).dot(axis) >= 0.0 || (start.from - piece.to).norm() <= kSameDirection;
    return is_past_from && is_before_to;
  });
}

TangentCone::Steepest TangentCone::find_steepest(const Vec3& pull, double below) const {
  Steepest best;
  best.slope = -std::numeric_limits<double>::infinity();
  const auto offer = [&](const Vec3& direction, int piece) {
    const double slope = direction.dot(pull);
    if (slope > best.slope && slope < below) best = {slope, direction, piece};
  };
  for (int i = 0; i < piece_count_; ++i) {
    const Piece& piece = pieces_[i];
    offer(piece.to, i);
    const Vec3 along = pull - piece.normal.dot(pull) * piece.normal;
    const double length = along.norm();
    const Vec3 axis = piece.from.cross(piece.to);
    if (!(length > 0.0)) continue;
    // If the pull is nearly normal to the piece, most of the difference is rounding: removes the part along the normal once more.
    const Vec3 rough = along / length;
    const Vec3 direction = (rough - piece.normal.dot(rough) * piece.normal).normalized();
    if (piece.from.cross(direction).dot(axis) > 0.0 && direction.cross(piece.to).dot(axis) > 0.0) offer(direction, i);
  }
  return best;
}

}  // namespace hapton
