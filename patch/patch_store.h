#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "core/force/touch_scene.h"
#include "link/messages.h"
#include "patch/patch_grid.h"

namespace hapton {

// The parts of a scene that io_node has received. Within the known radius of a point no triangle of the scene is missing. Parts may arrive
// in any order, repeatedly or never. The memory is bounded: a part that does not fit is dropped, and never confirmed.
//
// Frame: S. Units: m. RT: no. Threads: one.
class PatchStore {
 public:
  static constexpr std::size_t kMostTiles = 8192;   // bounds the memory for triangles
  static constexpr std::size_t kMostCells = 32768;  // ... and for the tree of cells above the tiles

  // The triangles near a point, as a scene of their own, and how far from the point none is missing.
  struct Piece {
    TouchScene scene;          // no objects if no triangle is near
    std::vector<int> objects;  // for each of its objects the number in the whole scene
    double radius_m = 0.0;     // no triangle within this distance of the point is missing
    std::size_t triangles = 0;
  };
  struct Counts {
    std::uint64_t parts = 0;
    std::uint64_t repeated = 0;
    std::uint64_t rejected = 0;  // parts of an earlier epoch, or without room
  };

  // Takes a part. A part of a newer epoch (another scene, or the same one sent anew) drops all parts of the one before.
  void accept(const PatchBegin& begin);
  void accept(const PatchCell& cell);
  void accept(const PatchTile& tile);
  // Drops everything, for another sender, whose epochs start again.
  void clear();

  bool has_begun() const noexcept { return begin_.has_value(); }
  const PatchBegin& begin() const noexcept { return *begin_; }
  // The parts of this epoch received so far. The caller sets is_wanted and round_trip_s.
  const PatchStatus& status() const noexcept { return status_; }
  std::uint64_t revision() const noexcept { return counts_.parts; }
  const Counts& counts() const noexcept { return counts_; }

  // The radius around a point within which no triangle of the scene is missing here; infinity if none is missing. Pre: has_begun().
  double known_radius(const Vec3& p_S) const;

  // The triangles around a point, up to its known radius and most_m. The radius is reduced until there are at most most_triangles, or twice
  // as many as the tiles at the point itself have, if that is more. Pre: has_begun().
  Piece make_piece(const Vec3& p_S, double most_m, std::size_t most_triangles) const;

 private:
  struct Cell {
    bool is_divided = false;
    std::vector<std::uint32_t> tiles;
  };

  bool adopt(std::uint32_t epoch, std::uint32_t serial);
  void confirm(std::uint32_t serial) noexcept;
  bool is_whole(const Cell& cell) const;
  double find_unknown(const CellKey& key, const Vec3& p, double best) const;
  void find_tiles(const CellKey& key, const Vec3& p, double radius, std::unordered_set<std::uint32_t>& found) const;

  std::optional<PatchBegin> begin_;
  PatchGrid grid_;
  std::unordered_map<std::uint64_t, Cell> cells_;
  std::unordered_map<std::uint32_t, PatchTile> tiles_;
  PatchStatus status_;
  Counts counts_;
};

}  // namespace hapton
