#include "core/sculpt/carved_mesh.h"

#include "core/sculpt/manifold_surface.h"

namespace hapton {

TriangleMesh make_carved_mesh(const CarvedField& field) {
  const ManifoldSurface surface = make_manifold_surface({field.values(), field.nodes()});
  TriangleMesh mesh;
  mesh.vertices.reserve(surface.positions.size());
  for (const Eigen::Vector3f& p : surface.positions) {
    mesh.vertices.emplace_back(field.origin_m() + field.spacing_m() * p.cast<double>());
  }
  mesh.triangles.reserve(2 * surface.quads.size());
  for (const auto& quad : surface.quads) {
    mesh.triangles.push_back({quad[0], quad[1], quad[2]});
    mesh.triangles.push_back({quad[0], quad[2], quad[3]});
  }
  return mesh;
}

}  // namespace hapton
