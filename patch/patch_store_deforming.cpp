#include <algorithm>
#include <limits>
#include <set>
#include <span>
#include <variant>

#include "core/collision/deforming_geometry.h"
#include "core/collision/shape_stage.h"
#include "patch/object_joiner.h"
#include "patch/patch_store.h"

// The bodies that deform: which of their parts have come, and when they can be felt.
namespace hapton {

PatchStore::Body* PatchStore::find_deforming(std::uint32_t tile) noexcept {
  const auto has_tile = [tile](const Body& body) { return body.parts.has_tile(tile) || body.stream.has_tile(tile); };
  Body* const found = std::find_if(bodies_.begin(), bodies_.end(), has_tile);
  return found != bodies_.end() ? found : nullptr;
}

// Tiles and displacements may have come before their deformation: the first part of it counts them.
void PatchStore::accept(const PatchDeformation& deformation) {
  if (!adopt(deformation.epoch, deformation.serial)) return;
  const std::uint64_t end = std::uint64_t{deformation.first_tile} + deformation.tile_count;
  if (deformation.body >= bodies_.size() || deformation.tile_count > kMaxTiles || end > std::numeric_limits<std::uint32_t>::max()) {
    ++counts_.rejected;
    return;
  }
  DeformingParts& parts = bodies_[deformation.body].parts;
  const bool is_first = !parts.has_begun();
  if (!parts.accept(deformation)) {
    ++counts_.rejected;
    return;
  }
  for (std::uint32_t n = 0; is_first && n < deformation.tile_count; ++n) {
    if (tiles_.contains(deformation.first_tile + n)) parts.note_tile();
    for (std::uint32_t target = 0; target < deformation.target_count; ++target) {
      if (displaced_.contains({deformation.first_tile + n, target})) parts.note_displaced();
    }
  }
  if (complete_deforming(bodies_[deformation.body])) confirm(deformation.serial);
}

void PatchStore::accept(const PatchDisplacements& displaced) {
  if (!adopt(displaced.epoch, displaced.serial)) return;
  const std::pair key(displaced.tile, displaced.target);
  if (!displaced_.contains(key) && displaced_.size() >= kMaxDisplaced) {
    ++counts_.rejected;
    return;
  }
  if (displaced_.try_emplace(key, displaced).second) {
    Body* const body = find_deforming(displaced.tile);
    if (body != nullptr && body->parts.has_tile(displaced.tile) && displaced.target < body->parts.target_count()) {
      body->parts.note_displaced();
      if (!complete_deforming(*body)) return;
    }
  }
  confirm(displaced.serial);
}

std::size_t PatchStore::count_streams() const noexcept {
  std::size_t count = 0;
  for (const Body& body : bodies_) count += body.stream.size();
  return count;
}

// An object must not be in two bodies: the one body states how many vertices the known shapes of the object have.
bool PatchStore::is_of_another_body(const PatchStream& stream) const noexcept {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (b != stream.body && bodies_[b].stream.has_begun() && bodies_[b].stream.object() == stream.object) return true;
  }
  return false;
}

void PatchStore::accept(const PatchStream& stream) {
  if (!adopt(stream.epoch, stream.serial)) return;
  if (stream.body >= bodies_.size() || stream.tile_count > kMaxTiles || count_streams() >= kMaxTiles || is_of_another_body(stream)) {
    ++counts_.rejected;
    return;
  }
  StreamedParts& parts = bodies_[stream.body].stream;
  const bool is_first = !parts.has_begun();
  if (!parts.accept(stream)) {
    ++counts_.rejected;
    return;
  }
  if (is_first) add_shaped_object(stream);
  for (std::uint32_t n = 0; is_first && n < stream.tile_count; ++n) {
    if (tiles_.contains(stream.first_tile + n)) parts.note_tile();
  }
  if (complete_deforming(bodies_[stream.body])) confirm(stream.serial);
}

// An epoch has at most one such object for each body. If more are known, some are of earlier epochs: drops these.
void PatchStore::add_shaped_object(const PatchStream& stream) {
  shapes_.add_object(static_cast<std::size_t>(stream.object), stream.total);
  if (shapes_.count_objects() <= bodies_.size()) return;
  std::set<std::size_t> present;
  for (const Body& body : bodies_) {
    if (body.stream.has_begun()) present.insert(static_cast<std::size_t>(body.stream.object()));
  }
  shapes_.keep_objects(present);
}

