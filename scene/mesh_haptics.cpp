#include "scene/mesh_haptics.h"

#include <algorithm>
#include <unordered_set>

#include "scene/weld.h"

namespace hapton {
namespace {

// Keeps the elements of those triangles that are kept; a list without elements stays empty.
template <class Element>
void erase_others(const std::vector<bool>& is_kept, std::vector<Element>& elements) {
  std::size_t count = 0;
  for (std::size_t t = 0; t < elements.size(); ++t) {
    if (is_kept[t]) elements[count++] = elements[t];
  }
  elements.resize(count);
}

}  // namespace

std::vector<std::uint32_t> list_haptic_materials(const MeshAppearance& maps) {
  std::vector<std::uint32_t> found;
  std::unordered_set<std::uint32_t> known;
  for (const TriangleAppearance& triangle : maps.triangles) {
    if (known.insert(triangle.material).second) found.push_back(triangle.material);
  }
  return found;
}

void keep_haptic_material(std::uint32_t material, TriangleMesh& mesh, MeshAppearance& appearance, MeshAppearance& maps) {
  std::vector<bool> is_kept;
  for (const TriangleAppearance& triangle : maps.triangles) is_kept.push_back(triangle.material == material);
  if (std::find(is_kept.begin(), is_kept.end(), false) == is_kept.end()) return;
  erase_others(is_kept, mesh.triangles);
  erase_others(is_kept, mesh.authored_normals);
  erase_others(is_kept, appearance.triangles);
  erase_others(is_kept, maps.triangles);
  drop_unused_vertices(mesh);
}

}  // namespace hapton
