#pragma once

#include <cstdint>
#include <vector>

#include "core/collision/wide_bvh.h"
#include "core/geometry/point_triangle.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// The triangles of a scene made ready for contact: recentred, in tree order, with a bounding volume tree over them.
//
// Local coordinates are relative to origin() in units of unit_m(), the power of two that puts the scene's diagonal into [1, 2), and
// rounded to a grid of 2^-51. Two such coordinates subtract exactly, so edges are exact and the normals of the thinnest slivers keep
// their direction (point_triangle.h). A mesh of a micrometre and one of a thousand kilometres, here or far from the origin, have
// the same local coordinates, so every tolerance can be a plain number.
// Threads: immutable after construction. RT: queries yes, construction set-up only.
class TouchGeometry {
 public:
  // One mesh a span entry; triangles remember which mesh they came from.
  explicit TouchGeometry(const std::vector<const TriangleMesh*>& meshes);

  const Vec3& origin() const { return origin_; }
  double unit_m() const { return unit_m_; }
  Vec3 to_local(const Vec3& p_S) const { return (p_S - origin_) / unit_m_; }
  Vec3 to_scene(const Vec3& local) const { return local * unit_m_ + origin_; }
  std::size_t triangle_count() const { return triangles_.size(); }
  std::size_t bytes() const;
  const WideBvh& tree() const { return tree_; }

  const Vec3& corner(std::uint32_t triangle, int k) const { return vertices_[triangles_[triangle][k]]; }
  Separation separation(std::uint32_t triangle, const Vec3& p) const {
    const Triangle& t = triangles_[triangle];
    return separation_from_triangle(p, vertices_[t[0]], vertices_[t[1]], vertices_[t[2]]);
  }
  // Start moving a triangle's memory towards the processor: first its indices, later its corners.
  void prefetch_indices(std::uint32_t triangle) const { _mm_prefetch(reinterpret_cast<const char*>(&triangles_[triangle]), _MM_HINT_T0); }
  void prefetch_corners(std::uint32_t triangle) const {
    for (const std::uint32_t v : triangles_[triangle]) _mm_prefetch(reinterpret_cast<const char*>(&vertices_[v]), _MM_HINT_T0);
  }

  // Which of the meshes given to the constructor the triangle belongs to.
  std::uint32_t mesh_of(std::uint32_t triangle) const;

 private:
  Vec3 origin_ = Vec3::Zero();
  double unit_m_ = 1.0;
  std::vector<Vec3> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint16_t> mesh_of_;  // empty for a single mesh
  WideBvh tree_;
};

}  // namespace hapton
