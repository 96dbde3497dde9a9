#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>

#include "hapton.pb.h"
#include "link/codec.h"
#include "link/protobuf_codec.h"
#include "link/wire_fields.h"

// Converts the messages for touch across a slow network to and from their form in proto/hapton.proto.
namespace hapton {
namespace {

constexpr std::uint32_t kDeforms = 4;  // bit of PatchBody.motion: the body also deforms

// The number of records of `each` bytes; 0 if the bytes are not a whole number of records, or are more than `most` records.
std::size_t count_records(const std::string& bytes, std::size_t each, std::size_t most) {
  return bytes.size() % each == 0 && bytes.size() / each <= most ? bytes.size() / each : 0;
}

template <class Field>
bool read_bounds(const Field& field, PatchBody& to) {
  if (field.empty()) return true;
  if (field.size() != 6) return false;
  std::copy(field.begin(), field.begin() + 3, to.lowest.begin());
  std::copy(field.begin() + 3, field.end(), to.highest.begin());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (to.lowest[axis] > to.highest[axis] || to.highest[axis] >> kPatchGridBits != 0) return false;
  }
  return true;
}

// Reads some of a motion's keyframes: each must be later than the one before. Without motion by keyframes there must be none.
template <class Field>
bool read_keys(const Field& field, PatchBody& to) {
  constexpr int kNumbers = 8;  // of one keyframe: time, position, quaternion
  const int count = field.size() / kNumbers;
  if (to.motion != PatchBody::Motion::keyframes) return field.empty() && to.all_keys == 0 && to.first_key == 0;
  if (field.size() % kNumbers != 0 || count == 0 || count > static_cast<int>(to.keys.size())) return false;
  to.key_count = static_cast<std::uint32_t>(count);
  if (to.all_keys < 2 || to.all_keys > PatchBody::kMaxAllKeys || to.first_key >= to.all_keys) return false;
  if (to.key_count > to.all_keys - to.first_key) return false;
  for (int n = 0; n < count; ++n) {
    const auto at = [&](int i) { return field.Get(kNumbers * n + i); };
    Keyframe& key = to.keys[static_cast<std::size_t>(n)];
    key = {at(0), Vec3(at(1), at(2), at(3)), Quat(at(4), at(5), at(6), at(7))};
    const double before_s = n > 0 ? to.keys[static_cast<std::size_t>(n - 1)].time_s : -1.0;
    if (!is_amount(key.time_s) || key.time_s <= before_s || !key.p_S.allFinite() || key.p_S.cwiseAbs().maxCoeff() > kMaxWireMagnitude)
      return false;
    if (!(std::abs(key.turn.norm() - 1.0) <= kUnitTolerance)) return false;
  }
  return true;
}

// Reads some of a deformation's weights over time: each key must be later than the one before.
bool read_weights(const wire::PatchDeformation& from, PatchDeformation& to) {
  const std::size_t each = PatchDeformation::numbers_of_key(to.target_count);
  const auto count = static_cast<std::size_t>(from.keys().size());
  if (count == 0 || count > to.keys.size() || count % each != 0) return false;
  to.key_count = static_cast<std::uint32_t>(count / each);
  if (to.first_key >= to.all_keys || to.key_count > to.all_keys - to.first_key) return false;
  std::copy(from.keys().begin(), from.keys().end(), to.keys.begin());
  double before_s = -1.0;
  for (std::size_t i = 0; i < count; ++i) {
    const bool is_time = i % each == 0;
    if (is_time ? !is_amount(to.keys[i]) || to.keys[i] <= before_s : !is_amount(std::abs(to.keys[i]))) return false;
    if (is_time) before_s = to.keys[i];
  }
  return true;
}

// For PatchTile and PatchMaterial, which have the same fields with the same rules.
template <class Message, class Wire>
void write_material(const Message& from, Wire& to) {
  to.set_object(from.object);
  to.set_stiffness_n_per_m(from.stiffness_n_per_m);
  to.set_damping_ns_per_m(from.damping_ns_per_m);
  to.set_friction_static(from.friction_static);
  to.set_friction_dynamic(from.friction_dynamic);
}

template <class Wire, class Message>
bool read_material(const Wire& from, Message& to) {
  to.object = from.object();
  to.stiffness_n_per_m = from.stiffness_n_per_m();
  to.damping_ns_per_m = from.damping_ns_per_m();
  to.friction_static = from.friction_static();
  to.friction_dynamic = from.friction_dynamic();
  const std::array amounts = {to.stiffness_n_per_m, to.damping_ns_per_m, to.friction_static, to.friction_dynamic};
  const bool is_object = to.object <= static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max());
  return is_object && std::all_of(amounts.begin(), amounts.end(), is_amount) && to.friction_dynamic <= to.friction_static;
}

}  // namespace

