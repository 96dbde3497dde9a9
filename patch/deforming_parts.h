#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/mesh_deformation.h"
#include "link/messages.h"

namespace hapton {

// Collects the weights of a body that deforms, over time, and counts its other parts that have come. Units: SI. RT: no. Threads: one.
class DeformingParts {
 public:
  // The vertices of a tile in the mesh that all tiles of the body make, and what moves them.
  struct DisplacedTile {
    std::span<const std::uint32_t> vertices;  // of the mesh, one for each of the tile
    const PatchDisplacements* displaced = nullptr;
  };

  // False: it is of another deformation than what came before. Pre: protobuf_codec has checked the part.
  bool accept(const PatchDeformation& part);
  bool has_begun() const noexcept { return head_.tile_count > 0; }
  std::uint32_t first_tile() const noexcept { return head_.first_tile; }
  std::uint32_t tile_count() const noexcept { return head_.tile_count; }
  std::uint32_t target_count() const noexcept { return head_.target_count; }
  bool has_tile(std::uint32_t tile) const noexcept { return has_begun() && tile - head_.first_tile < head_.tile_count; }
  // Count one more of its tiles, or of the displacements of its tiles, that has come.
  void note_tile() noexcept { ++tiles_; }
  void note_displaced() noexcept { ++displaced_; }
  // True if nothing is missing of what was announced.
  bool is_whole() const noexcept {
    return has_begun() && received_keys_ == head_.all_keys && tiles_ >= head_.tile_count && displaced_ >= head_.displaced_count;
  }

  // Pre: is_whole(). Null: no body may deform like this: faster than kMaxSurfaceSpeed, or with weights that are out of order.
  std::shared_ptr<const MeshDeformation> make(std::span<const DisplacedTile> tiles) const;

 private:
  bool is_in_order() const;

  PatchDeformation head_;  // the part that came first
  std::vector<MorphKey> keys_;
  std::uint32_t received_keys_ = 0;
  std::uint32_t tiles_ = 0;
  std::uint32_t displaced_ = 0;
};

}  // namespace hapton
