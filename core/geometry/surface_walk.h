#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// A point that walks over a mesh: straight within triangles and across edges (a straight line on the unfolded surface). It is reflected at
// a boundary, at an edge of three or more triangles and at a triangle without area. Across inconsistently oriented triangles it stays on
// the same side. RT: set-up only. Units: those of the mesh. The mesh must outlive this.
class SurfaceWalk {
 public:
  explicit SurfaceWalk(const TriangleMesh& mesh);

  // Starts in the middle of a triangle, heading along its first edge turned left by heading_rad. Pre: the triangle has area.
  void start(std::uint32_t triangle, double heading_rad);

  // Walks by a length, over at most ten thousand triangles.
  void advance(double length);

  // Turns left by an angle, as seen from the side of normal().
  void turn(double angle_rad);

  bool has_area(std::uint32_t triangle) const;
  const Vec3& point() const { return point_; }
  const Vec3& heading() const { return heading_; }  // unit, in the plane of the current triangle
  Vec3 normal() const;                              // unit, of the current triangle, on the side on which the walk started
  std::uint32_t triangle() const { return triangle_; }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  Vec3 face_normal(std::uint32_t triangle) const;
  void cross_edge(int edge);

  const TriangleMesh& mesh_;
  std::vector<std::array<std::uint32_t, 3>> neighbour_;  // the triangle across edge k, or kNone
  std::uint32_t triangle_ = 0;
  int entry_ = -1;     // the edge just crossed, through which the point does not leave; -1: none
  double side_ = 1.0;  // -1 where the walk is on the back of the triangle, after an edge of two inconsistently oriented ones
  Vec3 point_ = Vec3::Zero();
  Vec3 heading_ = Vec3::UnitX();
};

}  // namespace hapton