bool PatchStore::accept_shape(const Message& message, Arrival arrival) {
  if (const auto* shape = std::get_if<ObjectShape>(&message)) {
    shapes_.take(*shape, arrival);
  } else if (const auto* start = std::get_if<ShapeStart>(&message)) {
    shapes_.take(*start, arrival);
  } else {
    return false;
  }
  ++shape_revision_;
  return true;
}

// False: no body may deform like this; what has come of its deformation is dropped.
bool PatchStore::complete_deforming(Body& body) {
  if (body.whole.mesh != nullptr || !body.is_known || !begin_) return true;
  if (!body.parts.is_whole() && !body.stream.is_whole()) return true;
  TouchObject whole = body.parts.is_whole() ? join_deforming(body) : join_streamed(body);
  if (!whole.deforms() || !is_within_bounds(body, whole)) {
    ++counts_.rejected;
    body.parts = {};
    body.stream = {};
    return false;
  }
  body.whole = std::move(whole);
  return true;
}

TouchObject PatchStore::join_deforming(const Body& body) const {
  const DeformingParts& parts = body.parts;
  ObjectJoiner joiner(grid_);
  std::vector<std::array<std::uint32_t, PatchTile::kMaxVertices>> numbers(parts.tile_count());
  std::vector<DeformingParts::DisplacedTile> displaced;
  for (std::uint32_t n = 0; n < parts.tile_count(); ++n) {
    const PatchTile& tile = tiles_.at(parts.first_tile() + n);
    numbers[n] = joiner.add(tile);
    for (std::uint32_t target = 0; target < parts.target_count(); ++target) {
      const auto found = displaced_.find({tile.tile, target});
      if (found == displaced_.end()) continue;
      const std::size_t count = std::min(found->second.vertex_count, tile.vertex_count);
      displaced.push_back({std::span(numbers[n]).first(count), &found->second});
    }
  }
  TouchObject whole = joiner.take();
  whole.deformation = parts.make(displaced);
  return whole;
}

TouchObject PatchStore::join_streamed(Body& body) const {
  StreamedParts& stream = body.stream;
  ObjectJoiner joiner(grid_);
  for (std::uint32_t n = 0; n < stream.tile_count(); ++n) {
    const PatchTile& tile = tiles_.at(stream.first_tile() + n);
    if (!stream.join(tile, joiner.add(tile))) return {};
  }
  TouchObject whole = joiner.take();
  whole.stream_reach_m = stream.reach_m();
  return whole;
}

// Whether all shapes of the body are within its bounds, but for the rounding of displacements.
bool PatchStore::is_within_bounds(const Body& body, const TouchObject& whole) const {
  const Box shapes = whole.deformation != nullptr ? bounds_of_all_shapes(*whole.mesh, *whole.deformation)
                                                  : bounds_with_reach(*whole.mesh, *whole.stream_reach_m);
  const Box bounds = {to_vector(body.head.lowest), to_vector(body.head.highest)};
  const Box in_steps = {grid_.to_steps(shapes.low), grid_.to_steps(shapes.high)};
  return (in_steps.low.array() >= bounds.low.array() - 1.0).all() && (in_steps.high.array() <= bounds.high.array() + 1.0).all();
}

const StreamedParts* PatchStore::find_stream(std::uint32_t body) const noexcept {
  return bodies_[body].whole.stream_reach_m ? &bodies_[body].stream : nullptr;
}

// Whether a deforming body can be felt: it is complete and, if programs deform it, a shape is known or no program has deformed it yet.
bool PatchStore::is_felt(const Body& body) const {
  if (body.whole.mesh == nullptr || !body.whole.stream_reach_m) return body.whole.mesh != nullptr;
  const auto object = static_cast<std::size_t>(body.stream.object());
  const std::uint32_t serial = body.stream.shape_serial();
  if (shapes_.newest_start(object) == nullptr) return serial == 0;
  return shapes_.find_next(object, std::max(serial, 1U) - 1, std::numeric_limits<std::int64_t>::max()) != nullptr;
}

// All of the body; before it can be felt, an empty piece: the body is nowhere nearer than radius_m.
PatchStore::Piece PatchStore::make_deforming(const Body& body, double radius_m) const {
  Piece piece;
  piece.radius_m = radius_m;
  if (!is_felt(body)) return piece;
  const bool is_streamed = body.whole.stream_reach_m.has_value();
  const std::uint32_t object = tiles_.at(is_streamed ? body.stream.first_tile() : body.parts.first_tile()).object;
  piece.scene.objects.push_back(body.whole);
  use_material_of(object, piece.scene.objects.front().material);
  piece.objects.push_back(static_cast<int>(object));
  piece.triangles = body.whole.mesh->triangles.size();
  return piece;
}

}  // namespace hapton
