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

// A mesh that deforms, for what is drawn on it. A point of its surface is named by where it is at rest, with all weights 0 or before any
// shape of a program: that gives its triangle and its place within, which go along. Frame, units: the mesh's. Threads: one. RT: no.
class DeformedMesh {
 public:
  // Pre: neither is null; at least one triangle.
  DeformedMesh(std::shared_ptr<const TriangleMesh> rest, std::shared_ptr<const MeshDeformation> deformation);

  // Programs deform it: find returns where its vertices are, or nothing, and then they stay where they were.
  using FindVertices = std::function<std::optional<std::vector<Vec3>>()>;
  DeformedMesh(std::shared_ptr<const TriangleMesh> rest, FindVertices find);

  // True: it has another shape than before. Not of one that programs deform.
  bool set_time(double time_s);
  // The vertices of one that programs deform are to be found again.
  void spoil() { is_spoilt_ = true; }

  struct Touched {
    Vec3 p_rest = Vec3::Zero();
    std::uint32_t triangle = 0;
  };
  // The point of its surface that is closest to p, in the present shape. Work: that of all triangles within the farthest displacement.
  // Pre: finite.
  Touched find_closest(const Vec3& p) const;

  // Where the point of the surface is now that is closest to p_rest at rest.
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
  Vec3 mix(const std::vector<Vec3>& vertices, std::uint32_t triangle, const Vec3& barycentric) const;

  std::shared_ptr<const TriangleMesh> rest_;
  std::shared_ptr<const MeshDeformation> deformation_;  // null: programs deform it
  FindVertices find_vertices_;
  mutable bool is_spoilt_ = false;
  MeshDeformation::Weights weights_ = {};
  // What takes long is made when it is first needed.
  mutable std::unique_ptr<SurfaceFinder> finder_;
  mutable std::vector<Vec3> vertices_;  // with vertices_weights_
  mutable std::optional<MeshDeformation::Weights> vertices_weights_;
  mutable std::map<std::array<double, 3>, Anchor> anchors_;  // by p_rest
};

}  // namespace hapton
