#include "core/force/sphere/wedge.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hapton {

bool Wedge::holds() noexcept {
  const double reach = kFarthest * contacts_.offset();
  if (contacts_.count() < 2 || contacts_.count() > 3 || !near_.covers(centre_, reach)) return false;
  std::array<Wall, 3> held_by;
  for (int i = 0; i < contacts_.count(); ++i) {
    if (!find_wall(contacts_[i], held_by[i])) return false;
  }
  const std::span<const Wall> walls = std::span(held_by).first(contacts_.count());
  constexpr int kMaxNear = 64;  // triangles; with more it is not a wedge
  std::array<int, kMaxNear> near_slots;
  int count = 0;
  bool is_wedge = true;
  near_.visit_near(centre_, centre_, reach, [&](int slot) {
    ++work_;
    const ContactTriangle& shape = near_.shape(slot);
    is_wedge = is_wedge && count < kMaxNear && (is_outside_wedge(shape, walls) || shape.separation(centre_).distance > reach);
    if (is_wedge) near_slots[count++] = slot;
  });
  const std::span<const int> slots = std::span(near_slots).first(count);
  return is_wedge && std::ranges::all_of(walls, [&](const Wall& wall) { return is_covered(wall, walls, slots, reach); });
}

// The plane of the face that a contact is on; for an edge or a vertex, that of a face there which the centre is over, at the offset.
bool Wedge::find_wall(const OffsetContact& contact, Wall& wall) noexcept {
  if (contact.part == Feature::face) {
    wall = {contact.normal, contact.origin()};
    return true;
  }
  const int slot = find_face_there(contact);
  if (slot >= 0) wall = {near_.shape(slot).separation(centre_).normal, near_.shape(slot).corner(0)};
  return slot >= 0;
}

int Wedge::find_face_there(const OffsetContact& contact) noexcept {
  int found = -1;
  near_.visit_near(centre_, centre_, contacts_.offset() + contacts_.clearance().slop, [&](int slot) {
    ++work_;
    const ContactTriangle& shape = near_.shape(slot);
    if (found >= 0 || !contact.is_shared_with(shape) || !near_.can_touch(near_.triangle(slot), shape, centre_)) return;
    const Separation at = shape.separation(centre_);
    if (at.feature == Feature::face && std::fabs(at.distance - contacts_.offset()) <= 0.25 * contacts_.clearance().slop) found = slot;
  });
  return found;
}

// Whether the faces in the plane of a wall cover the wall up to the distance `reach` from the centre: at each edge of one of them another
// one continues, or the edge is below another wall.
bool Wedge::is_covered(const Wall& wall, std::span<const Wall> walls, std::span<const int> slots, double reach) noexcept {
  const auto is_in_plane = [&](const ContactTriangle& shape) {
    return !shape.normal().isZero(0.0) && std::max({std::fabs(wall.height(shape.corner(0))), std::fabs(wall.height(shape.corner(1))),
                                                    std::fabs(wall.height(shape.corner(2)))}) <= 0.25 * contacts_.clearance().slop;
  };
  const auto is_below_another = [&](const Vec3& p, const Vec3& q) {
    return std::ranges::any_of(walls, [&](const Wall& other) {
      return &other != &wall && std::max(other.height(p), other.height(q)) <= 0.25 * contacts_.clearance().slop;
    });
  };
  // Whether `other` has edge k of `shape`, and lies on the other side of that edge.
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
      if ((nearest - centre_).norm() > reach || is_below_another(p, q)) continue;
      const auto continues_there = [&](int other) {
        const ContactTriangle& beside = near_.shape(other);
        return continues(beside, shape, k) && is_in_plane(beside) && near_.can_touch(near_.triangle(other), beside, centre_);
      };
      if (std::ranges::none_of(slots, continues_there)) return false;
    }
  }
  return any;
}

// Whether some plane through the line where two of the walls meet has the triangle below it and the wedge above it. The heights over that
// plane are means of those over the two walls: searches for a weight for which all three corners are below.
bool Wedge::is_outside_wedge(const ContactTriangle& shape, std::span<const Wall> walls) const noexcept {
  const double rounding = 0.25 * contacts_.clearance().slop;
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