void write(const PatchBegin& from, wire::PatchBegin& to) {
  to.set_epoch(from.epoch);
  to.set_serial(from.serial);
  write_vector(*to.mutable_origin_m(), from.origin_m);
  to.set_step_m(from.step_m);
  to.set_probe_radius_m(from.probe_radius_m);
  to.set_scene_hash(from.scene_hash);
  to.set_body_count(from.body_count);
  to.set_request(from.request);
  to.set_method_serial(from.method_serial);
  to.set_effect_bytes(from.effect_bytes);
}

void write(const PatchCell& from, wire::PatchCell& to) {
  to.set_epoch(from.epoch);
  to.set_serial(from.serial);
  to.set_level(from.level);
  write_numbers(from.index, *to.mutable_index());
  to.mutable_empty_children()->assign(reinterpret_cast<const char*>(from.empty_children.data()),
                                      std::min<std::size_t>(from.level, from.empty_children.size()));
  write_numbers(std::span(from.tiles).first(std::min<std::size_t>(from.tile_count, from.tiles.size())), *to.mutable_tiles());
  to.set_body(from.body);
}

void write(const PatchTile& from, wire::PatchTile& to) {
  to.set_epoch(from.epoch);
  to.set_serial(from.serial);
  to.set_tile(from.tile);
  write_material(from, to);
  to.set_one_sided(!from.two_sided);
  const std::size_t vertices = std::min<std::size_t>(from.vertex_count, PatchTile::kMaxVertices);
  const std::size_t triangles = std::min<std::size_t>(from.triangle_count, PatchTile::kMaxTriangles);
  to.mutable_vertices()->assign(reinterpret_cast<const char*>(from.vertices.data()), vertices * PatchTile::kVertexBytes);
  to.mutable_triangles()->assign(reinterpret_cast<const char*>(from.triangles.data()), 3 * triangles);
}

void write(const PatchStatus& from, wire::PatchStatus& to) {
  to.set_is_wanted(from.is_wanted);
  to.set_epoch(from.epoch);
  to.set_newest_serial(from.newest_serial);
  to.mutable_received()->assign(reinterpret_cast<const char*>(from.received.data()), from.received.size());
  to.set_round_trip_s(from.round_trip_s);
  to.set_newest_move(from.newest_move);
  to.set_moves_received(from.moves_received);
  to.set_request(from.request);
  to.set_knows_effects(from.knows_effects);
  to.set_shape_s_per_vertex(from.shape_s_per_vertex);
}

