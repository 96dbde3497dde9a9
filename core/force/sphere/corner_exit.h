#pragma once

#include <limits>
#include <optional>

#include "core/force/sphere/contact_set.h"
#include "core/force/sphere/gathered_triangles.h"
#include "core/force/sphere/tangent_cone.h"

namespace hapton {

// The corner that holds a small sphere which represents a point: the directions in which the point could leave it (TangentCone), when the
// device first pulls along one of them, and whether the sphere may be placed past it. A view: all that it is made from outlives it.
//
// Frame and units: TouchGeometry's local ones. RT: yes. `work`: is raised by the units of work (step_work.h).
class CornerExit {
 public:
  static constexpr double kThrough = 4.0;  // offsets; a triangle this near to the corner counts as at it, and a crack this narrow as closed
  static constexpr double kMinGain = 2.0;  // offsets; a smaller gain does not count as an escape
  static constexpr double kAbove = 1.25;   // offsets; height above the faces of a position past the corner
  static constexpr double kMaxOff = 4.0;   // a position past the corner is farther from it than this many times its distance off the edge

  // Of the corner that the centre was last held in.
  struct Memory {
    TangentCone cone;
    bool has_cone = false;
    Vec3 at = Vec3::Constant(std::numeric_limits<double>::infinity());  // the centre at that time
  };

  CornerExit(const ContactSet& contacts, GatheredTriangles& near, const Vec3& centre, Memory& memory, int& work)
      : contacts_(contacts), near_(near), centre_(centre), memory_(memory), work_(work) {}

  // Finds the directions in which the point could leave its corner; keeps those found for a centre no farther than `moved` from this one.
  // False: there is no corner, or the boundary of these directions is not found.
  bool find_cone(double moved) noexcept;
  // The cone that find_cone() found last.
  const TangentCone& cone() const { return memory_.cone; }
  // The component of the pull, from apex to device, along an edge that certainly gains kMinGain offsets: a smaller one is no exit.
  double least_exit(const Vec3& pull) const noexcept;
  // The time at which an edge of the corner first leads nearer to a device that moves straight; 2: none does.
  double time_to_exit(const Vec3& from, const Vec3& to, double time) noexcept;

  // Pre of all below: find_cone() was true. How far off the cone's boundary a position in that direction is placed; at an edge it is placed
  // midway between the two pieces of the boundary.
  double distance_off_edge(const TangentCone::Steepest& to) const noexcept;
  // A position at the distance `radius` from the corner in that direction, and off the boundary. None: the cone is too narrow there.
  std::optional<Vec3> find_past(const TangentCone::Steepest& to, double radius) const noexcept;
  // Whether the centre may be moved past the corner in one step: all triangles near it go through the corner, so the free space there is a
  // cone. The target must be in the part of the cone that the centre is in: beside a narrow slit, a position off one side is beyond the
  // other. If the boundary may be that of another part of the cone, no triangle may be between centre and target. The cone has each face's
  // plane moved through the apex: the target must be on the same side of the face as of the moved plane.
  bool can_pass(const Vec3& target, double radius) noexcept;

 private:
  struct EdgeSpan {
    double begin = 0.0, end = 1.0;  // positions on an edge, 0 to 1
  };
  bool find_apex(Vec3& apex) const noexcept;
  bool find_common_corner(Vec3& apex) const noexcept;
  bool find_beside(const Vec3& apex, Vec3& beside) noexcept;
  bool is_beyond_surface(const Vec3& target, double within) noexcept;
  static EdgeSpan edge_span_within(const ContactTriangle& shape, int k, const Vec3& p, double within);

  const ContactSet& contacts_;
  GatheredTriangles& near_;
  const Vec3& centre_;
  Memory& memory_;
  int& work_;
};

}  // namespace hapton
