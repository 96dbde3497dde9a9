#include "patch/patch_store.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <variant>

#include "core/math/commanded_motion.h"
#include "patch/object_joiner.h"

namespace hapton {
namespace {

constexpr double kShrink = 0.8;            // factor that reduces the radius of a piece with too many triangles
constexpr std::size_t kMinOverCentre = 2;  // a piece may have this many times the triangles of the tiles at its centre
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// More than the tolerance of scenes (1e-9, scene/object_motion.cpp), so that a motion that a haptics node has accepted is accepted here.
constexpr double kSpeedRounding = 1e-6;
constexpr double kUnitRounding = 1e-9;  // of the length of a unit quaternion

bool is_same_body(const PatchBody& a, const PatchBody& b) {
  return a.motion == b.motion && a.deforms == b.deforms && a.all_keys == b.all_keys && a.loops == b.loops && a.lowest == b.lowest &&
         a.highest == b.highest && a.pivot_m == b.pivot_m && a.radius_m == b.radius_m && a.object == b.object;
}

bool has_triangles(const PatchBody& body) { return body.lowest[0] <= body.highest[0]; }

bool is_possible_motion(const std::vector<Keyframe>& keys, const PatchBody& body) {
  const Keyframe& last = keys.back();
  if (body.loops && !(keys.front().p_S == last.p_S && keys.front().turn.coeffs() == last.turn.coeffs())) return false;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (!(std::abs(keys[i].turn.norm() - 1.0) <= kUnitRounding)) return false;
    if (i == 0) continue;
    const double travel_m = most_travel_m(keys[i - 1], keys[i], body.radius_m);
    const double time_s = keys[i].time_s - keys[i - 1].time_s;
    if (!(time_s > 0.0) || !(travel_m <= kMaxSurfaceSpeed * (1.0 + kSpeedRounding) * time_s)) return false;
  }
  return true;
}

}  // namespace

void PatchStore::clear() {
  drop_parts();
  shapes_ = KnownShapes();
}

// Keeps the shapes: they belong to the haptics process, whatever the epoch.
void PatchStore::drop_parts() {
  begin_.reset();
  bodies_ = {};
  effect_parts_ = {};
  effects_.reset();
  materials_.clear();
  material_serials_.clear();
  cells_.clear();
  tiles_.clear();
  displaced_.clear();
  status_ = {};
}

// False: the part is of an epoch that is over. Epochs count up modulo 2^32.
bool PatchStore::adopt(std::uint32_t epoch, std::uint32_t serial) {
  const bool is_newer = status_.epoch == 0 || static_cast<std::int32_t>(epoch - status_.epoch) > 0;
  if (epoch == 0 || serial == 0 || (epoch != status_.epoch && !is_newer)) {
    ++counts_.rejected;
    return false;
  }
  if (epoch != status_.epoch) {
    drop_parts();
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
    for (Body& body : bodies_) (void)complete_deforming(body);
    (void)complete_effects();
  }
  confirm(begin.serial);
}

void PatchStore::accept(const PatchEffects& effects) {
  if (!adopt(effects.epoch, effects.serial)) return;
  if (!effect_parts_.take(effects) || !complete_effects()) {
    ++counts_.rejected;
    return;
  }
  confirm(effects.serial);
}

// False: no scene may have these effects; all their parts are dropped.
bool PatchStore::complete_effects() {
  if (!begin_ || effects_ || begin_->effect_bytes == 0 || !effect_parts_.is_whole(begin_->effect_bytes)) return true;
  const std::string bytes = effect_parts_.join();
  auto effects = bytes.size() == begin_->effect_bytes ? decode_effects(bytes) : fail("not as many bytes as announced");
  if (!effects) {
    effect_parts_ = {};
    return false;
  }
  effects_ = std::move(*effects);
  return true;
}