void write(const PatchBody& from, wire::PatchBody& to) {
  to.set_epoch(from.epoch);
  to.set_serial(from.serial);
  to.set_body(from.body);
  to.set_motion(static_cast<std::uint32_t>(from.motion) + (from.deforms ? kDeforms : 0U));
  to.mutable_bounds()->Clear();
  if (from.lowest[0] <= from.highest[0]) {
    add_numbers(from.lowest, *to.mutable_bounds());
    add_numbers(from.highest, *to.mutable_bounds());
  }
  to.mutable_pivot_m()->Clear();
  if (from.motion != PatchBody::Motion::still) write_vector(*to.mutable_pivot_m(), from.pivot_m);
  to.set_radius_m(from.radius_m);
  to.set_object(static_cast<std::uint32_t>(from.object));
  to.set_move_serial(from.move_serial);
  to.set_loops(from.loops);
  to.set_all_keys(from.all_keys);
  to.set_first_key(from.first_key);
  to.mutable_keys()->Clear();
  for (const Keyframe& key : std::span(from.keys).first(std::min<std::size_t>(from.key_count, from.keys.size()))) {
    to.mutable_keys()->AddAlreadyReserved(key.time_s);
    add_numbers(key.p_S, *to.mutable_keys());
    for (const double value : {key.turn.w(), key.turn.x(), key.turn.y(), key.turn.z()}) to.mutable_keys()->AddAlreadyReserved(value);
  }
}

void write(const PatchMaterial& from, wire::PatchMaterial& to) {
  to.set_epoch(from.epoch);
  to.set_serial(from.serial);
  write_material(from, to);
}

void write(const PatchDeformation& from, wire::PatchDeformation& to) {
  to.set_epoch(from.epoch);
  to.set_serial(from.serial);
  to.set_body(from.body);
  to.set_first_tile(from.first_tile);
  to.set_tile_count(from.tile_count);
  to.set_displaced_count(from.displaced_count);
  to.set_target_count(from.target_count);
  to.set_loops(from.loops);
  to.set_all_keys(from.all_keys);
  to.set_first_key(from.first_key);
  const std::size_t numbers = from.key_count * PatchDeformation::numbers_of_key(from.target_count);
  to.mutable_keys()->Clear();
  add_numbers(std::span(from.keys).first(std::min(numbers, from.keys.size())), *to.mutable_keys());
}

void write(const PatchDisplacements& from, wire::PatchDisplacements& to) {
  to.set_epoch(from.epoch);
  to.set_serial(from.serial);
  to.set_tile(from.tile);
  to.set_target(from.target);
  to.mutable_by_m()->Clear();
  const std::size_t count = std::min<std::size_t>(3 * std::size_t{from.vertex_count}, from.displacements_m.size());
  add_numbers(std::span(from.displacements_m).first(count), *to.mutable_by_m());
}

void write(const PatchStream& from, wire::PatchStream& to) {
  to.set_epoch(from.epoch);
  to.set_serial(from.serial);
  to.set_body(from.body);
  to.set_first_tile(from.first_tile);
  to.set_tile_count(from.tile_count);
  to.set_object(static_cast<std::uint32_t>(from.object));
  to.set_total(from.total);
  to.set_reach_m(from.reach_m);
  to.mutable_to_scene()->Clear();
  for (int row = 0; row < 3; ++row) add_numbers(Vec3(from.to_scene.row(row)), *to.mutable_to_scene());
  to.set_shape_serial(from.shape_serial);
  to.set_tile(from.tile);
  to.mutable_vertices()->Clear();
  add_numbers(std::span(from.vertices).first(std::min<std::size_t>(from.vertex_count, from.vertices.size())), *to.mutable_vertices());
}

void write(const PatchEffects& from, wire::PatchEffects& to) {
  to.set_epoch(from.epoch);
  to.set_serial(from.serial);
  to.set_part(from.part);
  to.mutable_bytes()->assign(reinterpret_cast<const char*>(from.bytes.data()), std::min<std::size_t>(from.byte_count, from.bytes.size()));
}

bool read(const wire::PatchBegin& from, PatchBegin& to) {
  to.epoch = from.epoch();
  to.serial = from.serial();
  to.step_m = from.step_m();
  to.probe_radius_m = from.probe_radius_m();
  to.scene_hash = from.scene_hash();
  to.body_count = std::max(from.body_count(), 1U);
  to.request = from.request();
  to.method_serial = from.method_serial();
  to.effect_bytes = from.effect_bytes();
  if (to.body_count > PatchBody::kMaxBodies || to.effect_bytes > PatchEffects::kMaxAllBytes) return false;
  return read_vector(from.origin_m(), to.origin_m) && std::isnormal(to.step_m) && is_amount(to.step_m) && is_amount(to.probe_radius_m);
}

