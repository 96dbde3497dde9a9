#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "hapton.pb.h"
#include "link/codec.h"
#include "link/message_codec.h"
#include "link/wire_fields.h"

// The messages of touch across a slow network to and from their form in proto/hapton.proto.
namespace hapton {
namespace {

// Its size in records of that many bytes; none when it is not whole, is empty or has too many.
std::size_t count_records(const std::string& bytes, std::size_t each, std::size_t most) {
  return bytes.size() % each == 0 && bytes.size() / each <= most ? bytes.size() / each : 0;
}

}  // namespace

void write(const PatchBegin& from, wire::PatchBegin& to) {
  to.set_epoch(from.epoch);
  to.set_serial(from.serial);
  write_vector(*to.mutable_origin_m(), from.origin_m);
  to.set_step_m(from.step_m);
  to.set_probe_radius_m(from.probe_radius_m);
  to.set_scene_hash(from.scene_hash);
}

void write(const PatchCell& from, wire::PatchCell& to) {
  to.set_epoch(from.epoch);
  to.set_serial(from.serial);
  to.set_level(from.level);
  write_numbers(from.index, *to.mutable_index());
  to.mutable_empty_children()->assign(reinterpret_cast<const char*>(from.empty_children.data()),
                                      std::min<std::size_t>(from.level, from.empty_children.size()));
  write_numbers(std::span(from.tiles).first(std::min<std::size_t>(from.tile_count, from.tiles.size())), *to.mutable_tiles());
}

void write(const PatchTile& from, wire::PatchTile& to) {
  to.set_epoch(from.epoch);
  to.set_serial(from.serial);
  to.set_tile(from.tile);
  to.set_object(from.object);
  to.set_stiffness_n_per_m(from.stiffness_n_per_m);
  to.set_damping_ns_per_m(from.damping_ns_per_m);
  to.set_friction_static(from.friction_static);
  to.set_friction_dynamic(from.friction_dynamic);
  to.set_one_sided(!from.two_sided);
  const std::size_t vertices = std::min<std::size_t>(from.vertex_count, PatchTile::kMostVertices);
  const std::size_t triangles = std::min<std::size_t>(from.triangle_count, PatchTile::kMostTriangles);
  to.mutable_vertices()->assign(reinterpret_cast<const char*>(from.vertices.data()), vertices * PatchTile::kVertexBytes);
  to.mutable_triangles()->assign(reinterpret_cast<const char*>(from.triangles.data()), 3 * triangles);
}

void write(const PatchStatus& from, wire::PatchStatus& to) {
  to.set_is_wanted(from.is_wanted);
  to.set_epoch(from.epoch);
  to.set_newest_serial(from.newest_serial);
  to.mutable_received()->assign(reinterpret_cast<const char*>(from.received.data()), from.received.size());
  to.set_round_trip_s(from.round_trip_s);
}

bool read(const wire::PatchBegin& from, PatchBegin& to) {
  to.epoch = from.epoch();
  to.serial = from.serial();
  to.step_m = from.step_m();
  to.probe_radius_m = from.probe_radius_m();
  to.scene_hash = from.scene_hash();
  return read_vector(from.origin_m(), to.origin_m) && std::isnormal(to.step_m) && is_amount(to.step_m) && is_amount(to.probe_radius_m);
}

bool read(const wire::PatchCell& from, PatchCell& to) {
  to.epoch = from.epoch();
  to.serial = from.serial();
  to.level = from.level();
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
  to.object = from.object();
  to.stiffness_n_per_m = from.stiffness_n_per_m();
  to.damping_ns_per_m = from.damping_ns_per_m();
  to.friction_static = from.friction_static();
  to.friction_dynamic = from.friction_dynamic();
  to.two_sided = !from.one_sided();
  for (const double value : {to.stiffness_n_per_m, to.damping_ns_per_m, to.friction_static, to.friction_dynamic}) {
    if (!is_amount(value)) return false;
  }
  const std::size_t vertices = count_records(from.vertices(), PatchTile::kVertexBytes, PatchTile::kMostVertices);
  const std::size_t triangles = count_records(from.triangles(), 3, PatchTile::kMostTriangles);
  if (vertices == 0 || triangles == 0 || to.friction_dynamic > to.friction_static) return false;
  to.vertex_count = static_cast<std::uint8_t>(vertices);
  to.triangle_count = static_cast<std::uint8_t>(triangles);
  std::copy(from.vertices().begin(), from.vertices().end(), to.vertices.begin());
  std::copy(from.triangles().begin(), from.triangles().end(), to.triangles.begin());
  return std::all_of(to.triangles.begin(), to.triangles.begin() + static_cast<std::ptrdiff_t>(3 * triangles),
                     [&](std::uint8_t vertex) { return vertex < vertices; });
}

bool read(const wire::PatchStatus& from, PatchStatus& to) {
  to.is_wanted = from.is_wanted();
  to.epoch = from.epoch();
  to.newest_serial = from.newest_serial();
  to.round_trip_s = from.round_trip_s();
  if (from.received().size() != to.received.size()) return false;
  std::copy(from.received().begin(), from.received().end(), to.received.begin());
  return is_amount(static_cast<double>(to.round_trip_s));
}

}  // namespace hapton
