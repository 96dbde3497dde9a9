#include "patch/patch_store.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

namespace hapton {
namespace {

constexpr double kSmaller = 0.8;           // factor on the radius of a piece that has too many triangles
constexpr std::size_t kMoreThanThere = 2;  // a piece may have this many times the triangles of the tiles at its centre
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Material material_of(const PatchTile& tile) {
  return {.stiffness_n_per_m = tile.stiffness_n_per_m,
          .damping_ns_per_m = tile.damping_ns_per_m,
          .friction_static = tile.friction_static,
          .friction_dynamic = tile.friction_dynamic,
          .two_sided = tile.two_sided};
}

// Tiles of one object joined: a vertex that several have is one.
class ObjectJoiner {
 public:
  explicit ObjectJoiner(const PatchGrid& grid) : grid_(grid), mesh_(std::make_shared<TriangleMesh>()) {}

  void add(const PatchTile& tile) {
    material_ = material_of(tile);
    std::array<std::uint32_t, PatchTile::kMostVertices> number = {};
    for (std::size_t v = 0; v < tile.vertex_count; ++v) {
      const GridPoint g = read_vertex(tile, v);
      const std::uint64_t low = (std::uint64_t{g[0]} << kPatchGridBits) | g[1];
      const auto [found, is_new] = numbers_.try_emplace({low, g[2]}, static_cast<std::uint32_t>(mesh_->vertices.size()));
      if (is_new) mesh_->vertices.push_back(grid_.at(g));
      number[v] = found->second;
    }
    for (std::size_t t = 0; t < tile.triangle_count; ++t) {
      const std::uint8_t* corner = tile.triangles.data() + 3 * t;
      mesh_->triangles.push_back({number[corner[0]], number[corner[1]], number[corner[2]]});
    }
  }
  TouchObject take() { return {std::move(mesh_), material_}; }

 private:
  struct Hash {
    std::size_t operator()(const std::pair<std::uint64_t, std::uint32_t>& key) const noexcept {
      return (key.first * 0x9E3779B97F4A7C15U) ^ (key.second * 0xC2B2AE3D27D4EB4FU);
    }
  };
  const PatchGrid& grid_;
  std::shared_ptr<TriangleMesh> mesh_;
  Material material_;
  std::unordered_map<std::pair<std::uint64_t, std::uint32_t>, std::uint32_t, Hash> numbers_;
};

}  // namespace

void PatchStore::clear() {
  begin_.reset();
  cells_.clear();
  tiles_.clear();
  status_ = {};
}

// False: of an epoch that is over. Epochs count up around the 32-bit circle.
bool PatchStore::adopt(std::uint32_t epoch, std::uint32_t serial) {
  const bool is_newer = status_.epoch == 0 || static_cast<std::int32_t>(epoch - status_.epoch) > 0;
  if (epoch == 0 || serial == 0 || (epoch != status_.epoch && !is_newer)) {
    ++counts_.rejected;
    return false;
  }
  if (epoch != status_.epoch) {
    clear();
    status_.epoch = epoch;
  }
  return true;
}

void PatchStore::confirm(std::uint32_t serial) noexcept {
  ++counts_.parts;
  auto& bits = status_.received;
  const auto is_set = [&](std::size_t bit) { return ((bits[bit / 8] >> (bit % 8)) & 1U) != 0; };
  if (serial > status_.newest_serial) {
    const std::size_t moved = std::min<std::size_t>(serial - status_.newest_serial, PatchStatus::kSerials);
    std::array<std::uint8_t, PatchStatus::kSerials / 8> next = {};
    for (std::size_t bit = moved; bit < PatchStatus::kSerials; ++bit) {
      if (is_set(bit - moved)) next[bit / 8] = static_cast<std::uint8_t>(next[bit / 8] | (1U << (bit % 8)));
    }
    bits = next;
    status_.newest_serial = serial;
  }
  const std::uint32_t back = status_.newest_serial - serial;
  if (back >= PatchStatus::kSerials) return;
  counts_.repeated += is_set(back) ? 1 : 0;
  bits[back / 8] = static_cast<std::uint8_t>(bits[back / 8] | (1U << (back % 8)));
}

void PatchStore::accept(const PatchBegin& begin) {
  if (!adopt(begin.epoch, begin.serial)) return;
  if (!begin_) {
    begin_ = begin;
    grid_ = {begin.origin_m, begin.step_m};
  }
  confirm(begin.serial);
}

void PatchStore::accept(const PatchCell& cell) {
  if (!adopt(cell.epoch, cell.serial)) return;
  const CellKey key{cell.level, cell.index};
  // Itself, the way up, and what is empty beside it.
  if (!cells_.contains(key.packed()) && cells_.size() + 1 + std::size_t{8} * kPatchDeepestLevel > kMostCells) {
    ++counts_.rejected;
    return;
  }
  cells_[key.packed()].tiles.assign(cell.tiles.begin(), cell.tiles.begin() + cell.tile_count);
  for (CellKey above = key; above.level > 0;) {
    above = above.parent();
    cells_[above.packed()].is_divided = true;
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      if (((cell.empty_children[above.level] >> octant) & 1U) != 0) cells_.try_emplace(above.child(octant).packed());
    }
  }
  confirm(cell.serial);
}

