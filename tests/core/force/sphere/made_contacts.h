#pragma once

#include <random>

#include "core/force/sphere/contact_set.h"

namespace hapton {

// A centre at a minimum that contacts hold, for a device below it.
struct HeldCentre {
  ContactSet contacts;
  Vec3 centre;
  Vec3 device;
};

// Random contacts with parts of triangles of about unit size; the centre is near each of these parts.
class MadeContacts {
 public:
  static constexpr double kOffset = 0.25;
  static constexpr Clearance kClearance{kOffset, 0x1p-40, 0x1p-46};

  explicit MadeContacts(std::uint64_t seed) : random_(seed) {}

  double unit() { return unit_(random_); }
  Vec3 vector() {
    const double x = unit();
    const double y = unit();
    return {x, y, unit()};
  }
  // A part whose plane, line or point is an offset from c, to within `off`. `side` points from the part towards c.
  OffsetContact contact(std::uint32_t triangle, Feature part, const Vec3& c, const Vec3& side, double off) {
    const Vec3 normal = side.normalized();
    const Vec3 foot = c - (kOffset + off * unit()) * normal;
    const Vec3 u = normal.unitOrthogonal();
    const Vec3 v = normal.cross(u);
    const double turn = 3.0 * unit();
    const Vec3 along = std::cos(turn) * u + std::sin(turn) * v;
    const Vec3 across = normal.cross(along);
    if (part == Feature::face)
      return OffsetContact::on_face(triangle, {foot - along - across, foot + along - across, foot + across}, normal);
    const Vec3 down = foot - 0.5 * normal + 0.3 * across;
    if (part == Feature::edge) return OffsetContact::on_edge(triangle, {foot - along, foot + along, down}, 0);
    return OffsetContact::on_vertex(triangle, {foot, down + along, down - along}, 0);
  }
  // `count` active contacts, with normals at 30 degrees or more from each other and from each other's plane.
  ContactSet set(int count, const Vec3& c, double off) {
    std::array<Vec3, 3> side;
    double volume = 0.0;
    while (!(volume > 0.3)) {
      for (Vec3& s : side) s = vector().normalized();
      volume = std::fabs(side[0].cross(side[1]).dot(side[2]));
    }
    ContactSet contacts(kClearance);
    for (int i = 0; i < count; ++i) {
      const auto part = static_cast<Feature>(std::uniform_int_distribution<int>(0, 2)(random_));
      contacts.add(contact(static_cast<std::uint32_t>(i), part, c, side[static_cast<std::size_t>(i)], off));
    }
    contacts.activate_all();
    return contacts;
  }
  // A centre held by `count` contacts, with multipliers from 0.02 to 0.1.
  HeldCentre held(int count) {
    const Vec3 c = vector();
    HeldCentre held{set(count, c, 0.0), c, c};
    for (const OffsetContact& contact : held.contacts.active()) held.device -= (0.06 + 0.04 * unit()) * contact.proximity(c).normal;
    return held;
  }

 private:
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> unit_{-1.0, 1.0};
};

// The largest difference between the offset and the distance of the centre from an active contact.
inline double largest_offset_error(const ContactSet& contacts, const Vec3& c) {
  double most = 0.0;
  for (const OffsetContact& contact : contacts.active())
    most = std::max(most, std::fabs(contact.proximity(c).distance - contacts.offset()));
  return most;
}

}  // namespace hapton
