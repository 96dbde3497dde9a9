// The centre at a local minimum: its active contacts, until when they stay active, and whether a point would be held there.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/force/sphere/sphere_follower.h"
#include "core/math/straight_motion.h"

namespace hapton {
namespace {

using Part = OffsetContact::Part;

// Which contact of a frame another one replaces, whose normal lies in the span of the frame's: as its multiplier grows, theirs change, and
// that one reaches zero first. `held`: from the device to the centre.
std::size_t find_replaced(const ContactFrame& frame, const Vec3& normal, const Vec3& held) noexcept {
  std::size_t replaced = static_cast<std::size_t>(frame.count) - 1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < static_cast<std::size_t>(frame.count); ++i) {
    const double share = frame.dual[i].dot(normal);
    const double grown = std::max(0.0, frame.dual[i].dot(held)) / share;
    if (!(share > 0.0) || !(grown < least)) continue;
    least = grown;
    replaced = i;
  }
  return replaced;
}

}  // namespace

// At a minimum: activates further contacts that the minimum's velocity would lead into.
void SphereFollower::activate_opposing(const Vec3& device, const Vec3& motion) noexcept {
  while (active_count_ < 3 && active_count_ < contact_count_) {
    const Vec3 rate = find_rate(centre_, device, motion);
    int against = -1;
    double least = 0.0;
    for (int i = active_count_; i < contact_count_; ++i) {
      const double leaves = contacts_[i].proximity(centre_).normal.dot(rate);
      if (!(leaves < least)) continue;
      least = leaves;
      against = i;
    }
    if (against < 0) return;
    std::swap(contacts_[active_count_], contacts_[against]);
    ++active_count_;
    ContactFrame frame;
    if (find_frame(centre_, frame)) continue;
    // It is redundant with the others, and replaces one of them.
    --active_count_;
    const OffsetContact& added = contacts_[active_count_];
    if (!find_frame(centre_, frame)) return;
    contacts_[find_replaced(frame, added.proximity(centre_).normal, centre_ - device)] = added;
    return;
  }
}

// A face alone holds the centre, which is over the face's boundary within rounding, opposite to the device: a minimum of the face, but over
// a convex edge it comes nearer. A point goes over likewise (SurfaceFollower::settle_on_face). False: it is not at the boundary.
bool SphereFollower::roll_off_face() noexcept {
  if (is_point_ || contact_count_ != 1 || contacts_[0].part != Part::face || corner_tries_ > 0) return false;
  const OffsetContact held_by = contacts_[0];
  const ContactTriangle& face = held_by.shape;
  for (int k = 0; k < 3; ++k) {
    const Vec3 outwards = face.edge(k).cross(face.normal()) / face.length(k);
    if (!(std::fabs(outwards.dot(centre_ - face.corner(k))) <= kBalance)) continue;
    ++corner_tries_;  // it may balance at the next place as well
    hint_ = outwards;
    contacts_[0] = OffsetContact::on_edge(held_by.triangle, face, k);
    is_descending_ = true;
    return true;
  }
  return false;
}

// A minimum about to vanish moves too fast to follow, but has not vanished yet: go on a little later.
SphereFollower::Next SphereFollower::wait(const Vec3& from, const Vec3& to, double& time) const noexcept {
  if (time >= 1.0) return Next::settled;
  time = std::min(1.0, time + 4.0 * kAtAxis / (to - from).norm());
  return Next::again;
}

// Whether the device is on the axis of the active edge or vertex: then all points around it are equally near.
bool SphereFollower::is_on_axis(const Vec3& device) const noexcept {
  return active_count_ == 1 && contacts_[0].is_curved() && contacts_[0].proximity(device).distance <= kAtAxis;
}

