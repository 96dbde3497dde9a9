#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "core/math/types.h"
#include "link/messages.h"

namespace hapton {

// Collects the parts of a body that programs deform: for each tile, the numbers of its vertices in the object's mesh (PatchStream), and
// how many of the tiles have been received. Units: SI. RT: no. Threads: one.
class StreamedParts {
 public:
  using TileVertices = std::array<std::uint32_t, PatchTile::kMaxVertices>;

  // Takes a part. False: it contradicts the parts before, or names a tile that the body does not have.
  bool accept(const PatchStream& part);
  bool has_begun() const noexcept { return head_.tile_count > 0; }
  std::int32_t object() const noexcept { return head_.object; }
  std::uint32_t total() const noexcept { return head_.total; }
  double reach_m() const noexcept { return head_.reach_m; }
  std::uint32_t first_tile() const noexcept { return head_.first_tile; }
  std::uint32_t tile_count() const noexcept { return head_.tile_count; }
  bool has_tile(std::uint32_t tile) const noexcept { return has_begun() && tile - head_.first_tile < head_.tile_count; }
  // The newest serial of a ShapeStart that the parts name: the body has that shape or a later one. 0: they name none.
  std::uint32_t shape_serial() const noexcept { return head_.shape_serial; }
  // Number of tiles whose PatchStream has been received.
  std::size_t size() const noexcept { return vertices_.size(); }
  // Call it for each tile (PatchTile) of the body that is received.
  void note_tile() noexcept { ++tiles_; }
  // All tiles of the body, and their PatchStream messages, have been received.
  bool is_whole() const noexcept { return has_begun() && tiles_ >= head_.tile_count && vertices_.size() == head_.tile_count; }

  // Adds a tile to the mesh that joins all tiles of the body. joined: the numbers of the tile's vertices in that mesh. Pre: is_whole(); the
  // tile is one of the body's. False: the tile has another number of vertices than its PatchStream.
  bool join(const PatchTile& tile, const TileVertices& joined);
  // The vertices of that mesh in a shape. rest: where they are at rest. Frame: S, without the motion of the body. Pre: all tiles are
  // joined; one displacement (as in ObjectShape) for each of the total() vertices.
  std::vector<Vec3> vertices_at(std::span<const Vec3> rest, std::span<const ShapePart::Displacement> displacements_m) const;

 private:
  PatchStream head_;  // the first part received, with the newest shape_serial of all
  std::map<std::uint32_t, PatchStream> vertices_;
  std::vector<std::uint32_t> mesh_vertex_of_joined_;  // numbers of vertices in the object's mesh, by their numbers in the joined one
  std::uint32_t tiles_ = 0;
};

}  // namespace hapton
