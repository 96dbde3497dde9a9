// The centre at a local minimum: how it leaves one that has vanished, for how long three contacts hold it, and a point in a slit.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/force/sphere/sphere_follower.h"
#include "core/math/straight_motion.h"

namespace hapton {

// If one face alone holds the centre and, within rounding, the centre is over the face's boundary: moves the contact to the edge. It is at
// a minimum over the face, but may come nearer over a convex edge. Points do so, too (SurfaceFollower::settle_on_face). False: it does not.
bool SphereFollower::roll_off_face() noexcept {
  if (is_point_ || contacts_.count() != 1 || contacts_[0].part != Feature::face || corner_tries_ > 0) return false;
  const OffsetContact held_by = contacts_[0];
  const ContactTriangle& face = held_by.shape;
  for (int k = 0; k < 3; ++k) {
    const Vec3 outwards = PathEvents::edge_of(face, k).direction;
    if (!(std::fabs(outwards.dot(centre_ - face.corner(k))) <= kBalance)) continue;
    ++corner_tries_;  // the centre may balance at the next place, too
    direction_hint_ = outwards;
    contacts_[0] = OffsetContact::on_edge(held_by.triangle, face, k);
    is_descending_ = true;
    return true;
  }
  return false;
}

// A minimum that is about to vanish, but has not yet, moves too fast to follow: moves the device on by a little.
SphereFollower::Next SphereFollower::wait(const Vec3& from, const Vec3& to, double& time) const noexcept {
  if (time >= 1.0) return Next::settled;
  time = std::min(1.0, time + 4.0 * LocalMinimum::kAtAxis / (to - from).norm());
  return Next::again;
}

// The centre is held by three contacts: their multipliers are affine functions of time.
SphereFollower::Next SphereFollower::stay(const Vec3& from, const Vec3& to, double& time) noexcept {
  ContactFrame frame;
  if (!contacts_.find_frame(centre_, frame)) return is_point_ ? stay_within_rounding(to, time) : Next::failed;
  const Vec3 now = centre_ - on_path(from, to, time);
  const Vec3 then = centre_ - to;
  int released = -1;
  double soonest = 1.0;
  for (int i = 0; i < 3; ++i) {
    const double at_end = frame.dual[i].dot(then);
    if (!(at_end < -LocalMinimum::kAtMinimum)) continue;
    const double at_start = std::max(0.0, frame.dual[i].dot(now));
    const double share = at_start / (at_start - at_end);
    if (released >= 0 && share >= soonest) continue;
    released = i;
    soonest = share;
  }
  const double exit_time = is_point_ && corner_tries_ < kMaxCornerTries ? corner().time_to_exit(from, to, time) : 2.0;
  if (exit_time <= 1.0 && (released < 0 || exit_time < time + soonest * (1.0 - time))) {
    time = exit_time;
    // Counts the attempts in this motion, except for one that ran out of work.
    ++corner_tries_;
    if (!leave_minimum(on_path(from, to, time), to - from) && has_untried_escapes_) --corner_tries_;
    return Next::again;
  }
  if (released < 0) {
    time = 1.0;
    return Next::settled;
  }
  ++idle_events_;
  if (soonest > 0.0) idle_events_ = 0;
  least_distance_ = std::numeric_limits<double>::infinity();
  time = std::min(1.0, time + soonest * (1.0 - time));
  contacts_.remove(released);
  is_descending_ = true;
  return Next::again;
}

// The centre is held by three contacts whose normals are in one plane within rounding, as with two faces on one side of a slit and one on
// the other. It is not known how much each of them holds, only whether all together hold the centre.
SphereFollower::Next SphereFollower::stay_within_rounding(const Vec3& to, double& time) noexcept {
  Vec3 descent;
  const bool is_held = contacts_.find_active(centre_, to - centre_, Vec3::Zero(), descent) && descent.norm() <= LocalMinimum::kAtMinimum;
  is_descending_ = !is_held;
  if (!is_held) return time < 1.0 || is_in_narrow_slit() ? Next::wait : Next::failed;
  time = 1.0;
  return Next::settled;
}

// Notes that the minimum along the curve vanishes here. hint: the direction in which the centre was moving.
SphereFollower::Next SphereFollower::lose_minimum(const Vec3& hint) noexcept {
  has_lost_minimum_ = true;
  is_descending_ = true;
  direction_hint_ = hint;
  ++idle_events_;
  return Next::again;
}

// Chooses the direction in which the centre leaves a minimum that has vanished: along direction_hint_, or against it where another contact
// blocks. False: both are blocked.
bool SphereFollower::find_escape_direction(const Vec3& motion) noexcept {
  if (direction_hint_.isZero(0.0)) direction_hint_ = motion;
  ContactFrame frame;
  if (!contacts_.find_frame(centre_, frame)) return true;
  Vec3 direction = contacts_.active_count() == 2 ? Vec3(frame.along * (frame.along.dot(direction_hint_) < 0.0 ? -1.0 : 1.0))
                                                 : Vec3(direction_hint_ - frame.normal[0].dot(direction_hint_) * frame.normal[0]);
  const auto is_open = [&](const Vec3& w) {
    for (int i = contacts_.active_count(); i < contacts_.count(); ++i) {
      if (contacts_[i].proximity(centre_).normal.dot(w) < 0.0) return false;
    }
    return true;
  };
  const bool may_turn = idle_events_ <= kMaxIdleEvents / 4;  // otherwise it could go to and fro between two contacts
  for (const double sign : {1.0, -1.0}) {
    if (!is_open(sign * direction) || (sign < 0.0 && !may_turn)) continue;
    direction_hint_ = sign * direction;
    return true;
  }
  return false;
}

bool SphereFollower::is_in_narrow_slit() const noexcept {
  constexpr double kOpposite = 2.0 - 2.0 * 0.99;  // normals within 8 degrees of opposite: contacts press with at least seven times the pull
  return contacts_.find_most_opposite(centre_) < kOpposite;
}

// In a slit, contacts on nearly opposite sides press with many times the pull, so a small turn of a normal decides where they release the
// centre. For an edge, within the hysteresis at its boundary (PathEvents::kOnBoundary), the normal may be turned by a ten-thousandth beyond
// that of the face that the centre is over. Moves such contacts to the face. True: there were any.
bool SphereFollower::straighten_in_slit() noexcept {
  if (!is_in_narrow_slit() || !near_.covers(centre_, clearance().offset + clearance().slop)) return false;
  bool any = false;
  for (int i = contacts_.active_count() - 1; i >= 0; --i) {
    OffsetContact& contact = contacts_[i];
    const int slot = contact.part == Feature::face ? -1 : wedge().find_face_there(contact);
    if (slot < 0) continue;
    any = true;
    contact = OffsetContact::on_face(near_.triangle(slot), near_.shape(slot), contact.proximity(centre_).normal);
    const auto is_same = [&](const OffsetContact& other) {
      return &other != &contact && other.triangle == contact.triangle && other.part == contact.part;
    };
    if (std::ranges::any_of(contacts_.all(), is_same)) contacts_.remove(i);
  }
  if (any) ++idle_events_;
  return any;
}

// Whether nearly opposite contacts hold the sphere where the point that it stands for might move on: between parallel faces as far apart as
// the sphere is wide, or where the free space is not a wedge between planes.
bool SphereFollower::fills_slit() noexcept {
  constexpr double kOpposite = 2.0 - 2.0 * 0.9;         // normals within 26 degrees of opposite
  constexpr double kParallel = 2.0 / Wedge::kFarthest;  // rad; the tip of a narrower wedge is farther away than any way out leads
  const double sum = contacts_.find_most_opposite(centre_);
  return sum < kOpposite && (sum < kParallel * kParallel || !wedge().holds());
}

// Leaves a slit to sweeps only once for each place and sample: they may lead back here, and their motion may be carried on.
bool SphereFollower::note_slit(bool has_device_moved) noexcept {
  constexpr double kSamePlace = 2.0;  // offsets; as for other escapes, a smaller gain does not count
  if (!has_device_moved && slit_at_ && (centre_ - *slit_at_).norm() <= kSamePlace * clearance().offset) return false;
  slit_at_ = centre_;
  return true;
}

}  // namespace hapton
