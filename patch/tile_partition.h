#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/force/motion_groups.h"
#include "core/force/touch_scene.h"
#include "link/messages.h"
#include "patch/patch_grid.h"

namespace hapton {

// A leaf of the octree: the tiles whose bounds overlap it.
struct TileCell {
  std::uint32_t body = 0;
  CellKey key;
  std::array<std::uint8_t, kPatchDeepestLevel> empty_children = {};  // as PatchCell has them
  std::vector<std::uint32_t> tiles;                                  // ascending
};

// A node of the octree, for searches by distance.
struct TileNode {
  std::uint32_t body = 0;
  CellKey key;
  std::int32_t first_child = -1;  // the first of eight consecutive nodes; below 0: a leaf
  std::int32_t cell = -1;         // number of the cell of a leaf with triangles; else -1
};

// Objects that move together, or what stands still. Positions are those at rest: in the frame that moves along.
struct TileBody {
  MotionGroup group;
  Box bounds;              // of its tiles, in steps of the grid; empty: it has none
  std::int32_t root = -1;  // of its octree, in TiledScene::nodes; below 0: it has no tiles
  Vec3 pivot_m = Vec3::Zero();
  double radius_m = 0.0;  // no point of it is farther from the pivot

  // Of one that deforms: in no cell, bounds are those of all its shapes.
  std::shared_ptr<const MeshDeformation> deformation = nullptr;
  std::uint32_t first_tile = 0;
  std::uint32_t tile_count = 0;
  std::size_t first_displaced = 0;  // of TiledScene::displaced
  std::size_t displaced_count = 0;
  std::size_t first_stream = 0;  // of TiledScene::streams, one for each tile; of one that programs deform
  std::size_t stream_count = 0;

  bool deforms() const { return deformation != nullptr || stream_count > 0; }
  bool moves() const { return group.moves(); }
};

// A scene in tiles and in cells that list them. A tile's number is its place in tiles; its epoch and serial are left to the sender.
struct TiledScene {
  PatchGrid grid;
  std::vector<PatchTile> tiles;
  std::vector<Box> tile_bounds;               // in steps of the grid
  std::vector<TileBody> bodies;               // the first one stands still, and may be empty
  std::vector<TileNode> nodes;                // each body's root before the others of it
  std::vector<TileCell> cells;                // the leaves with triangles, each with no more tiles than one datagram lists
  bool has_unlisted = false;                  // so many tiles overlap somewhere that no datagram can list them: that place is never known
  std::vector<PatchDisplacements> displaced;  // of the bodies that deform; epoch and serial are left to the sender
  std::vector<PatchStream> streams;           // ... of those that programs deform, without shape_serial
  std::string effects;                        // encode_effects
  bool has_parting = false;                   // vertices of one that are one on the grid move apart: it cannot be sent
};

// The message of a cell.
inline PatchCell to_message(const TileCell& cell, std::uint32_t epoch, std::uint32_t serial) {
  PatchCell message{epoch, serial, cell.key.level, cell.key.index, cell.empty_children, static_cast<std::uint32_t>(cell.tiles.size())};
  message.body = cell.body;
  std::copy(cell.tiles.begin(), cell.tiles.end(), message.tiles.begin());
  return message;
}

// Divides the scene's triangles into compact tiles, each of one object and small enough for one datagram, and space into cells with few
// tiles. Triangles without area on the grid, because two corners coincide, are left out: their neighbours meet there. There are at most
// PatchStore::kMaxCells nodes: where many tiles overlap, cells stay larger. Each body has tiles and cells of its own; one that deforms has
// no cells, as it is felt only when all of it is there. Time: n log n. RT: no. Threads: one.
TiledScene make_tiles(const TouchScene& scene);

}  // namespace hapton
