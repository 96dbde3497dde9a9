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
  std::array<std::uint8_t, kPatchDeepestLevel> empty_children = {};  // as in PatchCell
  std::vector<std::uint32_t> tiles;                                  // ascending
};

// A node of the octree, for searches by distance.
struct TileNode {
  std::uint32_t body = 0;
  CellKey key;
  std::int32_t first_child = -1;  // the first of eight consecutive nodes; below 0: a leaf
  std::int32_t cell = -1;         // number of the cell of a leaf with triangles; else -1
};

// Objects that move together, or all that stand still. Positions are those at rest, in a frame that moves with the objects.
struct TileBody {
  MotionGroup group;
  Box bounds;              // bounds of its tiles, in steps of the grid; empty: it has no tiles
  std::int32_t root = -1;  // index of its octree's root in TiledScene::nodes; below 0: it has no tiles, or it deforms
  Vec3 pivot_m = Vec3::Zero();
  double radius_m = 0.0;  // no point of it is farther from the pivot; not known (0) if it stands still

  // For a body that deforms. It is in no cell, and its bounds contain all its shapes.
  std::shared_ptr<const MeshDeformation> deformation = nullptr;
  std::uint32_t first_tile = 0;
  std::uint32_t tile_count = 0;
  std::size_t first_displaced = 0;  // index in TiledScene::displaced
  std::size_t displaced_count = 0;
  std::size_t first_stream = 0;  // index in TiledScene::streams: one for each tile of a body that programs deform
  std::size_t stream_count = 0;

  bool deforms() const { return deformation != nullptr || stream_count > 0; }
  bool moves() const { return group.moves(); }
};

// A scene, divided into tiles, and into cells that list them. A tile's number is its index in `tiles`; the sender sets epoch and serial.
struct TiledScene {
  PatchGrid grid;
  std::vector<PatchTile> tiles;
  std::vector<Box> tile_bounds;               // bounds of each tile, in steps of the grid
  std::vector<TileBody> bodies;               // the first one stands still, and may be empty
  std::vector<TileNode> nodes;                // the root of each body comes before its other nodes
  std::vector<TileCell> cells;                // the leaves with triangles, each with no more tiles than one datagram lists
  bool has_unlisted_tiles = false;            // more tiles overlap in one place than a datagram can list: no cell has that place
  std::vector<PatchDisplacements> displaced;  // for bodies with a MeshDeformation; the sender sets epoch and serial
  std::vector<PatchStream> streams;           // for bodies that programs deform; the sender also sets shape_serial
  std::string effects;                        // the scene's effects, as encode_effects writes them
  bool comes_apart = false;                   // vertices at one point of the grid may move apart: the scene cannot be sent
};

// The message of a cell.
inline PatchCell to_message(const TileCell& cell, std::uint32_t epoch, std::uint32_t serial) {
  PatchCell message{epoch, serial, cell.key.level, cell.key.index, cell.empty_children, static_cast<std::uint32_t>(cell.tiles.size())};
  message.body = cell.body;
  std::copy(cell.tiles.begin(), cell.tiles.end(), message.tiles.begin());
  return message;
}

// Divides the scene's triangles into compact tiles, each of one object and small enough for one datagram, and space into cells with few
// tiles. Triangles without area on the grid, because two corners coincide, are left out: their neighbours meet there. No cell is divided
// beyond PatchStore::kMaxCells nodes: cells then stay larger. Each body has tiles and cells of its own; a body that deforms has no cells,
// because it is felt only once all of it has been received. Time: n log n. RT: no. Threads: one.
TiledScene make_tiles(const TouchScene& scene);

}  // namespace hapton
