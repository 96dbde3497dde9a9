#pragma once

#include <span>

#include "core/force/sphere/contact_set.h"
#include "core/force/sphere/gathered_triangles.h"

namespace hapton {

// Whether planes alone hold a sphere's centre. A view: contacts, gathered triangles, centre and `work` outlive this object. `work` is
// raised by the units of work used (step_work.h).
//
// Frame and units: TouchGeometry's local ones. RT: yes.
class Wedge {
 public:
  // In offsets: the largest length of a way out of a minimum, a flight over a barrier with its lift (SphereFollower::leave_by_flight).
  static constexpr double kFarthest = 64.0 * 32.0 + 32.0 * 32.0;

  Wedge(const ContactSet& contacts, GatheredTriangles& near, const Vec3& centre, int& work)
      : contacts_(contacts), near_(near), centre_(centre), work_(work) {}

  // Whether, within kFarthest of the centre, the free space is the wedge or corner between the planes that hold it: the faces in each plane
  // reach that far or to below another of these planes, and all other triangles are outside of the wedge. A wedge is convex, so no barrier
  // hides a nearer minimum. False also where the gathered triangles do not reach that far.
  bool holds() noexcept;
  // A face that has the contact's edge or vertex and that the centre is over, in contact with it. Returns its slot in `near`; -1: none.
  int find_face_there(const OffsetContact& contact) noexcept;

 private:
  // A plane that holds the centre; the centre is above it.
  struct Wall {
    Vec3 normal = Vec3::Zero();  // unit
    Vec3 origin = Vec3::Zero();

    double height(const Vec3& p) const { return normal.dot(p - origin); }
  };

  bool find_wall(const OffsetContact& contact, Wall& wall) noexcept;
  bool is_covered(const Wall& wall, std::span<const Wall> walls, std::span<const int> slots, double reach) noexcept;
  bool is_outside_wedge(const ContactTriangle& shape, std::span<const Wall> walls) const noexcept;

  const ContactSet& contacts_;
  GatheredTriangles& near_;
  const Vec3& centre_;
  int& work_;
};

}  // namespace hapton