bool read(const wire::PatchCell& from, PatchCell& to) {
  to.epoch = from.epoch();
  to.serial = from.serial();
  to.level = from.level();
  to.body = from.body();
  if (to.body >= PatchBody::kMaxBodies) return false;
  const std::string& empty = from.empty_children();
  if (to.level > kPatchDeepestLevel || from.index().size() != 3 || empty.size() != to.level) return false;
  std::copy(empty.begin(), empty.end(), to.empty_children.begin());
  std::copy(from.index().begin(), from.index().end(), to.index.begin());
  if (std::any_of(to.index.begin(), to.index.end(), [&](std::uint32_t i) { return i >> to.level != 0; })) return false;
  if (from.tiles().size() > static_cast<int>(to.tiles.size())) return false;
  to.tile_count = static_cast<std::uint32_t>(from.tiles().size());
  std::copy(from.tiles().begin(), from.tiles().end(), to.tiles.begin());
  return true;
}

bool read(const wire::PatchTile& from, PatchTile& to) {
  to.epoch = from.epoch();
  to.serial = from.serial();
  to.tile = from.tile();
  to.two_sided = !from.one_sided();
  if (!read_material(from, to)) return false;
  const std::size_t vertices = count_records(from.vertices(), PatchTile::kVertexBytes, PatchTile::kMaxVertices);
  const std::size_t triangles = count_records(from.triangles(), 3, PatchTile::kMaxTriangles);
  if (vertices == 0 || triangles == 0) return false;
  to.vertex_count = static_cast<std::uint8_t>(vertices);
  to.triangle_count = static_cast<std::uint8_t>(triangles);
  std::copy(from.vertices().begin(), from.vertices().end(), to.vertices.begin());
  std::copy(from.triangles().begin(), from.triangles().end(), to.triangles.begin());
  return std::all_of(to.triangles.begin(), to.triangles.begin() + static_cast<std::ptrdiff_t>(3 * triangles),
                     [&](std::uint8_t vertex) { return vertex < vertices; });
}

bool read(const wire::PatchBody& from, PatchBody& to) {
  to = {};
  to.epoch = from.epoch();
  to.serial = from.serial();
  to.body = from.body();
  to.deforms = from.motion() >= kDeforms;
  const std::uint32_t motion = from.motion() - (to.deforms ? kDeforms : 0U);
  to.motion = static_cast<PatchBody::Motion>(motion);
  to.radius_m = from.radius_m();
  to.object = static_cast<std::int32_t>(from.object());
  to.move_serial = from.move_serial();
  to.loops = from.loops();
  to.all_keys = from.all_keys();
  to.first_key = from.first_key();
  if (to.body >= PatchBody::kMaxBodies || motion > static_cast<std::uint32_t>(PatchBody::Motion::commanded)) return false;
  if (!is_amount(to.radius_m) || to.object < 0 || !read_bounds(from.bounds(), to)) return false;
  if (to.motion != PatchBody::Motion::still && !read_vector(from.pivot_m(), to.pivot_m)) return false;
  return read_keys(from.keys(), to);
}

bool read(const wire::PatchMaterial& from, PatchMaterial& to) {
  to.epoch = from.epoch();
  to.serial = from.serial();
  return read_material(from, to);
}

