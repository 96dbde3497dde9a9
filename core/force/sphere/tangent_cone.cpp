#include "core/force/sphere/tangent_cone.h"

#include <cmath>
#include <numbers>

namespace hapton {
namespace {

constexpr double kSame = 0x1p-30;  // rad: directions nearer to each other are one

Vec3 tangent(const Vec3& normal, const Vec3& at, bool ahead) { return ahead ? Vec3(normal.cross(at)) : Vec3(at.cross(normal)); }

}  // namespace

void TangentCone::begin(const Vec3& apex) {
  apex_ = apex;
  arc_count_ = 0;
  piece_count_ = 0;
}

bool TangentCone::add_arc(const Vec3& a, const Vec3& b) {
  const Vec3 normal = a.cross(b);
  const double length = normal.norm();
  if (!(length > kSame)) return true;  // a needle covers nothing
  if (arc_count_ == kMostArcs) return false;
  arcs_[static_cast<std::size_t>(arc_count_++)] = {a, b, normal / length};
  return true;
}

bool TangentCone::add(const ContactTriangle& shape, double near) {
  if (shape.normal().isZero(0.0)) return true;
  const int before = arc_count_;
  if (add_arcs(shape, near)) return true;
  arc_count_ = before;
  return false;
}

// No arc is longer than a quarter, or than a corner of a triangle.
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
  return arc.normal.cross(arc.a).dot(direction) > -kSame && arc.b.cross(arc.normal).dot(direction) > -kSame &&
         std::fabs(arc.normal.dot(direction)) <= kSame;
}

// The end of the arc, or where another one meets it before.
Vec3 TangentCone::find_stop(int arc, bool ahead, const Vec3& from) const {
  const Arc& own = arcs_[static_cast<std::size_t>(arc)];
  Vec3 stop = ahead ? own.b : own.a;
  double nearest = from.dot(stop) + kSame * kSame;
  const Vec3 forward = tangent(own.normal, from, ahead);
  for (int j = 0; j < arc_count_; ++j) {
    const Arc& other = arcs_[static_cast<std::size_t>(j)];
    const Vec3 both = own.normal.cross(other.normal);
    const double length = both.norm();
    if (j == arc || !(length > kSame)) continue;
    for (const double sign : {1.0, -1.0}) {
      const Vec3 at = both * (sign / length);
      if (!(at.dot(forward) > kSame) || !(at.dot(from) > nearest) || !is_on(own, at) || !is_on(other, at)) continue;
      nearest = at.dot(from);
      stop = at;
    }
  }
  return stop;
}

// The first piece that is met when turning from `back` through `up` about `at`.
TangentCone::Turn TangentCone::find_turn(const Vec3& at, const Vec3& back, const Vec3& up) const {
  Turn first;
  first.opening = std::numeric_limits<double>::infinity();
  for (int j = 0; j < arc_count_; ++j) {
    const Arc& arc = arcs_[static_cast<std::size_t>(j)];
    const bool begins = (arc.a - at).norm() <= 2.0 * kSame;
    const bool ends = (arc.b - at).norm() <= 2.0 * kSame;
    if (!begins && !ends && !is_on(arc, at)) continue;
    for (const bool ahead : {true, false}) {
      if (ahead ? ends : begins) continue;
      const Vec3 way = tangent(arc.normal, at, ahead);
      double angle = std::atan2(way.dot(up), way.dot(back));
      if (angle <= kSame) angle += 2.0 * std::numbers::pi;
      if (angle >= first.opening) continue;
      first = {j, ahead, angle};
    }
  }
  return first;
}

// The arc whose own nearest place is nearest: nothing lies between.
bool TangentCone::find_start(const Vec3& inside, int& arc, Vec3& direction) const {
  double nearest = -1.0;
  arc = -1;
  for (int j = 0; j < arc_count_; ++j) {
    const Arc& other = arcs_[static_cast<std::size_t>(j)];
    const Vec3 below = inside - other.normal.dot(inside) * other.normal;
    const double length = below.norm();
    if (!(length > nearest) || !is_on(other, below / length)) continue;
    nearest = length;
    direction = below / length;
    arc = j;
  }
  return arc >= 0;
}

bool TangentCone::find_border(const Vec3& inside) {
  piece_count_ = 0;
  int arc = -1;
  Vec3 start;
  if (!find_start(inside, arc, start)) return false;
  const int first = arc;
  const bool first_side = arcs_[static_cast<std::size_t>(arc)].normal.dot(inside) > 0.0;
  bool ahead = true;
  bool on_normal = first_side;
  Vec3 from = start;
  while (piece_count_ < kMostPieces) {
    const Arc& own = arcs_[static_cast<std::size_t>(arc)];
    Piece& piece = pieces_[static_cast<std::size_t>(piece_count_++)];
    piece.from = from;
    piece.to = find_stop(arc, ahead, from);
    piece.normal = on_normal ? own.normal : Vec3(-own.normal);
    piece.back = tangent(own.normal, piece.to, !ahead);
    if (piece_count_ > 1 && arc == first && ahead && on_normal == first_side) {
      const Vec3 forward = tangent(own.normal, from, true);
      if (start.dot(forward) > -kSame && start.dot(from) >= piece.to.dot(from)) {  // it has come round
        piece.to = start;
        piece.back = tangent(own.normal, start, false);
        piece.opening = std::numbers::pi;
        return true;
      }
    }
    const Turn turn = find_turn(piece.to, piece.back, piece.normal);
    if (turn.arc < 0) return false;
    piece.opening = turn.opening;
    const Vec3 to_free = std::sin(turn.opening) * piece.back - std::cos(turn.opening) * piece.normal;
    from = piece.to;
    arc = turn.arc;
    ahead = turn.ahead;
    on_normal = arcs_[static_cast<std::size_t>(arc)].normal.dot(to_free) > 0.0;
  }
  return false;
}

TangentCone::Steepest TangentCone::find_steepest(const Vec3& pull) const {
  Steepest best;
  best.slope = -std::numeric_limits<double>::infinity();
  const auto offer = [&](const Vec3& direction, int piece) {
    const double slope = direction.dot(pull);
    if (slope > best.slope) best = {slope, direction, piece};
  };
  for (int i = 0; i < piece_count_; ++i) {
    const Piece& piece = pieces_[static_cast<std::size_t>(i)];
    offer(piece.to, i);
    const Vec3 below = pull - piece.normal.dot(pull) * piece.normal;
    const double length = below.norm();
    const Vec3 axis = piece.from.cross(piece.to);
    if (length > 0.0 && piece.from.cross(below).dot(axis) > 0.0 && below.cross(piece.to).dot(axis) > 0.0) offer(below / length, i);
  }
  return best;
}

}  // namespace hapton
