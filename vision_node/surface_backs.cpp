#include "vision_node/surface_backs.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "core/geometry/inside_out.h"

namespace hapton {
namespace {

// Pieces that share no vertex.
std::size_t count_pieces(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root_of = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::vector<bool> is_used(mesh.vertices.size(), false);
  for (const auto& [a, b, c] : mesh.triangles) {
    parent[root_of(b)] = root_of(a);
    parent[root_of(c)] = root_of(a);
    is_used[a] = is_used[b] = is_used[c] = true;
  }
  std::size_t pieces = 0;
  for (std::uint32_t i = 0; i < parent.size(); ++i) pieces += is_used[i] && parent[i] == i ? 1 : 0;
  return pieces;
}

bool has_fronts_outside(const TriangleMesh& mesh) {
  const ClosedBodies bodies = count_closed_bodies(mesh);
  return bodies.inside_out == 0 && bodies.count > 0 && bodies.count == count_pieces(mesh);
}

bool shows_inner_sides(const MeshLook& look) {
  return std::any_of(look.materials.begin(), look.materials.end(),
                     [](const LookMaterial& material) { return material.is_double_sided && material.alpha_mode != AlphaMode::opaque; });
}

}  // namespace

bool shows_backs(const SceneObject& object) {
  if (object.sculpt) return false;
  if (object.look != nullptr && shows_inner_sides(*object.look)) return true;
  return object.material.two_sided && !has_fronts_outside(*object.mesh);
}

}  // namespace hapton
