#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "core/math/types.h"
#include "link/messages.h"

namespace hapton {

// What has come of a body that programs deform: which vertices of the mesh those of its tiles are, and how many of its tiles there are.
// Units: SI. RT: no. Threads: one.
class StreamedParts {
 public:
  using TileVertices = std::array<std::uint32_t, PatchTile::kMaxVertices>;

  // False: it is not of the same body as what came before.
  bool accept(const PatchStream& part);
  bool has_begun() const noexcept { return head_.tile_count > 0; }
  std::int32_t object() const noexcept { return head_.object; }
  std::uint32_t total() const noexcept { return head_.total; }
  double reach_m() const noexcept { return head_.reach_m; }
  std::uint32_t first_tile() const noexcept { return head_.first_tile; }
  std::uint32_t tile_count() const noexcept { return head_.tile_count; }
  bool has_tile(std::uint32_t tile) const noexcept { return has_begun() && tile - head_.first_tile < head_.tile_count; }
  // Of ShapeStart: it has this shape or a later one; 0: it is at rest, as far as these know.
  std::uint32_t shape_serial() const noexcept { return head_.shape_serial; }
  // How many of these have come.
  std::size_t size() const noexcept { return vertices_.size(); }
  // One more of its tiles is there.
  void note_tile() noexcept { ++tiles_; }
  // Nothing is missing.
  bool is_whole() const noexcept { return has_begun() && tiles_ >= head_.tile_count && vertices_.size() == head_.tile_count; }

  // Of the mesh that all tiles of the body make: joins a tile, whose vertices are these of that mesh. Pre: is_whole(); one of its tiles.
  // False: the tile has more vertices than were named.
  bool join(const PatchTile& tile, const TileVertices& joined);
  // The vertices of that mesh in a shape, from where they are at rest: frame S at rest. Pre: all tiles are joined; one displacement for
  // each of total().
  std::vector<Vec3> vertices_at(std::span<const Vec3> rest, std::span<const ShapePart::Displacement> displacements_m) const;

 private:
  PatchStream head_;  // of what came first, with the newest shape_serial
  std::map<std::uint32_t, PatchStream> vertices_;
  std::vector<std::uint32_t> of_joined_;  // of the mesh of the scene, by vertex of the joined one
  std::uint32_t tiles_ = 0;
};

}  // namespace hapton
