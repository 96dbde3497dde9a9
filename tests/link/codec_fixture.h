#pragma once

// Random datagrams, and a codec to pass them through.
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <random>
#include <set>
#include <type_traits>
#include <vector>
#include "link/codec.h"
#include "link/endpoint.h"
#include "tests/link/message_equality.h"
#include "tests/link/message_limits.h"
#include "tests/support/allocation_guard.h"

namespace hapton {

using Bytes = std::vector<std::byte>;

constexpr std::uint64_t kCodecSeed = 20240611;

class RandomDatagrams {
 public:
  explicit RandomDatagrams(std::uint64_t seed) : random_(seed) { testing::Test::RecordProperty("seed", std::to_string(seed)); }

  Datagram draw(std::size_t kind) {
    Datagram datagram;
    datagram.header = {bits(), bits(), bits(), time_ns()};
    datagram.message = draw_message(kind);
    return datagram;
  }

  std::uint64_t bits() { return random_(); }
  std::uint32_t bits32() { return static_cast<std::uint32_t>(random_()); }
  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

 private:
  bool flag() { return (random_() & 1U) != 0; }
  std::optional<Vec3> held_offset() { return flag() ? std::optional(vector()) : std::nullopt; }
  std::optional<std::uint32_t> haptons() { return flag() ? std::optional(bits32()) : std::nullopt; }
  std::optional<ObjectPush> push() { return flag() ? std::optional(ObjectPush{vector(), vector()}) : std::nullopt; }
  Vec3 vector() { return {number(-10, 10), number(-1e-6, 1e-6), number(-1e6, 1e6)}; }
  Quat rotation() { return Quat(number(-1, 1), number(-1, 1), number(-1, 1), number(0.1, 1)).normalized(); }
  std::int32_t object_or_none() { return static_cast<std::int32_t>(bits32() >> 1) - 1; }
  std::int64_t time_ns() { return static_cast<std::int64_t>(bits()) % (kMaxWireTimeNs + 1); }
  float rate() { return static_cast<float>(number(0, 1e4)); }

