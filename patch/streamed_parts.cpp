#include "patch/streamed_parts.h"

#include <algorithm>

namespace hapton {
namespace {

bool is_same_stream(const PatchStream& a, const PatchStream& b) {
  return a.first_tile == b.first_tile && a.tile_count == b.tile_count && a.object == b.object && a.total == b.total &&
         a.reach_m == b.reach_m && a.to_scene == b.to_scene;
}

}  // namespace

bool StreamedParts::accept(const PatchStream& part) {
  if (!has_begun()) head_ = part;
  if (!is_same_stream(head_, part) || !has_tile(part.tile)) return false;
  head_.shape_serial = std::max(head_.shape_serial, part.shape_serial);
  vertices_.try_emplace(part.tile, part);
  return true;
}

bool StreamedParts::join(const PatchTile& tile, const TileVertices& joined) {
  const PatchStream& named = vertices_.at(tile.tile);
  if (named.vertex_count != tile.vertex_count) return false;
  for (std::size_t v = 0; v < tile.vertex_count; ++v) {
    if (joined[v] >= mesh_vertex_of_joined_.size()) mesh_vertex_of_joined_.resize(std::size_t{joined[v]} + 1);
    mesh_vertex_of_joined_[joined[v]] = named.vertices[v];
  }
  return true;
}

std::vector<Vec3> StreamedParts::vertices_at(std::span<const Vec3> rest, std::span<const ShapePart::Displacement> displacements_m) const {
  std::vector<Vec3> vertices(rest.begin(), rest.end());
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const ShapePart::Displacement& by_m = displacements_m[mesh_vertex_of_joined_[v]];
    vertices[v] += head_.to_scene * Vec3(by_m[0], by_m[1], by_m[2]);
  }
  return vertices;
}

}  // namespace hapton
