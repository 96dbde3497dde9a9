// The centre at a local minimum: how it leaves one that has vanished, until when three contacts hold it, and a point in a slit.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/force/sphere/sphere_follower.h"
#include "core/math/straight_motion.h"

namespace hapton {

// A face alone holds the centre, which is over the face's boundary within rounding, opposite to the device: a minimum of the face, but over
// a convex edge it comes nearer. A point goes over likewise (SurfaceFollower::settle_on_face). False: it is not at the boundary.
bool SphereFollower::roll_off_face() noexcept {
  if (is_point_ || contacts_.count() != 1 || contacts_[0].part != Feature::face || corner_tries_ > 0) return false;
  const OffsetContact held_by = contacts_[0];
  const ContactTriangle& face = held_by.shape;
  for (int k = 0; k < 3; ++k) {
    const Vec3 outwards = PathEvents::edge_of(face, k).direction;
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
  time = std::min(1.0, time + 4.0 * LocalMinimum::kAtAxis / (to - from).norm());
  return Next::again;
}

// Held by three contacts: multipliers are affine in time.
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
  const double opens = is_point_ && corner_tries_ < kMaxCornerTries ? corner().time_to_exit(from, to, time) : 2.0;
  if (opens <= 1.0 && (released < 0 || opens < time + soonest * (1.0 - time))) {
    time = opens;
    // A failed attempt is not repeated in this step.
    ++corner_tries_;
    if (!leave_minimum(on_path(from, to, time), to - from) && has_untried_escapes_) --corner_tries_;
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
  contacts_.remove(released);
  is_descending_ = true;
  return Next::again;
}

// Held by three contacts whose normals are in one plane within rounding, as two faces of one side of a slit and one of the other: what each
// of them holds is not known, only whether all of them together hold the centre.
SphereFollower::Next SphereFollower::stay_within_rounding(const Vec3& to, double& time) noexcept {
  Vec3 descent;
  const bool is_held = contacts_.find_active(centre_, to - centre_, Vec3::Zero(), descent) && descent.norm() <= LocalMinimum::kAtMinimum;
  is_descending_ = !is_held;
  if (!is_held) return time < 1.0 || is_in_narrow_slit() ? Next::wait : Next::failed;
  time = 1.0;
  return Next::settled;
}

// The minimum along the curve vanishes here; hint: the direction in which the centre came.
SphereFollower::Next SphereFollower::lose_minimum(const Vec3& hint) noexcept {
  has_lost_minimum_ = true;
  is_descending_ = true;
  hint_ = hint;
  ++idle_;
  return Next::again;
}

// Chooses the direction in which the centre leaves a minimum that has vanished: along hint_, or against it where another contact blocks.
// False: both are blocked.
bool SphereFollower::find_escape_direction(const Vec3& motion) noexcept {
  if (hint_.isZero(0.0)) hint_ = motion;
  ContactFrame frame;
  if (!contacts_.find_frame(centre_, frame)) return true;
  Vec3 direction = contacts_.active_count() == 2 ? Vec3(frame.along * (frame.along.dot(hint_) < 0.0 ? -1.0 : 1.0))
                                                 : Vec3(hint_ - frame.normal[0].dot(hint_) * frame.normal[0]);
  const auto is_open = [&](const Vec3& w) {
    for (int i = contacts_.active_count(); i < contacts_.count(); ++i) {
      if (contacts_[i].proximity(centre_).normal.dot(w) < 0.0) return false;
    }
    return true;
  };
  const bool may_turn = idle_ <= kMaxIdle / 4;  // to and fro between two contacts leads nowhere
  for (const double sign : {1.0, -1.0}) {
    if (!is_open(sign * direction) || (sign < 0.0 && !may_turn)) continue;
    hint_ = sign * direction;
    return true;
  }
  return false;
}

bool SphereFollower::is_in_narrow_slit() const noexcept {
  constexpr double kOpposite = 2.0 - 2.0 * 0.99;  // within 8 degrees, where contacts press with seven times the pull and more
  return contacts_.find_most_opposite(centre_) < kOpposite;
}

// In a slit, contacts at nearly opposite sides press with many times the pull, and a small turn of a normal decides where they let the
// centre go. At an edge, within the hysteresis of its boundary (PathEvents::kOnBoundary), the normal may be a ten-thousandth beyond that of
// the face that the centre is over. True: such a contact is on the face now.
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
  if (any) ++idle_;
  return any;
}

// Whether nearly opposite contacts hold the centre where a point would perhaps go on: parallel faces as far apart as the sphere is wide, or
// what is not the wedge of two planes.
bool SphereFollower::fills_slit() noexcept {
  constexpr double kOpposite = 2.0 - 2.0 * 0.9;         // within 26 degrees
  constexpr double kParallel = 2.0 / Wedge::kFarthest;  // rad; the tip of such a wedge is farther off than a way out would lead
  const double sum = contacts_.find_most_opposite(centre_);
  return sum < kOpposite && (sum < kParallel * kParallel || !wedge().holds());
}

// A slit is left to sweeps once for each place and sample: they may lead back here, and their motion be carried on.
bool SphereFollower::note_slit(bool has_device_moved) noexcept {
  constexpr double kSamePlace = 2.0;  // offsets; as for other escapes, a smaller gain is none
  if (!has_device_moved && slit_at_ && (centre_ - *slit_at_).norm() <= kSamePlace * clearance().offset) return false;
  slit_at_ = centre_;
  return true;
}

}  // namespace hapton
