#pragma once

#include <vector>

#include "core/sculpt/carve_list.h"
#include "core/sculpt/carved_field.h"
#include "core/sculpt/surface_nets.h"
#include "vision_node/flat_level.h"

namespace hapton {

// The surface of a body that is being carved, as drawn: in three levels of detail, of which a carve changes only the blocks around it.
// Frame of the field: that of the body's mesh. Threads: one. RT: no.
class CarvedSurface {
 public:
  static constexpr std::array<int, 3> kStrides = {1, 2, 4};  // of the levels, in voxels

  // frame: U, in which the levels are drawn.
  CarvedSurface(CarvedField field, const DetailFrame& frame);

  void carve(const Carve& carve);
  // Puts back what the undone carves of this body removed. Pre: as restore_undone.
  void undo(const CarveList& list, int object, const CarveRange& undone);
  // The body is whole again.
  void restore();

  // The surface has changed since the last call of compute_levels().
  bool has_changed() const { return has_changed_; }
  // All levels, finest first, each block a cluster. Only blocks that have changed are computed.
  std::vector<FlatLevel> compute_levels();

  const CarvedField& field() const { return field_; }

 private:
  // Of one block, at one stride; indices from its own first vertex.
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
  void compute(std::size_t number);
  Piece make_piece(const SurfaceNet& net) const;
  FlatLevel join(std::size_t level) const;

  CarvedField whole_;
  CarvedField field_;
  DetailFrame frame_;
  SurfaceNets nets_;
  SurfaceNet net_;
  SurfaceNets::Index count_ = {};
  std::vector<Block> blocks_;
  bool has_changed_ = true;
};

}  // namespace hapton
