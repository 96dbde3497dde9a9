#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// A point that walks over a mesh, straight on within triangles and across edges (the way unfolded flat is a straight line).
// At a border, at an edge of three or more triangles and at a triangle without area it turns back like light from a mirror.
// Where two triangles are wound against each other the side it calls outside stays the same.
// RT: set-up only. Units: those of the mesh. The mesh must outlive it.
class SurfaceWalk {
 public:
  explicit SurfaceWalk(const TriangleMesh& mesh);

  // Stands in the middle of a triangle, heading along its first edge turned by heading_rad. Pre: the triangle has area.
  void start(std::uint32_t triangle, double heading_rad);

  // Walks on by a length, at most through ten thousand triangles.
  void advance(double length);

  // Turns left by an angle, seen from outside.
  void turn(double angle_rad);

  bool has_area(std::uint32_t triangle) const;
  const Vec3& point() const { return point_; }
  const Vec3& heading() const { return heading_; }  // unit, in the triangle's plane
  Vec3 normal() const;                              // unit, of the triangle stood on, on the side it started on
  std::uint32_t triangle() const { return triangle_; }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  Vec3 face_normal(std::uint32_t triangle) const;
  void cross_edge(int edge);

  const TriangleMesh& mesh_;
  std::vector<std::array<std::uint32_t, 3>> neighbour_;  // across edge k: 4-byte triangle index, or kNone
  std::uint32_t triangle_ = 0;
  int entry_ = -1;     // the edge just crossed, not to be left by at once
  double side_ = 1.0;  // -1 after an edge of two triangles wound against each other
  Vec3 point_ = Vec3::Zero();
  Vec3 heading_ = Vec3::UnitX();
};

}  // namespace hapton