void PatchStore::accept(const PatchTile& tile) {
  if (!adopt(tile.epoch, tile.serial)) return;
  if (!tiles_.contains(tile.tile) && tiles_.size() >= kMostTiles) {
    ++counts_.rejected;
    return;
  }
  tiles_.try_emplace(tile.tile, tile);
  confirm(tile.serial);
}

bool PatchStore::is_whole(const Cell& cell) const {
  return std::all_of(cell.tiles.begin(), cell.tiles.end(), [this](std::uint32_t tile) { return tiles_.contains(tile); });
}

// The distance to the nearest place below this cell of which not all is known, if it is less than best. In steps.
double PatchStore::find_unknown(const CellKey& key, const Vec3& p, double best) const {
  const double distance = std::sqrt(key.bounds().distance_squared(p));
  if (distance >= best) return best;
  const auto found = cells_.find(key.packed());
  if (found == cells_.end()) return distance;
  if (!found->second.is_divided) return is_whole(found->second) ? best : distance;
  if (key.level >= kPatchDeepestLevel) return distance;
  for (std::uint32_t octant = 0; octant < 8; ++octant) best = find_unknown(key.child(octant), p, best);
  return best;
}

double PatchStore::known_radius(const Vec3& p_S) const { return grid_.step_m * find_unknown(CellKey(), grid_.to_steps(p_S), kInfinity); }

void PatchStore::find_tiles(const CellKey& key, const Vec3& p, double radius, std::unordered_set<std::uint32_t>& found) const {
  if (key.bounds().distance_squared(p) > radius * radius) return;
  const auto cell = cells_.find(key.packed());
  if (cell == cells_.end()) return;
  if (cell->second.is_divided && key.level < kPatchDeepestLevel) {
    for (std::uint32_t octant = 0; octant < 8; ++octant) find_tiles(key.child(octant), p, radius, found);
  } else {
    found.insert(cell->second.tiles.begin(), cell->second.tiles.end());
  }
}

PatchStore::Piece PatchStore::make_piece(const Vec3& p_S, double most_m, std::size_t most_triangles) const {
  Piece piece;
  piece.radius_m = std::min(known_radius(p_S), most_m);
  const Vec3 p = grid_.to_steps(p_S);
  std::unordered_set<std::uint32_t> near;
  const auto find = [&](double radius_m) {
    near.clear();
    find_tiles(CellKey(), p, radius_m / grid_.step_m, near);
    std::size_t triangles = 0;
    for (const std::uint32_t tile : near) triangles += tiles_.contains(tile) ? tiles_.at(tile).triangle_count : 0;
    return triangles;
  };
  // Where tiles lie across each other, those at one point alone may be too many.
  most_triangles = std::max(most_triangles, kMoreThanThere * find(0.0));
  // Twice the grid's diagonal contains it from anywhere near.
  const double widest_m = std::ldexp(grid_.step_m, kPatchGridBits + 2);
  for (int smaller = 0; smaller < 100; ++smaller, piece.radius_m = std::min(kSmaller * piece.radius_m, widest_m)) {
    piece.triangles = find(piece.radius_m);
    if (piece.triangles <= most_triangles) break;
  }
  std::map<std::uint32_t, ObjectJoiner> objects;
  std::vector<std::uint32_t> in_order(near.begin(), near.end());
  std::sort(in_order.begin(), in_order.end());
  for (const std::uint32_t number : in_order) {
    const auto tile = tiles_.find(number);
    if (tile != tiles_.end()) objects.try_emplace(tile->second.object, grid_).first->second.add(tile->second);
  }
  for (auto& [number, object] : objects) {
    piece.scene.objects.push_back(object.take());
    piece.objects.push_back(static_cast<int>(number));
  }
  piece.scene.part_of = grid_.box();
  return piece;
}

}  // namespace hapton