bool read(const wire::PatchDeformation& from, PatchDeformation& to) {
  to = {};
  to.epoch = from.epoch();
  to.serial = from.serial();
  to.body = from.body();
  to.first_tile = from.first_tile();
  to.tile_count = from.tile_count();
  to.displaced_count = from.displaced_count();
  to.target_count = from.target_count();
  to.loops = from.loops();
  to.all_keys = from.all_keys();
  to.first_key = from.first_key();
  if (to.body >= PatchBody::kMaxBodies || to.tile_count == 0) return false;
  if (to.target_count == 0 || to.target_count > PatchDeformation::kMaxTargets) return false;
  if (to.all_keys == 0 || to.all_keys > PatchDeformation::kMaxAllKeys) return false;
  return read_weights(from, to);
}

bool read(const wire::PatchDisplacements& from, PatchDisplacements& to) {
  to.epoch = from.epoch();
  to.serial = from.serial();
  to.tile = from.tile();
  to.target = from.target();
  const auto count = static_cast<std::size_t>(from.by_m().size());
  if (to.target >= PatchDeformation::kMaxTargets || count == 0 || count % 3 != 0 || count > to.displacements_m.size()) return false;
  to.vertex_count = static_cast<std::uint8_t>(count / 3);
  std::copy(from.by_m().begin(), from.by_m().end(), to.displacements_m.begin());
  return std::all_of(from.by_m().begin(), from.by_m().end(), [](float by_m) { return is_amount(std::abs(static_cast<double>(by_m))); });
}

bool read(const wire::PatchStream& from, PatchStream& to) {
  to.epoch = from.epoch();
  to.serial = from.serial();
  to.body = from.body();
  to.first_tile = from.first_tile();
  to.tile_count = from.tile_count();
  to.object = static_cast<std::int32_t>(from.object());
  to.total = from.total();
  to.reach_m = from.reach_m();
  to.shape_serial = from.shape_serial();
  to.tile = from.tile();
  if (to.body >= PatchBody::kMaxBodies || to.object < 0 || to.tile - to.first_tile >= to.tile_count) return false;
  if (to.total == 0 || to.total > ShapePart::kMaxVertices || !is_amount(to.reach_m) || to.reach_m == 0.0) return false;
  if (from.to_scene().size() != 9) return false;
  for (int n = 0; n < 9; ++n) {
    to.to_scene(n / 3, n % 3) = from.to_scene(n);
    if (!is_amount(std::abs(from.to_scene(n)))) return false;
  }
  const auto count = static_cast<std::size_t>(from.vertices().size());
  if (count == 0 || count > to.vertices.size()) return false;
  to.vertex_count = static_cast<std::uint8_t>(count);
  std::copy(from.vertices().begin(), from.vertices().end(), to.vertices.begin());
  return std::all_of(from.vertices().begin(), from.vertices().end(), [&](std::uint32_t vertex) { return vertex < to.total; });
}

bool read(const wire::PatchEffects& from, PatchEffects& to) {
  to.epoch = from.epoch();
  to.serial = from.serial();
  to.part = from.part();
  to.byte_count = static_cast<std::uint32_t>(from.bytes().size());
  constexpr std::uint32_t kMaxParts = PatchEffects::kMaxAllBytes / PatchEffects::kMaxBytes + 1;
  if (to.byte_count == 0 || to.byte_count > to.bytes.size() || to.part >= kMaxParts) return false;
  std::copy(from.bytes().begin(), from.bytes().end(), to.bytes.begin());
  return true;
}

bool read(const wire::PatchStatus& from, PatchStatus& to) {
  to.is_wanted = from.is_wanted();
  to.epoch = from.epoch();
  to.newest_serial = from.newest_serial();
  to.round_trip_s = from.round_trip_s();
  to.newest_move = from.newest_move();
  to.moves_received = from.moves_received();
  to.request = from.request();
  to.knows_effects = from.knows_effects();
  to.shape_s_per_vertex = from.shape_s_per_vertex();
  if (from.received().size() != to.received.size()) return false;
  std::copy(from.received().begin(), from.received().end(), to.received.begin());
  return is_amount(static_cast<double>(to.round_trip_s)) && is_amount(static_cast<double>(to.shape_s_per_vertex));
}

}  // namespace hapton