// The first time after `time` at which the device is so far off that axis that its direction counts; 1: not before the end.
double SphereFollower::time_off_axis(const Vec3& from, const Vec3& to, double time) const noexcept {
  const OffsetContact& contact = contacts_[0];
  const Vec3 axis = contact.part == Part::edge ? contact.axis() : Vec3(Vec3::Zero());
  const auto across = [&](const Vec3& v) { return Vec3(v - axis.dot(v) * axis); };
  const Vec3 off = across(on_path(from, to, time) - contact.origin());
  const Vec3 motion = across(to - from);
  // |off + s motion| = 4 kAtAxis
  const double a = motion.squaredNorm();
  const double b = off.dot(motion);
  const double c = 16.0 * kAtAxis * kAtAxis - off.squaredNorm();
  if (!(a > 0.0)) return 1.0;
  return std::min(1.0, time + c / (b + std::sqrt(b * b + a * c)));
}

// Held by three contacts: multipliers are affine in time.
SphereFollower::Next SphereFollower::stay(const Vec3& from, const Vec3& to, double& time) noexcept {
  ContactFrame frame;
  if (!find_frame(centre_, frame)) return Next::failed;
  const Vec3 now = centre_ - on_path(from, to, time);
  const Vec3 then = centre_ - to;
  int released = -1;
  double soonest = 1.0;
  for (int i = 0; i < 3; ++i) {
    const double at_end = frame.dual[i].dot(then);
    if (!(at_end < -kAtMinimum)) continue;
    const double at_start = std::max(0.0, frame.dual[i].dot(now));
    const double share = at_start / (at_start - at_end);
    if (released >= 0 && share >= soonest) continue;
    released = i;
    soonest = share;
  }
  const double opens = time_to_corner_exit(from, to, time);
  if (opens <= 1.0 && (released < 0 || opens < time + soonest * (1.0 - time))) {
    time = opens;
    // A failed attempt is not repeated in this step.
    ++corner_tries_;
    if (!leave_minimum(on_path(from, to, time), to - from) && has_escapes_left_) --corner_tries_;
    return Next::again;
  }
  if (released < 0) {
    time = 1.0;
    return Next::settled;
  }
  ++idle_;
  if (soonest > 0.0) idle_ = 0;
  least_distance_ = std::numeric_limits<double>::infinity();
  time = std::min(1.0, time + soonest * (1.0 - time));
  remove_contact(released);
  is_descending_ = true;
  return Next::again;
}

// Whether a climb by kShallow leads out of a minimum: along the contacts on edges and vertices without one of them, away from that one.
// The path climbs with slope a and turns down with curvature b: its height is a^2 / 2b.
bool SphereFollower::is_shallow(const Vec3& device, Vec3& direction) const noexcept {
  ContactFrame all;
  if (contact_count_ < 2 || !find_frame(centre_, all)) return false;
  for (int j = 0; j < active_count_; ++j) {
    ContactFrame others;
    std::array<const OffsetContact*, 2> by{};
    for (int i = 0; i < active_count_; ++i) {
      if (i == j) continue;
      by[static_cast<std::size_t>(others.count)] = &contacts_[i];
      others.normal[static_cast<std::size_t>(others.count++)] = all.normal[i];
    }
    if (!others.prepare()) continue;
    const Vec3 off = all.normal[j] - others.normal[0] * others.normal[0].dot(all.normal[j]);
    direction = others.count == 1 ? off : Vec3(others.along * (others.along.dot(all.normal[j]) < 0.0 ? -1.0 : 1.0));
    if (!(direction.norm() > 0.0)) continue;
    direction.normalize();
    const double slope = std::max(0.0, direction.dot(centre_ - device));
    double turn = -1.0;
    for (int i = 0; i < others.count; ++i) {
      turn +=
          std::max(0.0, others.dual[i].dot(centre_ - device)) * by[static_cast<std::size_t>(i)]->curvature(direction, clearance_.offset);
    }
    if (turn > 0.0 && slope * slope <= 2.0 * kShallow * turn) return true;
  }
  return false;
}

void SphereFollower::note_multipliers(const Vec3& device) noexcept {
  ContactFrame frame;
  if (contact_count_ == 0 || !find_frame(centre_, frame)) return;
  for (int i = 0; i < active_count_; ++i) contacts_[i].multiplier = std::max(0.0, frame.dual[i].dot(centre_ - device));
}

}  // namespace hapton