namespace {

// Visits the empty children of `above`, one of the cubes that contain the cell.
template <class Visit>
void visit_empty_children(const PatchCell& cell, const CellKey& above, Visit&& visit) {
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    if (((cell.empty_children[above.level] >> octant) & 1U) != 0) visit(above.child(octant));
  }
}

}  // namespace

// How many cells this one adds: itself, the cubes that contain it, and their empty children.
std::size_t PatchStore::count_new_cells(const PatchCell& cell) const {
  std::size_t count = 0;
  const auto note = [&](const CellKey& key) { count += cells_.contains(key_of(cell.body, key)) ? 0 : 1; };
  CellKey above{cell.level, cell.index};
  for (note(above); above.level > 0;) {
    above = above.parent();
    note(above);
    visit_empty_children(cell, above, note);
  }
  return count;
}

void PatchStore::accept(const PatchCell& cell) {
  if (!adopt(cell.epoch, cell.serial)) return;
  if (cell.body >= PatchBody::kMaxBodies || cells_.size() + count_new_cells(cell) > kMaxCells) {
    ++counts_.rejected;
    return;
  }
  const CellKey key{cell.level, cell.index};
  cells_[key_of(cell.body, key)].tiles.assign(cell.tiles.begin(), cell.tiles.begin() + cell.tile_count);
  for (CellKey above = key; above.level > 0;) {
    above = above.parent();
    cells_[key_of(cell.body, above)].is_divided = true;
    visit_empty_children(cell, above, [&](const CellKey& empty) { cells_.try_emplace(key_of(cell.body, empty)); });
  }
  confirm(cell.serial);
}

void PatchStore::accept(const PatchTile& tile) {
  if (!adopt(tile.epoch, tile.serial)) return;
  if (!tiles_.contains(tile.tile) && tiles_.size() >= kMaxTiles) {
    ++counts_.rejected;
    return;
  }
  if (tiles_.try_emplace(tile.tile, tile).second) {
    if (Body* const body = find_deforming(tile.tile)) {
      if (body->parts.has_tile(tile.tile)) body->parts.note_tile();
      if (body->stream.has_tile(tile.tile)) body->stream.note_tile();
      if (!complete_deforming(*body)) return;
    }
  }
  confirm(tile.serial);
}

void PatchStore::accept(const PatchBody& body) {
  if (!adopt(body.epoch, body.serial)) return;
  if (body.body >= PatchBody::kMaxBodies || body.all_keys > PatchBody::kMaxAllKeys) {
    ++counts_.rejected;
    return;
  }
  Body& known_body = bodies_[body.body];
  if (!known_body.has_begun) {
    known_body.head = body;
    known_body.keys.assign(body.all_keys, Keyframe());
    known_body.has_key.assign(body.all_keys, false);
    known_body.has_begun = true;
  }
  const bool fits = is_same_body(known_body.head, body) && body.first_key + body.key_count <= known_body.keys.size();
  if (fits) {
    std::copy_n(body.keys.begin(), body.key_count, known_body.keys.begin() + body.first_key);
    std::fill_n(known_body.has_key.begin() + body.first_key, body.key_count, true);
    known_body.head.move_serial = std::max(known_body.head.move_serial, body.move_serial);
  }
  if (!fits || !complete(known_body)) {
    ++counts_.rejected;
    return;
  }
  if (complete_deforming(known_body)) confirm(body.serial);
}

// False: no body may move like this; all that has come of it is dropped.
bool PatchStore::complete(Body& body) const {
  if (body.is_known || std::find(body.has_key.begin(), body.has_key.end(), false) != body.has_key.end()) return true;
  if (!is_possible(body)) {
    body = {};
    return false;
  }
  body.is_known = true;
  return true;
}

bool PatchStore::is_possible(const Body& body) const {
  const PatchBody& head = body.head;
  const bool moves = head.motion != PatchBody::Motion::still || head.deforms;
  if (moves != (head.body != 0)) return false;
  return head.motion != PatchBody::Motion::keyframes || is_possible_motion(body.keys, head);
}