  Message draw_message(std::size_t kind) {
    const std::int64_t time = time_ns();
    switch (kind) {
      case 0:
        return Hello{static_cast<NodeRole>(1 + bits() % 4)};
      case 1:
        return Welcome{flag(), number(250, 1e4)};
      case 2:
        return Bye{};
      case 3:
        return draw_device_state(time);
      case 4:
        return ForceCommand{bits(),   time,     vector(), vector(), flag(),           bits32(),  bits32(),
                            bits32(), bits32(), bits(),   bits32(), object_or_none(), vector(),  vector(),
                            time,     bits32(), bits32(), bits32(), push(),           haptons(), held_offset()};
      case 5:
        return draw_view();
      case 6:
        return ProbeState{bits(),
                          time,
                          vector(),
                          rotation(),
                          vector(),
                          vector(),
                          flag(),
                          bits32(),
                          rate(),
                          rate(),
                          rate(),
                          bits32(),
                          static_cast<ProbeStatus>(bits() % 8),
                          bits32(),
                          object_or_none(),
                          vector(),
                          vector(),
                          rate(),
                          time,
                          push(),
                          haptons()};
      case 7:
        return FrameAck{bits(), time, rate(), bits32(), bits32(), flag(), flag()};
      case 8:
        return HandTarget{flag(), vector(), bits32(), vector()};
      case 9:
        return Settings{flag() ? 0.0 : number(kMinServoRateHz, kMaxServoRateHz), {'s', 'w', 'e', 'e', 'p'}, flag(), flag(), bits32()};
      case 10:
        return draw_setup();
      case 11:
        return ReportRequest{flag() ? ReportDocument::csv : ReportDocument::json, bits32(), bits32()};
      case 12:
        return draw_report_part();
      case 13:
        return draw_scene_facts();
      case 14:
        return ViewRejected{bits32()};
      case 15:
        return PatchBegin{bits32(),
                          bits32(),
                          vector(),
                          number(1e-9, 1),
                          number(0, 1),
                          bits(),
                          1 + draw_body_number(),
                          bits32(),
                          bits32(),
                          static_cast<std::uint32_t>(bits32() % (PatchEffects::kMaxAllBytes + 1))};
      case 16:
        return draw_cell();
      case 17:
        return draw_tile();
      case 18:
        return draw_patch_status();
      case 20:
        return MaterialRequest{bits32() | 1U, {"front hood"}, draw_material_change(1 + bits32() % MaterialChange::kAll)};
      case 21:
        return draw_materials();
      case 22:
        return ObjectPose{bits32() | 1U, static_cast<std::int32_t>(bits32() >> 1), flag(), vector(), rotation()};
      case 23:
        return draw_marker();
      case 24:
        return MarkerReply{bits32() | 1U, bits(), static_cast<MarkerStatus>(bits() % 4)};
      case 25:
        return draw_move_request();
      case 26:
        return draw_move_reply();
      case 27:
        return draw_move();
      case 28:
        return draw_carves();
      case 29:
        return CarveStatus{bits32() | 1U, bits32()};
      case 30:
        return draw_body();
      case 31:
        return PatchMaterial{bits32(), bits32(), bits32() >> 1, number(0, 1e4), number(0, 10), number(0.5, 1), number(0, 0.5)};
      case 32:
        return CarveUndo{bits32() | 1U, bits32() | 1U};
      case 33:
        return ShapeRequest{bits32() | 1U, bits32() | 1U,    {"front hood"}, static_cast<std::int32_t>(bits32() >> 1),
                            number(0, 10), draw_shape_part()};
      case 34:
        return draw_shape_reply();
      case 35:
        return ObjectShape{bits32() | 1U, bits32() | 1U, static_cast<std::int32_t>(bits32() >> 1), draw_shape_part()};
      case 36:
        return draw_shape_start();
      case 37:
        return ShapeStatus{bits32() | 1U, bits32() | 1U, static_cast<std::int32_t>(bits32() >> 1), draw_shape_part().first,
                           draw_shape_part().first};
      case 38:
        return draw_deformation();
      case 39:
        return draw_displacements();
      case 40:
        return draw_stream();
      case 41:
        return draw_effects();
      default:
        return LoopFacts{
            {'s', 'i', 'm'}, number(kMinServoRateHz, kMaxServoRateHz), static_cast<float>(number(0, 1)), static_cast<float>(number(0, 1))};
    }
  }

  MaterialChange draw_material_change(std::uint32_t fields) {
    const auto value = [&](std::uint32_t bit) { return (fields & bit) != 0 ? number(0, 1e6) : 0.0; };
    return {fields, value(MaterialChange::kStiffness), value(MaterialChange::kDamping), value(MaterialChange::kFrictionStatic),
            value(MaterialChange::kFrictionDynamic)};
  }

  ShapePart draw_shape_part() {
    ShapePart part{.total = 1 + bits32() % ShapePart::kMaxVertices};
    part.first = ShapePart::kVerticesPerPart * (bits32() % ShapePart::count_parts(part.total));
    for (std::size_t v = 0; v < part.count(); ++v) {
      for (float& x : part.displacements_m[v]) x = static_cast<float>(number(-1, 1));
    }
    return part;
  }

  ShapeReply draw_shape_reply() {
    ShapeReply reply{.stream = bits32() | 1U, .shape = bits32() | 1U, .object = static_cast<std::int32_t>(bits32() >> 1)};
    if (flag()) std::fill(reply.rejection.begin(), reply.rejection.end() - 1, 'r');
    reply.over_s = number(0, 1e5);
    reply.serial = bits32();
    return reply;
  }

  ShapeStart draw_shape_start() {
    ShapeStart start{.source = bits32() | 1U, .serial = bits32(), .object = static_cast<std::int32_t>(bits32() >> 1)};
    start.before = start.serial == 0 ? 0 : bits32() % start.serial;
    start.total = 1 + bits32() % ShapePart::kMaxVertices;
    start.start_ns = static_cast<std::int64_t>(bits() >> 4);
    start.end_ns = start.start_ns + static_cast<std::int64_t>(bits32());
    return start;
  }

