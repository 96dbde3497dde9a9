// A centre that represents a point, in a slit.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/force/sphere/sphere_follower.h"

namespace hapton {

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
    if (std::any_of(contacts_.all().begin(), contacts_.all().end(), is_same)) contacts_.remove(i);
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
