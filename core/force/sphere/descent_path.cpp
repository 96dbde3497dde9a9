#include "core/force/sphere/descent_path.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

// The direction, across the normal and the axis, in which a centre leaves a place straight above an edge (with an axis) or a vertex (with
// none). What a projection leaves of a hint along these is rounding and need not be across them: a second projection keeps what truly is.
Vec3 choose_side(const Vec3& normal, const Vec3& axis, const Vec3& hint) {
  constexpr double kRounding = 0x1p-20;  // share of what the first projection leaves
  const auto project = [&](const Vec3& v) { return Vec3(v - normal.dot(v) * normal - axis.dot(v) * axis); };
  const Vec3 projected = project(hint);
  const Vec3 sideways = project(projected);
  if (sideways.norm() > kRounding * projected.norm()) return sideways;
  return axis.isZero(0.0) ? normal.unitOrthogonal() : axis.cross(normal);
}

}  // namespace

bool DescentPath::make(const Vec3& device, const Vec3& hint, bool is_unstable, CentrePath& path) const noexcept {
  if (contacts_.active_count() == 2) return descend_along_curve(device, hint, is_unstable, path);
  if (contacts_.active_count() != 1) return false;
  const OffsetContact& contact = contacts_[0];
  if (contact.is_curved()) {
    path = roll(contact, device, hint);
    return true;
  }
  Vec3 end = centre_;
  minimum_.solve(device, end, work_);
  path = CentrePath::straight(centre_, end);
  return true;
}

bool DescentPath::return_to_crease(CentrePath& path) const noexcept {
  constexpr double kClose = 0.125;  // offsets: half of how near to its path a centre has to stay (SphereFollower::is_near_path)
  if (contacts_.active_count() != 2 || contacts_[0].part != Feature::face || contacts_[1].part != Feature::face) return false;
  // At a larger angle the slop moves the centre less far: slop / sine.
  const double angle = contacts_.clearance().slop / (kClose * contacts_.offset());
  if (1.0 + contacts_[0].normal.dot(contacts_[1].normal) > 0.5 * angle * angle) return false;
  Vec3 end = centre_;
  if (!contacts_.restore(end, work_) || !((end - centre_).norm() > kClose * contacts_.offset())) return false;
  path = CentrePath::straight(centre_, end);
  return true;
}

// Path around an edge or vertex in the steepest direction: a helix, until the centre is level with the device along the edge, or closest to
// it around the edge. The squared distance from the device is the sum of a part along and a part around the edge, and neither rises.
CentrePath DescentPath::roll(const OffsetContact& contact, const Vec3& device, const Vec3& hint) const noexcept {
  const bool is_edge = contact.part == Feature::edge;
  const Vec3 normal = contact.proximity(centre_).normal;
  const Vec3& axis = contact.axis;
  const Vec3 off = device - contact.origin();
  const double rise = is_edge ? axis.dot(device - centre_) : 0.0;
  const Vec3 across = off - axis.dot(off) * axis;
  Vec3 sideways = across - normal.dot(across) * normal;
  const double ahead = normal.dot(across);
  const double distance = across.norm();
  double side = sideways.norm();
  if (side <= LocalMinimum::kAtMinimum) {
    if (ahead < 0.0 || sideways.isZero(0.0)) sideways = choose_side(normal, axis, hint);
    side = ahead < 0.0 ? 0.0 : side;
  }
  const Vec3 direction = sideways.normalized();
  const double angle = distance > LocalMinimum::kAtMinimum ? std::atan2(side, ahead) : 0.0;
  double turn = std::min(angle, LocalMinimum::kTurn);
  double share = 1.0;
  if (side > LocalMinimum::kAtMinimum) {
    share = std::min(1.0, turn * contacts_.offset() / side);
    if (std::fabs(rise) > LocalMinimum::kAtMinimum) turn = share * side / contacts_.offset();
  }
  const Vec3 up = share * rise * axis;
  const double sine = std::sin(turn);
  const double cosine = std::cos(turn);
  const Vec3 end = centre_ + up + contacts_.offset() * (sine * direction - (1.0 - cosine) * normal);
  CentrePath path = CentrePath::curved(centre_, end, up + contacts_.offset() * turn * direction,
                                       up + contacts_.offset() * turn * (cosine * direction - sine * normal));
  contacts_.guide(path);
  return path;
}

bool DescentPath::descend_along_curve(const Vec3& device, const Vec3& hint, bool is_unstable, CentrePath& path) const noexcept {
  ContactFrame frame;
  if (!contacts_.find_frame(centre_, frame)) return false;
  const double ahead = frame.along.dot(device - centre_);
  if (!is_unstable) return make_curve_piece(ahead < 0.0 ? Vec3(-frame.along) : frame.along, std::fabs(ahead), device, false, path);
  const Vec3 direction = frame.along.dot(hint) < 0.0 ? Vec3(-frame.along) : frame.along;
  return make_curve_piece(direction, 2.0 * LocalMinimum::kAtMinimum, device, true, path) ||
         make_curve_piece(-direction, 2.0 * LocalMinimum::kAtMinimum, device, true, path);
}

bool DescentPath::make_curve_piece(const Vec3& direction, double length, const Vec3& device, bool is_unstable,
                                   CentrePath& path) const noexcept {
  constexpr int kMaxHalvings = 24;       // halvings of the first length; a shorter piece does not count
  constexpr double kRounding = 0x1p-50;  // local units: rounding of a position
  const bool is_straight = contacts_.is_flat();
  ContactFrame here;
  if (!contacts_.find_frame(centre_, here)) return false;
  const double sense = here.along.dot(direction);
  // Makes a piece of the length `ahead`. False: it would end on another curve, or no nearer to the device.
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
    // Half of what the squared distance from the device loses. At the end of a descent this may be nothing, within rounding.
    const double gain = chord.dot(pull - 0.5 * chord);
    if (!(gain > (is_unstable || must_lead_on ? 0.0 : -kRounding * pull.norm()))) return false;
    const Vec3 direction_there = sense < 0.0 ? Vec3(-there.along) : there.along;  // opposite: the curve on the other side of a crest
    if (!(direction_there.dot(direction) > 1.0 - 2.0 * LocalMinimum::kTurn * LocalMinimum::kTurn)) return false;
    if (must_lead_on && !(direction_there.dot(device - end) > 0.0)) return false;
    const double length_there = chord.norm();
    if (!(direction.dot(chord) > 0.5 * length_there)) return false;  // surfaces at a small angle: the end was moved back to a place behind
    path = CentrePath::curved(centre_, end, length_there * direction, length_there * direction_there);
    contacts_.guide(path);
    return true;
  };
  if (!is_straight) {
    // As far as a piece may turn, or to the minimum if that is nearer.
    const double stability = minimum_.find_stability(here, centre_, device);
    const double most = minimum_.longest_on_curve(here, direction);
    const double to_minimum = !is_unstable && stability > LocalMinimum::kMinStability ? length / stability : most;
    length = std::min(to_minimum, most);
    if (to_minimum < most && 8.0 * to_minimum > most && go(most, true)) return true;
  }
  for (int i = 0; i < kMaxHalvings; ++i, length *= 0.5) {
    if (go(length, false)) return true;
  }
  return false;
}

}  // namespace hapton