  MaterialState draw_materials() {
    MaterialState state{.serial = bits32(), .request = bits32()};
    if (flag()) std::fill(state.rejection.begin(), state.rejection.end() - 1, 'r');
    state.object_count = static_cast<std::uint32_t>(bits32() % (MaterialState::kMaxObjects + 1));
    std::int32_t object = flag() ? -1 : 0;
    for (std::size_t i = 0; i < state.object_count; ++i) {
      state.objects[i] = {object, draw_material_change(bits32() % (MaterialChange::kAll + 1))};
      object += 1 + static_cast<std::int32_t>(bits32() % 1000);
    }
    return state;
  }

  std::int32_t object_index() { return static_cast<std::int32_t>(bits32() >> 1); }

  MoveRequest draw_move_request() {
    MoveRequest request{.request = bits32() | 1U, .number = object_index()};
    if (flag()) request.object = {"front hood"};
    const bool has_position = flag();
    if (has_position) request.p_m = vector();
    if (!has_position || flag()) request.q = rotation();
    if (flag()) request.over_s = number(1e-3, MoveRequest::kMaxSeconds);
    return request;
  }

  MoveReply draw_move_reply() {
    MoveReply reply{.request = bits32() | 1U, .object = object_index(), .over_s = number(0, 1e5), .serial = bits32()};
    if (flag()) std::fill(reply.rejection.begin(), reply.rejection.end() - 1, 'r');
    return reply;
  }

  ObjectMove draw_move() {
    const auto start_ns = static_cast<std::int64_t>(bits() >> 4);
    ObjectMove move = {bits32() | 1U, bits32(),   object_index(), start_ns,  start_ns + static_cast<std::int64_t>(bits32()),
                       vector(),      rotation(), vector(),       rotation()};
    if (flag()) std::fill(move.name.begin(), move.name.end() - 1, 'n');
    return move;
  }

  Carves draw_carves() {
    Carves carves{.source = bits32() | 1U, .newest = bits32()};
    carves.count = std::min(static_cast<std::uint32_t>(bits() % (Carves::kMax + 1)), carves.newest);
    if (carves.count > 0) carves.first = 1 + bits32() % (carves.newest - carves.count + 1);
    for (std::size_t n = 0; n < carves.count; ++n) {
      Carves::One& one = carves.carves[n];
      const std::uint32_t serial = carves.first + static_cast<std::uint32_t>(n);
      if (serial > 1 && bits() % 4 == 0) {
        one = {.object = -1, .undone_first = 1 + bits32() % (serial - 1)};
        one.undone_last = one.undone_first + bits32() % (serial - one.undone_first);
        continue;
      }
      one.object = object_index();
      one.begins = flag();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        one.from_m[axis] = static_cast<float>(number(-10, 10));
        one.to_m[axis] = one.from_m[axis] + static_cast<float>(number(-0.5, 0.5));
      }
      one.radius_m = static_cast<float>(number(1e-6, 1));
    }
    return carves;
  }

  Marker draw_marker() {
    Marker marker{.request = bits32() | 1U,
                  .text = {"gez\xC3\xBC"
                           "ckt"}};
    if (flag()) std::fill(marker.text.begin(), marker.text.end() - 1, 'm');
    return marker;
  }

  PatchCell draw_cell() {
    PatchCell cell{bits32(), bits32(), bits32() % (kPatchDeepestLevel + 1)};
    for (std::uint32_t& i : cell.index) i = bits32() % (1U << cell.level);
    for (std::size_t l = 0; l < cell.level; ++l) cell.empty_children[l] = static_cast<std::uint8_t>(bits());
    cell.tile_count = static_cast<std::uint32_t>(bits32() % (PatchCell::kMaxTiles + 1));
    for (std::size_t i = 0; i < cell.tile_count; ++i) cell.tiles[i] = bits32() % (1U << 20);
    cell.body = draw_body_number();
    return cell;
  }

