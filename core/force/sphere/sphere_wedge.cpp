// Where planes alone hold the centre: corners that need no way out, and slits.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/force/sphere/sphere_follower.h"

namespace hapton {
namespace {

// Offsets; the path that a flight over a barrier takes, its lift included (SphereFollower::leave_by_flight).
constexpr double kFarthest = 64.0 * 32.0 + 32.0 * 32.0;

}  // namespace

// Whether, as far as a way out would lead, the free space is the wedge or corner of the planes that hold the centre: the faces in each of
// them go on that far or to below another of the planes, and whatever else is there is not between them. That is convex, so its minimum has
// no barrier.
bool SphereFollower::is_in_wedge() noexcept {
  const double far = kFarthest * clearance().offset;
  if (contacts_.count() < 2 || contacts_.count() > 3 || !near_.covers(centre_, far)) return false;
  std::array<Wall, 3> held_by;
  for (int i = 0; i < contacts_.count(); ++i) {
    if (!find_wall(contacts_[i], held_by[static_cast<std::size_t>(i)])) return false;
  }
  const std::span<const Wall> walls(held_by.data(), static_cast<std::size_t>(contacts_.count()));
  constexpr int kMostNear = 64;
  std::array<int, kMostNear> near;
  int count = 0;
  bool is_wedge = true;
  near_.visit_near(centre_, centre_, far, [&](int slot) {
    ++work_;
    const ContactTriangle& shape = near_.shape(slot);
    is_wedge = is_wedge && count < kMostNear && (is_outside_wedge(shape, walls) || shape.separation(centre_).distance > far);
    if (is_wedge) near[static_cast<std::size_t>(count++)] = slot;
  });
  const std::span<const int> slots(near.data(), static_cast<std::size_t>(count));
  return is_wedge && std::all_of(walls.begin(), walls.end(), [&](const Wall& wall) { return goes_on(wall, walls, slots, far); });
}

// The plane of the face that a contact is on; of an edge or a vertex, that of a face there which the centre is over at no other distance.
bool SphereFollower::find_wall(const OffsetContact& contact, Wall& wall) noexcept {
  if (contact.part == OffsetContact::Part::face) {
    wall = {contact.normal, contact.origin()};
    return true;
  }
  const int slot = find_face_there(contact);
  if (slot >= 0) wall = {near_.shape(slot).separation(centre_).normal, near_.shape(slot).corner(0)};
  return slot >= 0;
}

// A face at that edge or vertex which the centre is over, as far from it as from the edge. Returns a slot; -1: none.
int SphereFollower::find_face_there(const OffsetContact& contact) noexcept {
  int found = -1;
  near_.visit_near(centre_, centre_, clearance().offset + clearance().slop, [&](int slot) {
    ++work_;
    const ContactTriangle& shape = near_.shape(slot);
    if (found >= 0 || !contact.is_shared_with(shape) || !near_.can_touch(near_.triangle(slot), shape, centre_)) return;
    const Separation at = shape.separation(centre_);
    if (at.feature == Feature::face && std::fabs(at.distance - clearance().offset) <= 0.25 * clearance().slop) found = slot;
  });
  return found;
}

// In a slit, contacts at nearly opposite sides press with many times the pull, and a small turn of a normal decides where they let the
// centre go. At an edge, within the hysteresis of its boundary (PathEvents::kOnBoundary), the normal may be a ten-thousandth beyond that of
// the face that the centre is over. True: such a contact is on the face now.
bool SphereFollower::straighten_in_slit() noexcept {
  constexpr double kOpposite = 2.0 - 2.0 * 0.99;  // within 8 degrees, where they press with seven times the pull and more
  if (!(contacts_.find_most_opposite(centre_) < kOpposite) || !near_.covers(centre_, clearance().offset + clearance().slop)) return false;
  bool any = false;
  for (int i = contacts_.active_count() - 1; i >= 0; --i) {
    OffsetContact& contact = contacts_[i];
    const int slot = contact.part == OffsetContact::Part::face ? -1 : find_face_there(contact);
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
  constexpr double kOpposite = 2.0 - 2.0 * 0.9;  // within 26 degrees
  constexpr double kParallel = 2.0 / kFarthest;  // rad; the tip of such a wedge is farther off than a way out would lead
  const double sum = contacts_.find_most_opposite(centre_);
  return sum < kOpposite && (sum < kParallel * kParallel || !is_in_wedge());
}

// Once for each place and sample: sweeps may lead back here, and their motion be carried on. False: there is no slit, or it was left so.
bool SphereFollower::leave_slit_to_sweeps(bool has_device_moved) noexcept {
  constexpr double kSamePlace = 2.0;  // offsets; as for other escapes, a smaller gain is none
  if (!fills_slit()) return false;
  if (!has_device_moved && slit_at_ && (centre_ - *slit_at_).norm() <= kSamePlace * clearance().offset) return false;
  slit_at_ = centre_;
  return true;
}

// Whether the faces in the plane of a wall cover it that far from the centre: where one of them ends, another goes on, or the edge is below
// another wall.
bool SphereFollower::goes_on(const Wall& wall, std::span<const Wall> walls, std::span<const int> slots, double far) noexcept {
  const auto is_in_plane = [&](const ContactTriangle& shape) {
    return !shape.normal().isZero(0.0) && std::max({std::fabs(wall.height(shape.corner(0))), std::fabs(wall.height(shape.corner(1))),
                                                    std::fabs(wall.height(shape.corner(2)))}) <= 0.25 * clearance().slop;
  };
  const auto is_below_another = [&](const Vec3& p, const Vec3& q) {
    return std::any_of(walls.begin(), walls.end(), [&](const Wall& other) {
      return &other != &wall && std::max(other.height(p), other.height(q)) <= 0.25 * clearance().slop;
    });
  };
  // On the other side of the edge.
  const auto continues = [&](const ContactTriangle& other, const ContactTriangle& shape, int k) {
    bool has_beyond = false;
    int shared = 0;
    for (int m = 0; m < 3; ++m) {
      const bool is_end = other.corner(m) == shape.corner(k) || other.corner(m) == shape.corner((k + 1) % 3);
      shared += is_end ? 1 : 0;
      has_beyond |= !is_end && shape.inside(k, other.corner(m)) < 0.0;
    }
    return shared == 2 && has_beyond;
  };
  bool any = false;
  for (const int slot : slots) {
    const ContactTriangle shape = near_.shape(slot);  // a copy: others are prepared in the loop
    if (!is_in_plane(shape) || !near_.can_touch(near_.triangle(slot), shape, centre_)) continue;
    any = true;
    for (int k = 0; k < 3; ++k) {
      const Vec3& p = shape.corner(k);
      const Vec3& q = shape.corner((k + 1) % 3);
      const Vec3 nearest = p + std::clamp(shape.along(k, centre_), 0.0, 1.0) * shape.edge(k);
      if ((nearest - centre_).norm() > far || is_below_another(p, q)) continue;
      const auto goes_on_there = [&](int other) {
        const ContactTriangle& beside = near_.shape(other);
        return continues(beside, shape, k) && is_in_plane(beside) && near_.can_touch(near_.triangle(other), beside, centre_);
      };
      if (std::none_of(slots.begin(), slots.end(), goes_on_there)) return false;
    }
  }
  return any;
}

// Whether a plane through the line where two of the walls meet has the triangle below and the wedge above it. Its heights are means of
// those over the two, with a weight for which all three corners are below.
bool SphereFollower::is_outside_wedge(const ContactTriangle& shape, std::span<const Wall> walls) const noexcept {
  const double rounding = 0.25 * clearance().slop;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    for (std::size_t j = i + 1; j < walls.size(); ++j) {
      double least = 0.0;
      double most = 1.0;
      for (int k = 0; k < 3; ++k) {
        const double first = walls[i].height(shape.corner(k)) - rounding;
        const double second = walls[j].height(shape.corner(k)) - rounding;
        // first + weight (second - first) <= 0
        if (first > 0.0) least = second < 0.0 ? std::max(least, first / (first - second)) : 2.0;
        if (first <= 0.0 && second > 0.0) most = std::min(most, first / (first - second));
      }
      if (least <= most) return true;
    }
  }
  return false;
}

}  // namespace hapton
