#include "vision_node/back_face_visibility.h"

#include <algorithm>

#include "core/geometry/inside_out.h"

namespace hapton {
namespace {

bool has_fronts_outside(const TriangleMesh& mesh) {
  const ClosedBodies bodies = count_closed_bodies(mesh);
  return bodies.count > 0 && bodies.others == 0 && bodies.inside_out == 0;
}

bool shows_inner_sides(const MeshAppearance& appearance) {
  return std::any_of(appearance.materials.begin(), appearance.materials.end(),
                     [](const VisualMaterial& material) { return material.is_double_sided && material.alpha_mode != AlphaMode::opaque; });
}

}  // namespace

bool shows_backs(const SceneObject& object) {
  if (object.sculpt) return false;
  if (object.appearance != nullptr && shows_inner_sides(*object.appearance)) return true;
  return object.material.two_sided && !has_fronts_outside(*object.mesh);
}

// A body and an open piece that share a vertex count as one piece, which is not closed: so all triangles at a vertex agree.
void mark_without_back(const TriangleMesh& mesh, const MeshAppearance* appearance, DetailLevel& full) {
  if (appearance != nullptr && shows_inner_sides(*appearance)) return;
  const std::vector<bool> outward = find_outward_triangles(mesh);
  full.without_back.assign(full.positions.size(), 0);
  for (std::size_t i = 0; i < full.indices.size(); ++i) full.without_back[full.indices[i]] = outward[i / 3] ? 1 : 0;
}

}  // namespace hapton
