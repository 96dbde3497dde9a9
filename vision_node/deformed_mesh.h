#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/geometry/mesh_deformation.h"
#include "vision_node/surface_finder.h"

namespace hapton {

// A mesh that deforms, with what is drawn on it. A point of its surface is identified by its place at rest (all weights 0, or before any
// shape from a program): that gives its triangle and its place in it, with which it moves. Frame, units: the mesh's. Threads: one. RT: no.
class DeformedMesh {
 public:
  // For a mesh that deforms by morphs. Pre: neither is null; at least one triangle.
  DeformedMesh(std::shared_ptr<const TriangleMesh> rest, std::shared_ptr<const MeshDeformation> deformation);

  // Returns where the vertices of a mesh are that programs deform, as many as at rest; none: they stay where they were.
  using FindVertices = std::function<std::optional<std::vector<Vec3>>()>;
  DeformedMesh(std::shared_ptr<const TriangleMesh> rest, FindVertices find);

  // Returns true if the mesh then has another shape than before. Always false for a mesh that programs deform.
  bool set_time(double time_s);
  // Makes the vertices of a mesh that programs deform be found again at their next use.
  void invalidate_vertices() { are_vertices_outdated_ = true; }

  struct TouchedPoint {
    Vec3 p_rest = Vec3::Zero();
    std::uint32_t triangle = 0;
  };
  // The point of its surface that is closest to p in the present shape, as its place at rest. Work: that of all triangles nearer than the
  // closest point plus the largest displacement. Pre: p is finite.
  TouchedPoint find_closest(const Vec3& p) const;

  // Returns where the surface point that is closest to p_rest at rest is in the present shape.
  Vec3 place(const Vec3& p_rest) const;

 private:
  struct Anchor {
    std::uint32_t triangle = 0;
    Vec3 barycentric = Vec3::Zero();
  };
  const SurfaceFinder& finder() const;
  const std::vector<Vec3>& vertices() const;
  double most_displacement() const;
  const Anchor& find_anchor(const Vec3& p_rest) const;
  Vec3 interpolate(const std::vector<Vec3>& vertices, std::uint32_t triangle, const Vec3& barycentric) const;

  std::shared_ptr<const TriangleMesh> rest_;
  std::shared_ptr<const MeshDeformation> deformation_;  // null: programs deform it
  FindVertices find_vertices_;
  mutable bool are_vertices_outdated_ = false;
  MeshDeformation::Weights weights_ = {};
  // Made when it is first needed, because it takes long:
  mutable std::unique_ptr<SurfaceFinder> finder_;
  mutable std::vector<Vec3> vertices_;  // the vertices with vertices_weights_, or as last found
  mutable std::optional<MeshDeformation::Weights> vertices_weights_;
  mutable std::map<std::array<double, 3>, Anchor> anchors_;  // by p_rest, for place()
};

}  // namespace hapton
