#pragma once

#include <cstdint>

#include "core/force/sphere/centre_path.h"
#include "core/geometry/contact_triangle.h"

namespace hapton {

// A contact of a sphere's centre with the offset surface of a triangle: the surface at the distance `offset` from it. Its parts are a
// plane over the face, a cylinder around each edge and a sphere around each corner; its normal is continuous. A contact is on one part.
//
// Units and frame: those of the triangle's corners. RT: yes.
struct OffsetContact {
  Feature part = Feature::face;
  std::uint32_t triangle = 0;
  ContactTriangle shape;
  int index = 0;               // of the edge or corner in `shape`; face: 0
  Vec3 normal = Vec3::Zero();  // face: unit, towards the centre
  double multiplier = 0.0;     // centre - device is the sum of multiplier * normal of all active contacts
  Vec3 axis = Vec3::Zero();    // edge: unit; else zero
  bool back = false;           // face: the contact is on the back of the triangle

  // A contact on the part of the triangle that is closest to c; on a face, on the side of the face where c is.
  static OffsetContact nearest(std::uint32_t triangle, const ContactTriangle& shape, const Vec3& c) noexcept;
  // `towards`: a vector that points from the face to the side of the centre.
  static OffsetContact on_face(std::uint32_t triangle, const ContactTriangle& shape, const Vec3& towards) noexcept;
  static OffsetContact on_edge(std::uint32_t triangle, const ContactTriangle& shape, int edge) noexcept;
  static OffsetContact on_vertex(std::uint32_t triangle, const ContactTriangle& shape, int corner) noexcept;

  bool is_curved() const { return part != Feature::face; }
  const Vec3& origin() const { return shape.corner(index); }
  const Vec3& end() const { return shape.corner((index + 1) % 3); }  // of the edge

  // Distance and direction of a centre from the plane, line or point that carries the part. Of a plane the distance is signed.
  struct Proximity {
    double distance = 0.0;
    Vec3 normal = Vec3::Zero();  // unit, towards the centre; at distance 0 of a line or point: X
  };
  Proximity proximity(const Vec3& c) const noexcept;

  // The curvature of the offset surface along a unit tangent; 0 for a plane, up to 1 / offset.
  double curvature(const Vec3& tangent, double offset) const noexcept;

  // The guide that keeps a path on this part.
  CentrePath::Guide guide(double offset) const noexcept;

  // Whether another triangle has the same face, edge or corner. Compares coordinates, so duplicated vertices count.
  bool is_shared_with(const ContactTriangle& other) const noexcept {
    return is_shared_with(other.corner(0), other.corner(1), other.corner(2));
  }
  bool is_shared_with(const Vec3& a, const Vec3& b, const Vec3& c) const noexcept;  // the corners of the other triangle
  // Whether both are on the same edge or corner, also of different triangles. False for faces.
  bool is_same_part(const OffsetContact& other) const noexcept;
};

}  // namespace hapton
