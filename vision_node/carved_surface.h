#pragma once

#include <vector>

#include "core/sculpt/carve_list.h"
#include "core/sculpt/carved_field.h"
#include "core/sculpt/surface_nets.h"
#include "vision_node/flat_level.h"

namespace hapton {

// The surface of a body that is being carved, as drawn, in three levels of detail; after a carve only the blocks around it are computed
// again. Frame: that of the field, which is that of the body's mesh. Threads: one. RT: no.
class CarvedSurface {
 public:
  static constexpr std::array<int, 3> kStrides = {1, 2, 4};  // voxels from one sample of a level to the next

  // frame: the unit frame U of the mesh, in which the levels are drawn.
  CarvedSurface(CarvedField field, const DetailFrame& frame);

  void carve(const Carve& carve);
  // Puts back the material that the undone carves of this body removed. Pre: as for restore_undone.
  void undo(const CarveList& list, int object, const CarveRange& undone);
  // Makes the body whole again.
  void restore();

  // Whether the surface has changed since the last call of compute_levels().
  bool has_changed() const { return has_changed_; }
  // Returns all levels, finest first; each block is a cluster. Computes only the blocks that have changed.
  std::vector<FlatLevel> compute_levels();

  const CarvedField& field() const { return field_; }

 private:
  // The surface of a block at one stride; indices count from its first vertex.
  struct Piece {
    std::vector<FlatVertex> vertices;
    std::vector<std::uint32_t> indices;
    DetailCluster cluster;
  };
  struct Block {
    std::array<Piece, kStrides.size()> pieces;
    bool has_changed = true;
  };

  void note_changed(const CarvedFieldBox& box);
  void compute_block(std::size_t number);
  Piece make_piece(const SurfaceNet& net) const;
  FlatLevel join(std::size_t level) const;

  CarvedField uncarved_field_;
  CarvedField field_;
  DetailFrame frame_;
  SurfaceNets nets_;
  SurfaceNet net_;
  SurfaceNets::Index block_counts_ = {};
  std::vector<Block> blocks_;
  bool has_changed_ = true;
};

}  // namespace hapton
