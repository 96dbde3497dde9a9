#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/force/touch_scene.h"
#include "link/messages.h"
#include "patch/patch_grid.h"

namespace hapton {

// A leaf of the octree: the tiles whose bounds overlap it.
struct TileCell {
  CellKey key;
  std::array<std::uint8_t, kPatchDeepestLevel> empty_children = {};  // as PatchCell has them
  std::vector<std::uint32_t> tiles;                                  // ascending
};

// A node of the octree, for searches by distance.
struct TileNode {
  CellKey key;
  std::int32_t first_child = -1;  // the first of eight consecutive nodes; below 0: a leaf
  std::int32_t cell = -1;         // number of the cell of a leaf with triangles; else -1
};

// A scene in tiles and in cells that list them. A tile's number is its place in tiles; its epoch and serial are left to the sender.
struct TiledScene {
  PatchGrid grid;
  std::vector<PatchTile> tiles;
  std::vector<Box> tile_bounds;  // in steps of the grid
  std::vector<TileNode> nodes;   // the root first
  std::vector<TileCell> cells;   // the leaves with triangles, each with no more tiles than one datagram lists
};

// The message of a cell.
inline PatchCell to_message(const TileCell& cell, std::uint32_t epoch, std::uint32_t serial) {
  PatchCell message{epoch, serial, cell.key.level, cell.key.index, cell.empty_children, static_cast<std::uint32_t>(cell.tiles.size())};
  std::copy(cell.tiles.begin(), cell.tiles.end(), message.tiles.begin());
  return message;
}

// Divides the scene's triangles into compact tiles, each of one object and small enough for one datagram, and space into cells with few
// tiles. Triangles without area on the grid, because two corners coincide, are left out: their neighbours meet there. There are at most
// PatchStore::kMostCells nodes: where many tiles overlap, cells stay larger. Time: n log n. RT: no.
// Threads: one.
TiledScene make_tiles(const TouchScene& scene);

}  // namespace hapton
