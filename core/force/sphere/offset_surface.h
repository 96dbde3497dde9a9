#pragma once

#include <cstdint>

#include "core/force/sphere/centre_path.h"
#include "core/geometry/contact_triangle.h"

namespace hapton {

// A sphere's centre keeps the distance `offset` from a triangle: it stays outside the triangle's offset surface. That is a plane over the
// face, a cylinder round each edge and a sphere round each corner, joined without a kink. One such part holds the centre at a time.
//
// Units and frame: those of the corners. RT: yes.
struct OffsetContact {
  enum class Part : std::uint8_t { face, edge, vertex };

  Part part = Part::face;
  std::uint32_t triangle = 0;
  ContactTriangle shape;
  int index = 0;               // of the edge, or of the corner
  Vec3 normal = Vec3::Zero();  // face: unit, towards the centre
  double multiplier = 0.0;     // centre - device = sum of multiplier * normal
  Vec3 along = Vec3::Zero();   // edge: unit
  bool back = false;           // face: the side the normal does not show

  // The part of the triangle that is nearest to c, with the face's side that c is on.
  static OffsetContact nearest(std::uint32_t triangle, const ContactTriangle& shape, const Vec3& c) noexcept;
  // `towards`: the centre is on this side.
  static OffsetContact on_face(std::uint32_t triangle, const ContactTriangle& shape, const Vec3& towards) noexcept;
  static OffsetContact on_edge(std::uint32_t triangle, const ContactTriangle& shape, int edge) noexcept;
  static OffsetContact on_vertex(std::uint32_t triangle, const ContactTriangle& shape, int corner) noexcept;

  bool is_curved() const { return part == Part::edge || part == Part::vertex; }
  const Vec3& origin() const { return shape.corner(index); }
  const Vec3& axis() const { return along; }  // edge: unit

  // How the centre stands to the plane, line or point that carries the part.
  struct Stand {
    double distance = 0.0;
    Vec3 normal = Vec3::Zero();  // unit, towards the centre
  };
  Stand stand(const Vec3& c) const noexcept;

  // The curvature of the offset surface along a unit tangent, towards the part.
  double curvature(const Vec3& tangent, double offset) const noexcept;

  // What keeps a path on it.
  CentrePath::Guide guide(double offset) const noexcept;

  // Whether another triangle has the same edge or corner: by its place, so that copies count.
  bool is_part_of(const ContactTriangle& other) const noexcept;
};

}  // namespace hapton