  PatchTile draw_tile() {
    PatchTile tile{bits32(), bits32(), bits32(), bits32() >> 1, number(0, 1e4), number(0, 10), number(0.5, 1), number(0, 0.5), flag()};
    tile.vertex_count = static_cast<std::uint8_t>(1 + bits() % PatchTile::kMaxVertices);
    tile.triangle_count = static_cast<std::uint8_t>(1 + bits() % PatchTile::kMaxTriangles);
    for (std::size_t i = 0; i < tile.vertex_count * PatchTile::kVertexBytes; ++i) tile.vertices[i] = static_cast<std::uint8_t>(bits());
    for (std::size_t i = 0; i < tile.triangle_count * std::size_t{3}; ++i) {
      tile.triangles[i] = static_cast<std::uint8_t>(bits() % tile.vertex_count);
    }
    return tile;
  }

  std::uint32_t draw_body_number() { return static_cast<std::uint32_t>(bits32() % PatchBody::kMaxBodies); }

  PatchBody draw_body() {
    PatchBody body{bits32(), bits32(), draw_body_number(), static_cast<PatchBody::Motion>(bits() % 3)};
    if (flag()) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        body.lowest[axis] = bits32() >> 9;
        body.highest[axis] = body.lowest[axis] + (bits32() >> 9);
      }
    }
    body.deforms = flag();
    body.radius_m = number(0, 1);
    body.object = object_index();
    body.move_serial = bits32();
    body.loops = flag();
    if (body.motion != PatchBody::Motion::still) body.pivot_m = vector();
    if (body.motion != PatchBody::Motion::keyframes) return body;
    body.key_count = static_cast<std::uint32_t>(1 + bits32() % PatchBody::kMaxKeys);
    body.first_key = bits32() % 1000;
    body.all_keys = std::max(body.first_key + body.key_count + bits32() % 100, 2U);
    double time_s = number(0, 1);
    for (std::size_t n = 0; n < body.key_count; ++n) body.keys[n] = {time_s += number(1e-3, 1), vector(), rotation()};
    return body;
  }

  PatchDeformation draw_deformation() {
    PatchDeformation deformation{bits32(), bits32(), draw_body_number(), bits32(), bits32() | 1U, bits32()};
    deformation.target_count = static_cast<std::uint32_t>(1 + bits32() % PatchDeformation::kMaxTargets);
    deformation.loops = flag();
    const std::size_t numbers_per_key = PatchDeformation::numbers_of_key(deformation.target_count);
    deformation.key_count = static_cast<std::uint32_t>(1 + bits32() % (PatchDeformation::kMaxNumbers / numbers_per_key));
    deformation.first_key = bits32() % 1000;
    deformation.all_keys = deformation.first_key + deformation.key_count + bits32() % 100;
    double time_s = number(0, 1);
    for (std::size_t i = 0; i < deformation.key_count * numbers_per_key; ++i) {
      deformation.keys[i] = i % numbers_per_key == 0 ? time_s += number(1e-3, 1) : number(-2, 2);
    }
    return deformation;
  }

  PatchDisplacements draw_displacements() {
    PatchDisplacements displacements{bits32(), bits32(), bits32(), static_cast<std::uint32_t>(bits32() % PatchDeformation::kMaxTargets)};
    displacements.vertex_count = static_cast<std::uint8_t>(1 + bits() % PatchTile::kMaxVertices);
    for (std::size_t i = 0; i < 3 * std::size_t{displacements.vertex_count}; ++i) {
      displacements.displacements_m[i] = static_cast<float>(number(-0.01, 0.01));
    }
    return displacements;
  }

  PatchStream draw_stream() {
    PatchStream stream{bits32(), bits32(), draw_body_number(), bits32() >> 1, bits32() >> 1 | 1U};
    stream.object = object_index();
    stream.total = static_cast<std::uint32_t>(1 + bits32() % ShapePart::kMaxVertices);
    stream.reach_m = number(1e-3, 1);
    for (int n = 0; n < 9; ++n) stream.to_scene(n / 3, n % 3) = number(-1, 1);
    stream.shape_serial = bits32();
    stream.tile = stream.first_tile + bits32() % stream.tile_count;
    stream.vertex_count = static_cast<std::uint8_t>(1 + bits() % PatchTile::kMaxVertices);
    for (std::size_t v = 0; v < stream.vertex_count; ++v) stream.vertices[v] = static_cast<std::uint32_t>(bits32() % stream.total);
    return stream;
  }

  PatchEffects draw_effects() {
    PatchEffects effects{bits32(), bits32(), static_cast<std::uint32_t>(bits32() % 2000)};
    effects.byte_count = static_cast<std::uint32_t>(1 + bits32() % PatchEffects::kMaxBytes);
    for (std::size_t i = 0; i < effects.byte_count; ++i) effects.bytes[i] = static_cast<std::uint8_t>(bits());
    return effects;
  }

  PatchStatus draw_patch_status() {
    PatchStatus status{flag(), bits32(), bits32(), {}, rate(), bits32(), bits(), bits32(), flag(), rate()};
    for (std::uint8_t& byte : status.received) byte = static_cast<std::uint8_t>(bits());
    return status;
  }

  SceneFacts draw_scene_facts() {
    SceneFacts facts;
    const auto point = [&] { return SceneFacts::Point{rate(), -rate(), rate()}; };
    facts.given_hash = bits();
    facts.lowest_m = point();
    facts.highest_m = point();
    facts.point_count = static_cast<std::uint32_t>(bits32() % (SceneFacts::kMaxPoints + 1));
    for (std::size_t i = 0; i < facts.point_count; ++i) facts.points_m[i] = point();
    facts.preparing_s = static_cast<float>(bits32() % 100);
    facts.is_hand_inside = flag();
    facts.tool_hash = bits();
    return facts;
  }

  ReportPart draw_report_part() {
    ReportPart part;
    part.document = flag() ? ReportDocument::csv : ReportDocument::json;
    part.revision = bits32();
    part.part = bits32() % 100;
    part.parts = part.part + 1 + bits32() % 5;
    part.size = static_cast<std::uint16_t>(bits() % (part.text.size() + 1));
    std::fill_n(part.text.begin(), part.size, static_cast<char>(bits()));
    return part;
  }

  DeviceState draw_device_state(std::int64_t time) {
    DeviceState state{bits(), time, vector(), rotation(), bits32()};
    state.is_resumed = flag();
    if (state.is_resumed) state.p_WP = vector();
    if (flag()) state.scene_time_ns = std::abs(time_ns());
    return state;
  }

  HapticsSetup draw_setup() {
    HapticsSetup setup{bits32(),          bits32(),       draw_view().X_WS, bits(), {"scenes/car front.toml"},
                       {"0.1.0 release"}, {"name=proxy"}, bits32()};
    setup.material_serial = bits32();
    if (flag()) std::fill(setup.scene.begin(), setup.scene.end() - 1, 's');
    setup.scene_loading = bits32();
    if (flag()) std::fill(setup.rejection.begin(), setup.rejection.end() - 1, 'r');
    return setup;
  }

  ViewTransform draw_view() {
    ViewTransform view;
    view.revision = bits32();
    const Mat3 R = rotation().toRotationMatrix();
    const Vec3 t = vector();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        view.X_WS[static_cast<std::size_t>(4 * row + column)] = static_cast<float>(column < 3 ? R(row, column) : t[row]);
      }
    }
    return view;
  }

  std::mt19937_64 random_;
};

constexpr std::size_t kKinds = std::variant_size_v<Message>;
constexpr std::size_t kDeviceState = 3;  // a kind is an index into Message
constexpr std::size_t kForceCommand = 4;

class CodecTest : public testing::Test {
 protected:
  Bytes encode(const Datagram& datagram) {
    Bytes bytes(kMaxDatagramBytes);
    bytes.resize(codec_.encode(datagram, bytes));
    return bytes;
  }

  DecodeStatus decode(const Bytes& bytes) { return codec_.decode(bytes, decoded_); }

  template <class M>
  DecodeStatus round_trip(const M& message) {
    return decode(encode(Datagram{{1, 2, 3, 4}, message}));
  }

  Codec codec_;
  Datagram decoded_;
  RandomDatagrams random_{kCodecSeed};
};

}  // namespace hapton
