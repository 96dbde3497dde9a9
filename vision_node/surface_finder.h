#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "core/collision/wide_bvh.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Finds the point of a mesh closest to a given point. Builds a tree over the triangles: 0.3 s for a million. Frame, units: the mesh's.
// Threads: const calls from any number of threads. RT: no.
class SurfaceFinder {
 public:
  // Pre: the mesh has at least one triangle.
  explicit SurfaceFinder(std::shared_ptr<const TriangleMesh> mesh);

  struct SurfacePoint {
    Vec3 point = Vec3::Zero();
    std::uint32_t triangle = 0;
    Vec3 barycentric = Vec3::Zero();  // weights of the triangle's corners
  };
  // Pre: p is finite.
  SurfacePoint find_closest(const Vec3& p) const { return find_closest(p, mesh_->vertices, 0.0); }
  // The same for displaced vertices, each at most max_displacement_m from its position in the mesh. The larger max_displacement_m is, the
  // more triangles are checked: in the mesh, all those within max_displacement_m more than the distance found.
  SurfacePoint find_closest(const Vec3& p, std::span<const Vec3> vertices, double max_displacement_m) const;

 private:
  std::shared_ptr<const TriangleMesh> mesh_;
  Vec3 origin_;  // the tree's boxes are relative to it, because they are in single precision
  WideBvh tree_;
};

}  // namespace hapton
