#include "core/sculpt/carved_mesh.h"

#include <unordered_map>
#include <vector>

#include "core/sculpt/surface_nets.h"

namespace hapton {

// Blocks next to each other have the vertices at their common border twice: the cell says which are the same.
TriangleMesh make_carved_mesh(const CarvedField& field) {
  TriangleMesh mesh;
  SurfaceNets nets;
  SurfaceNet net;
  std::unordered_map<std::size_t, std::uint32_t> vertex_of_cell;
  std::vector<std::uint32_t> numbers;
  const SurfaceNets::Index blocks = SurfaceNets::count_blocks(field.nodes());
  for (int z = 0; z < blocks[2]; ++z) {
    for (int y = 0; y < blocks[1]; ++y) {
      for (int x = 0; x < blocks[0]; ++x) {
        nets.compute({field.values(), field.nodes()}, {x, y, z}, 1, net);
        numbers.clear();
        for (std::size_t v = 0; v < net.positions.size(); ++v) {
          const auto& cell = net.cells[v];
          const auto [at, is_new] =
              vertex_of_cell.try_emplace(field.grid().index(cell[0], cell[1], cell[2]), static_cast<std::uint32_t>(mesh.vertices.size()));
          if (is_new) mesh.vertices.emplace_back(field.origin_m() + field.spacing_m() * net.positions[v].cast<double>());
          numbers.push_back(at->second);
        }
        for (const auto& quad : net.quads) {
          mesh.triangles.push_back({numbers[quad[0]], numbers[quad[1]], numbers[quad[2]]});
          mesh.triangles.push_back({numbers[quad[0]], numbers[quad[2]], numbers[quad[3]]});
        }
      }
    }
  }
  return mesh;
}

}  // namespace hapton
