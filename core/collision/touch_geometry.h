#pragma once

#include <cstdint>
#include <vector>

#include "core/collision/wide_bvh.h"
#include "core/geometry/point_triangle.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// The triangles of a scene made ready for contact: recentred, in tree order, with a bounding volume tree over them.
//
// Local coordinates are metres relative to origin(), rounded to a grid of 2^-51 of the scene's extent. Two such coordinates
// subtract exactly, so edges are exact and normals of the thinnest slivers keep their direction (point_triangle.h).
// Everything scales with extent(): a mesh of a micrometre and one of a thousand kilometres, here or far from the origin,
// give the same bits up to that scale.
// Threads: immutable after construction. RT: queries yes, construction set-up only.
class TouchGeometry {
 public:
  // One mesh a span entry; triangles remember which mesh they came from.
  explicit TouchGeometry(const std::vector<const TriangleMesh*>& meshes);

  const Vec3& origin() const { return origin_; }
  double extent() const { return extent_; }  // diagonal of the bounding box; 0 only for a single point
  std::size_t triangle_count() const { return triangles_.size(); }
  std::size_t bytes() const;
  const WideBvh& tree() const { return tree_; }

  const Vec3& corner(std::uint32_t triangle, int k) const { return vertices_[triangles_[triangle][k]]; }
  Separation separation(std::uint32_t triangle, const Vec3& p) const {
    const Triangle& t = triangles_[triangle];
    return separation_from_triangle(p, vertices_[t[0]], vertices_[t[1]], vertices_[t[2]]);
  }
  // Which of the meshes given to the constructor the triangle belongs to.
  std::uint32_t mesh_of(std::uint32_t triangle) const;

 private:
  Vec3 origin_ = Vec3::Zero();
  double extent_ = 0.0;
  std::vector<Vec3> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint16_t> mesh_of_;  // empty for a single mesh
  WideBvh tree_;
};

}  // namespace hapton
