#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <utility>

#include "core/force/touch_scene.h"
#include "link/messages.h"
#include "patch/patch_grid.h"
#include "patch/patch_store.h"

namespace hapton {

// Joins tiles of one object to one mesh: a vertex that several tiles have becomes one vertex. RT: no.
class ObjectJoiner {
 public:
  explicit ObjectJoiner(const PatchGrid& grid) : grid_(grid), mesh_(std::make_shared<TriangleMesh>()) {}

  // Returns the numbers of the tile's vertices in the mesh.
  std::array<std::uint32_t, PatchTile::kMaxVertices> add(const PatchTile& tile) {
    material_ = material_of(tile);
    std::array<std::uint32_t, PatchTile::kMaxVertices> number = {};
    for (std::size_t v = 0; v < tile.vertex_count; ++v) {
      const GridPoint g = read_vertex(tile, v);
      const std::uint64_t low = (std::uint64_t{g[0]} << kPatchGridBits) | g[1];
      const auto [found, is_new] = numbers_.try_emplace({low, g[2]}, static_cast<std::uint32_t>(mesh_->vertices.size()));
      if (is_new) mesh_->vertices.push_back(grid_.at(g));
      number[v] = found->second;
    }
    for (std::size_t t = 0; t < tile.triangle_count; ++t) {
      const std::uint8_t* corner = tile.triangles.data() + 3 * t;
      mesh_->triangles.push_back({number[corner[0]], number[corner[1]], number[corner[2]]});
    }
    return number;
  }
  TouchObject take() { return {std::move(mesh_), material_}; }

 private:
  struct Hash {
    std::size_t operator()(const std::pair<std::uint64_t, std::uint32_t>& key) const noexcept {
      return (key.first * 0x9E3779B97F4A7C15U) ^ (key.second * 0xC2B2AE3D27D4EB4FU);
    }
  };
  const PatchGrid& grid_;
  std::shared_ptr<TriangleMesh> mesh_;
  Material material_;
  std::unordered_map<std::pair<std::uint64_t, std::uint32_t>, std::uint32_t, Hash> numbers_;
};

}  // namespace hapton
