#pragma once

#include <span>

#include "core/force/sphere/contact_set.h"
#include "core/force/sphere/gathered_triangles.h"

namespace hapton {

// Whether planes alone hold a centre. A view: contacts, gathered triangles, centre and `work`, which is raised by the units of work
// (step_work.h), outlive it.
//
// Frame and units: TouchGeometry's local ones. RT: yes.
class Wedge {
 public:
  // Offsets; how far a way out of a minimum would lead: a flight over a barrier, its lift included (SphereFollower::leave_by_flight).
  static constexpr double kFarthest = 64.0 * 32.0 + 32.0 * 32.0;

  Wedge(const ContactSet& contacts, GatheredTriangles& near, const Vec3& centre, int& work)
      : contacts_(contacts), near_(near), centre_(centre), work_(work) {}

  // Whether, as far as a way out would lead, the free space is the wedge or corner of the planes that hold the centre: the faces in each of
  // them go on that far or to below another of the planes, and whatever else is there is not between them. That is convex, so its minimum
  // has no barrier. False also where the gathered triangles do not reach that far.
  bool holds() noexcept;
  // A face at that contact's edge or vertex which the centre is over, as far from it as from the edge. Returns a slot; -1: none.
  int find_face_there(const OffsetContact& contact) noexcept;

 private:
  // A plane that holds the centre, which is above it.
  struct Wall {
    Vec3 normal = Vec3::Zero();  // unit
    Vec3 origin = Vec3::Zero();

    double height(const Vec3& p) const { return normal.dot(p - origin); }
  };

  bool find_wall(const OffsetContact& contact, Wall& wall) noexcept;
  bool goes_on(const Wall& wall, std::span<const Wall> walls, std::span<const int> slots, double far) noexcept;
  bool is_outside_wedge(const ContactTriangle& shape, std::span<const Wall> walls) const noexcept;

  const ContactSet& contacts_;
  GatheredTriangles& near_;
  const Vec3& centre_;
  int& work_;
};

}  // namespace hapton