void PatchStore::accept(const PatchMaterial& material) {
  if (!adopt(material.epoch, material.serial)) return;
  // Each object has at least one tile, so there are at most as many materials as tiles.
  if (!material_serials_.contains(material.object) && material_serials_.size() >= kMaxTiles) {
    ++counts_.rejected;
    return;
  }
  std::uint32_t& newest = material_serials_[material.object];
  if (material.serial > newest) {
    newest = material.serial;
    materials_[material.object] = {.stiffness_n_per_m = material.stiffness_n_per_m,
                                   .damping_ns_per_m = material.damping_ns_per_m,
                                   .friction_static = material.friction_static,
                                   .friction_dynamic = material.friction_dynamic};
    ++material_version_;
  }
  confirm(material.serial);
}

bool PatchStore::accept_part(const Message& message) {
  return std::visit(
      [this]<class Kind>(const Kind& part) {
        if constexpr (kIsScenePart<Kind>) accept(part);
        return kIsScenePart<Kind>;
      },
      message);
}

bool PatchStore::has_bodies() const noexcept {
  if (!has_begun() || (begin_->effect_bytes > 0 && !effects_)) return false;
  if (begin_->body_count == 1) return true;
  const auto is_there = [this](const Body& body) { return body.is_known && is_wide_enough(body.head); };
  return std::all_of(bodies_.begin(), bodies_.begin() + begin_->body_count, is_there);
}

// Some two points of the body are widest_m apart: its radius is at least half of that, whatever the pivot.
bool PatchStore::is_wide_enough(const PatchBody& body) const noexcept {
  if (body.motion == PatchBody::Motion::still || !has_triangles(body)) return true;
  const double widest_m = grid_.step_m * (to_vector(body.highest) - to_vector(body.lowest)).maxCoeff();
  return body.radius_m >= 0.499 * widest_m;
}

std::unique_ptr<PatchBodies> PatchStore::make_bodies(std::uint32_t generation) const {
  auto made = std::make_unique<PatchBodies>();
  made->extent_m = std::ldexp(grid_.step_m, kPatchGridBits - 1);
  made->generation = generation;
  if (effects_) made->effects = std::make_unique<FeltEffects>(*effects_);
  made->bodies.resize(begin_->body_count);
  for (std::size_t b = 1; b < made->bodies.size(); ++b) {
    const PatchBody& head = bodies_[b].head;
    PatchBodyMotion& body = made->bodies[b];
    body.pivot_S = head.pivot_m;
    body.radius_m = head.radius_m;
    body.is_commanded = head.motion == PatchBody::Motion::commanded;
    body.deforms = head.deforms;
    body.object = body.is_commanded ? head.object : -1;
    body.move_serial = head.move_serial;
    if (head.motion == PatchBody::Motion::keyframes)
      body.keyframes = std::make_shared<const KeyframeMotion>(head.pivot_m, bodies_[b].keys, head.loops);
  }
  return made;
}

bool PatchStore::is_whole(const Cell& cell) const {
  return std::all_of(cell.tiles.begin(), cell.tiles.end(), [this](std::uint32_t tile) { return tiles_.contains(tile); });
}

PatchStore::Search PatchStore::search_at(const Vec3& p_S, std::uint32_t body) const {
  Search search{body, grid_.to_steps(p_S), 0.0};
  if (begin_->body_count == 1) return search;
  const Body& known_body = bodies_[body];
  if (!known_body.is_known) return search;
  const Box bounds = has_triangles(known_body.head) ? Box{to_vector(known_body.head.lowest), to_vector(known_body.head.highest)} : Box();
  search.least_distance = std::sqrt(bounds.distance_squared(search.p));
  return search;
}

// The distance, in steps, to the nearest place in this cell that is not fully known; `best` if that is less.
double PatchStore::find_unknown(const CellKey& key, const Search& search, double best) const {
  const double distance = std::max(search.least_distance, std::sqrt(key.bounds().distance_squared(search.p)));
  if (distance >= best) return best;
  const auto found = cells_.find(key_of(search.body, key));
  if (found == cells_.end()) return distance;
  if (!found->second.is_divided) return is_whole(found->second) ? best : distance;
  if (key.level >= kPatchDeepestLevel) return distance;
  for (std::uint32_t octant = 0; octant < 8; ++octant) best = find_unknown(key.child(octant), search, best);
  return best;
}

double PatchStore::known_radius(const Vec3& p_S, std::uint32_t body) const {
  if (bodies_[body].is_known && bodies_[body].head.deforms) {
    return is_felt(bodies_[body]) ? kInfinity : grid_.step_m * search_at(p_S, body).least_distance;
  }
  return grid_.step_m * find_unknown(CellKey(), search_at(p_S, body), kInfinity);
}

void PatchStore::find_tiles(const CellKey& key, const Search& search, double radius, std::unordered_set<std::uint32_t>& found) const {
  if (key.bounds().distance_squared(search.p) > radius * radius) return;
  const auto cell = cells_.find(key_of(search.body, key));
  if (cell == cells_.end()) return;
  if (cell->second.is_divided && key.level < kPatchDeepestLevel) {
    for (std::uint32_t octant = 0; octant < 8; ++octant) find_tiles(key.child(octant), search, radius, found);
  } else {
    found.insert(cell->second.tiles.begin(), cell->second.tiles.end());
  }
}

void PatchStore::use_material_of(std::uint32_t object, Material& material) const {
  const auto tuned = materials_.find(object);
  if (tuned != materials_.end()) material = with_numbers_of(material, tuned->second);
}

PatchStore::Piece PatchStore::make_piece(const Vec3& p_S, double max_radius_m, std::size_t max_triangles, std::uint32_t body) const {
  Piece piece;
  piece.radius_m = std::min(known_radius(p_S, body), max_radius_m);
  if (bodies_[body].head.deforms) return make_deforming(bodies_[body], piece.radius_m);
  const Search search = search_at(p_S, body);
  std::unordered_set<std::uint32_t> near_tiles;
  const auto find = [&](double radius_m) {
    near_tiles.clear();
    find_tiles(CellKey(), search, radius_m / grid_.step_m, near_tiles);
    std::size_t triangles = 0;
    for (const std::uint32_t tile : near_tiles) triangles += tiles_.contains(tile) ? tiles_.at(tile).triangle_count : 0;
    return triangles;
  };
  // Where tiles overlap, the tiles at one point alone may have too many triangles.
  max_triangles = std::max(max_triangles, kMinOverCentre * find(0.0));
  // A ball of twice the grid's diagonal contains the whole grid if its centre is anywhere near.
  const double widest_m = std::ldexp(grid_.step_m, kPatchGridBits + 2);
  for (int attempt = 0; attempt < 100; ++attempt, piece.radius_m = std::min(kShrink * piece.radius_m, widest_m)) {
    piece.triangles = find(piece.radius_m);
    if (piece.triangles <= max_triangles) break;
  }
  std::map<std::uint32_t, ObjectJoiner> objects;
  std::vector<std::uint32_t> in_order(near_tiles.begin(), near_tiles.end());
  std::sort(in_order.begin(), in_order.end());
  for (const std::uint32_t number : in_order) {
    const auto tile = tiles_.find(number);
    if (tile != tiles_.end()) objects.try_emplace(tile->second.object, grid_).first->second.add(tile->second);
  }
  for (auto& [number, object] : objects) {
    piece.scene.objects.push_back(object.take());
    use_material_of(number, piece.scene.objects.back().material);
    piece.objects.push_back(static_cast<int>(number));
  }
  piece.scene.part_of = grid_.box();
  return piece;
}

}  // namespace hapton
