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
#include "tests/support/allocation_guard.h"

namespace hapton {

using Bytes = std::vector<std::byte>;

constexpr std::uint64_t kCodecSeed = 20240611;

class RandomDatagrams {
 public:
  explicit RandomDatagrams(std::uint64_t seed) : random_(seed) { testing::Test::RecordProperty("seed", std::to_string(seed)); }

  Datagram draw(std::size_t kind) {
    Datagram datagram;
    datagram.header = {bits(), bits(), bits(), static_cast<std::int64_t>(bits())};
    datagram.message = draw_message(kind);
    return datagram;
  }

  std::uint64_t bits() { return random_(); }
  std::uint32_t bits32() { return static_cast<std::uint32_t>(random_()); }
  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

 private:
  bool flag() { return (random_() & 1U) != 0; }
  std::optional<ObjectPush> push() { return flag() ? std::optional(ObjectPush{vector(), vector()}) : std::nullopt; }
  Vec3 vector() { return {number(-10, 10), number(-1e-6, 1e-6), number(-1e6, 1e6)}; }
  Quat rotation() { return Quat(number(-1, 1), number(-1, 1), number(-1, 1), number(0.1, 1)).normalized(); }
  std::int32_t object() { return static_cast<std::int32_t>(bits32() >> 1) - 1; }
  float rate() { return static_cast<float>(number(0, 1e4)); }

  Message draw_message(std::size_t kind) {
    const auto time = static_cast<std::int64_t>(bits());
    switch (kind) {
      case 0:
        return Hello{static_cast<NodeRole>(1 + bits() % 4)};
      case 1:
        return Welcome{flag(), number(250, 1e4)};
      case 2:
        return Bye{};
      case 3:
        return draw_state(time);
      case 4:
        return ForceCommand{bits(),   time,     vector(), vector(), flag(), bits32(), bits32(), bits32(), bits32(), bits(),
                            bits32(), object(), vector(), vector(), time,   bits32(), bits32(), bits32(), push()};
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
                          static_cast<ProbeStatus>(bits() % 7),
                          bits32(),
                          object(),
                          vector(),
                          vector(),
                          rate(),
                          time,
                          push()};
      case 7:
        return FrameAck{bits(), time, rate(), bits32(), bits32(), flag(), flag()};
      case 8:
        return HandTarget{flag(), vector(), bits32()};
      case 9:
        return Settings{flag() ? 0.0 : number(kMinServoRateHz, kMaxServoRateHz), {'s', 'w', 'e', 'e', 'p'}, flag(), flag(), bits32()};
      case 10:
        return draw_setup();
      case 11:
        return ReportRequest{flag() ? ReportDocument::csv : ReportDocument::json, bits32(), bits32()};
      case 12:
        return draw_part();
      case 13:
        return draw_facts();
      case 14:
        return ViewRejected{bits32()};
      case 15:
        return PatchBegin{bits32(), bits32(), vector(), number(1e-9, 1), number(0, 1), bits(), 1 + draw_body_number()};
      case 16:
        return draw_cell();
      case 17:
        return draw_tile();
      case 18:
        return draw_status();
      case 20:
        return MaterialRequest{bits32() | 1U, {"front hood"}, draw_change(1 + bits32() % MaterialChange::kAll)};
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
        return PatchMaterial{bits32(), bits32(), bits32(), number(0, 1e4), number(0, 10), number(0.5, 1), number(0, 0.5)};
      case 32:
        return CarveUndo{bits32() | 1U, bits32() | 1U};
      case 33:
        return ShapeRequest{bits32() | 1U, bits32() | 1U, {"front hood"}, static_cast<std::int32_t>(bits32() >> 1),
                            number(0, 10), draw_shape()};
      case 34:
        return draw_shape_reply();
      case 35:
        return ObjectShape{bits32() | 1U, bits32() | 1U, static_cast<std::int32_t>(bits32() >> 1), draw_shape()};
      case 36:
        return draw_shape_start();
      case 37:
        return ShapeStatus{bits32() | 1U, bits32() | 1U, static_cast<std::int32_t>(bits32() >> 1), draw_shape().first};
      default:
        return LoopFacts{{'s', 'i', 'm'}, rate(), static_cast<float>(number(0, 1))};
    }
  }

  MaterialChange draw_change(std::uint32_t given) {
    const auto value = [&](std::uint32_t bit) { return (given & bit) != 0 ? number(0, 1e6) : 0.0; };
    return {given, value(MaterialChange::kStiffness), value(MaterialChange::kDamping), value(MaterialChange::kFrictionStatic),
            value(MaterialChange::kFrictionDynamic)};
  }

  ShapePart draw_shape() {
    ShapePart part{.total = 1 + bits32() % ShapePart::kMostVertices};
    part.first = ShapePart::kMostHere * (bits32() % ShapePart::count_parts(part.total));
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
    start.total = 1 + bits32() % ShapePart::kMostVertices;
    start.start_ns = static_cast<std::int64_t>(bits() >> 2);
    start.end_ns = start.start_ns + static_cast<std::int64_t>(bits32());
    return start;
  }

  MaterialState draw_materials() {
    MaterialState state{.serial = bits32(), .request = bits32()};
    if (flag()) std::fill(state.rejection.begin(), state.rejection.end() - 1, 'r');
    state.object_count = bits32() % (MaterialState::kMostObjects + 1);
    std::int32_t object = flag() ? -1 : 0;
    for (std::size_t i = 0; i < state.object_count; ++i) {
      state.objects[i] = {object, draw_change(bits32() % (MaterialChange::kAll + 1))};
      object += 1 + static_cast<std::int32_t>(bits32() % 1000);
    }
    return state;
  }

  std::int32_t number_of_object() { return static_cast<std::int32_t>(bits32() >> 1); }

  MoveRequest draw_move_request() {
    MoveRequest request{.request = bits32() | 1U, .number = number_of_object()};
    if (flag()) request.object = {"front hood"};
    const bool has_position = flag();
    if (has_position) request.p_m = vector();
    if (!has_position || flag()) request.q = rotation();
    if (flag()) request.over_s = number(1e-3, MoveRequest::kMostSeconds);
    return request;
  }

  MoveReply draw_move_reply() {
    MoveReply reply{.request = bits32() | 1U, .object = number_of_object(), .over_s = number(0, 1e5), .serial = bits32()};
    if (flag()) std::fill(reply.rejection.begin(), reply.rejection.end() - 1, 'r');
    return reply;
  }

  ObjectMove draw_move() {
    const auto start_ns = static_cast<std::int64_t>(bits() >> 2);
    ObjectMove move = {bits32() | 1U, bits32(),   number_of_object(), start_ns,  start_ns + static_cast<std::int64_t>(bits32()),
                       vector(),      rotation(), vector(),           rotation()};
    if (flag()) std::fill(move.name.begin(), move.name.end() - 1, 'n');
    return move;
  }

  Carves draw_carves() {
    Carves carves{.source = bits32() | 1U, .newest = bits32()};
    carves.count = std::min(static_cast<std::uint32_t>(bits() % (Carves::kMost + 1)), carves.newest);
    if (carves.count > 0) carves.first = 1 + bits32() % (carves.newest - carves.count + 1);
    for (std::size_t n = 0; n < carves.count; ++n) {
      Carves::One& one = carves.carves[n];
      const std::uint32_t serial = carves.first + static_cast<std::uint32_t>(n);
      if (serial > 1 && bits() % 4 == 0) {
        one = {.object = -1, .undone_first = 1 + bits32() % (serial - 1)};
        one.undone_last = one.undone_first + bits32() % (serial - one.undone_first);
        continue;
      }
      one.object = number_of_object();
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
    cell.tile_count = bits32() % (PatchCell::kMostTiles + 1);
    for (std::size_t i = 0; i < cell.tile_count; ++i) cell.tiles[i] = bits32() % (1U << 20);
    cell.body = draw_body_number();
    return cell;
  }

  PatchTile draw_tile() {
    PatchTile tile{bits32(), bits32(), bits32(), bits32(), number(0, 1e4), number(0, 10), number(0.5, 1), number(0, 0.5), flag()};
    tile.vertex_count = static_cast<std::uint8_t>(1 + bits() % PatchTile::kMostVertices);
    tile.triangle_count = static_cast<std::uint8_t>(1 + bits() % PatchTile::kMostTriangles);
    for (std::size_t i = 0; i < tile.vertex_count * PatchTile::kVertexBytes; ++i) tile.vertices[i] = static_cast<std::uint8_t>(bits());
    for (std::size_t i = 0; i < tile.triangle_count * std::size_t{3}; ++i) {
      tile.triangles[i] = static_cast<std::uint8_t>(bits() % tile.vertex_count);
    }
    return tile;
  }

  std::uint32_t draw_body_number() { return static_cast<std::uint32_t>(bits32() % PatchBody::kMostBodies); }

  PatchBody draw_body() {
    PatchBody body{bits32(), bits32(), draw_body_number(), static_cast<PatchBody::Motion>(bits() % 3)};
    if (flag()) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        body.lowest[axis] = bits32() >> 9;
        body.highest[axis] = body.lowest[axis] + (bits32() >> 9);
      }
    }
    body.radius_m = number(0, 1);
    body.object = number_of_object();
    body.move_serial = bits32();
    body.loops = flag();
    if (body.motion != PatchBody::Motion::still) body.pivot_m = vector();
    if (body.motion != PatchBody::Motion::keyframes) return body;
    body.key_count = static_cast<std::uint32_t>(1 + bits32() % PatchBody::kMostKeys);
    body.first_key = bits32() % 1000;
    body.all_keys = std::max(body.first_key + body.key_count + bits32() % 100, 2U);
    double time_s = number(0, 1);
    for (std::size_t n = 0; n < body.key_count; ++n) body.keys[n] = {time_s += number(1e-3, 1), vector(), rotation()};
    return body;
  }

  PatchStatus draw_status() {
    PatchStatus status{flag(), bits32(), bits32(), {}, rate(), bits32(), bits()};
    for (std::uint8_t& byte : status.received) byte = static_cast<std::uint8_t>(bits());
    return status;
  }

  SceneFacts draw_facts() {
    SceneFacts facts;
    const auto point = [&] { return SceneFacts::Point{rate(), -rate(), rate()}; };
    facts.given_hash = bits();
    facts.lowest_m = point();
    facts.highest_m = point();
    facts.point_count = bits32() % (SceneFacts::kMostPoints + 1);
    for (std::size_t i = 0; i < facts.point_count; ++i) facts.points_m[i] = point();
    facts.preparing_s = static_cast<float>(bits32() % 100);
    facts.is_hand_inside = flag();
    return facts;
  }

  ReportPart draw_part() {
    ReportPart part;
    part.document = flag() ? ReportDocument::csv : ReportDocument::json;
    part.revision = bits32();
    part.part = bits32() % 100;
    part.parts = part.part + 1 + bits32() % 5;
    part.size = static_cast<std::uint16_t>(bits() % (part.text.size() + 1));
    std::fill_n(part.text.begin(), part.size, static_cast<char>(bits()));
    return part;
  }

  DeviceState draw_state(std::int64_t time) {
    DeviceState state{bits(), time, vector(), rotation(), bits32()};
    state.is_resumed = flag();
    if (state.is_resumed) state.p_WP = vector();
    if (flag()) state.scene_time_ns = static_cast<std::int64_t>(bits() >> 1);
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

inline void expect_sane(const ShapePart& part) {
  EXPECT_TRUE(part.total > 0 && part.total <= ShapePart::kMostVertices);
  EXPECT_LT(part.first, part.total);
  EXPECT_EQ(part.first % ShapePart::kMostHere, 0U);
  for (const ShapePart::Displacement& one : part.displacements_m) {
    for (const float x : one) EXPECT_TRUE(std::abs(x) <= 1e9F) << "finite as well";
  }
}

inline void expect_sane(const MaterialChange& change) {
  EXPECT_LE(change.given, MaterialChange::kAll);
  for (const double number : {change.stiffness_n_per_m, change.damping_ns_per_m, change.friction_static, change.friction_dynamic}) {
    EXPECT_TRUE(number >= 0.0 && number <= kMaxWireMagnitude);
  }
}

// Every message that decode accepts must satisfy the limits that link/messages.h states.
inline void expect_sane(const Datagram& datagram) {
  if (const auto* state = std::get_if<DeviceState>(&datagram.message)) {
    EXPECT_TRUE(state->p_WD.allFinite());
    EXPECT_NEAR(state->q_WT.norm(), 1.0, 1e-3);
  } else if (const auto* force = std::get_if<ForceCommand>(&datagram.message)) {
    EXPECT_TRUE(force->force_n.allFinite());
    EXPECT_LE(force->force_n.cwiseAbs().maxCoeff(), kMaxWireMagnitude);
    EXPECT_TRUE(force->visual_offset_m.allFinite());
    EXPECT_TRUE(force->torque_nm.allFinite() && force->visual_turn.allFinite());
    EXPECT_TRUE(!force->push || (force->push->force_n.allFinite() && force->push->torque_nm.allFinite()));
  } else if (const auto* probe = std::get_if<ProbeState>(&datagram.message)) {
    EXPECT_TRUE(probe->p_WD.allFinite() && probe->force_n.allFinite() && probe->visual_offset_m.allFinite());
    EXPECT_TRUE(probe->torque_nm.allFinite() && probe->visual_turn.allFinite());
    EXPECT_TRUE(!probe->push || (probe->push->force_n.allFinite() && probe->push->torque_nm.allFinite()));
    EXPECT_TRUE(std::isfinite(probe->servo_rate_hz));
  } else if (const auto* view = std::get_if<ViewTransform>(&datagram.message)) {
    for (const float value : view->X_WS) {
      EXPECT_TRUE(std::isfinite(value));
    }
  } else if (const auto* hello = std::get_if<Hello>(&datagram.message)) {
    EXPECT_GE(static_cast<int>(hello->role), 1);
    EXPECT_LE(static_cast<int>(hello->role), 4);
  } else if (const auto* settings = std::get_if<Settings>(&datagram.message)) {
    EXPECT_TRUE(settings->servo_rate_hz == 0.0 ||
                (settings->servo_rate_hz >= kMinServoRateHz && settings->servo_rate_hz <= kMaxServoRateHz));
  } else if (const auto* setup = std::get_if<HapticsSetup>(&datagram.message)) {
    for (const HapticsSetup::Text& text : {setup->scene, setup->build, setup->method, setup->rejection}) {
      EXPECT_EQ(text.back(), '\0');
      EXPECT_TRUE(std::none_of(text.begin(), text.end(), [](char c) { return (c > 0 && c < ' ') || c == '\x7f'; }));
    }
  } else if (const auto* facts = std::get_if<SceneFacts>(&datagram.message)) {
    EXPECT_LE(facts->point_count, facts->points_m.size());
    for (const SceneFacts::Point& point : facts->points_m) {
      for (const float value : point) EXPECT_LE(std::abs(value), static_cast<float>(kMaxWireMagnitude));
    }
  } else if (const auto* part = std::get_if<ReportPart>(&datagram.message)) {
    EXPECT_LE(part->size, part->text.size());
    EXPECT_LT(part->part, part->parts);
  } else if (const auto* begin = std::get_if<PatchBegin>(&datagram.message)) {
    EXPECT_TRUE(begin->origin_m.allFinite());
    EXPECT_GT(begin->step_m, 0.0);
    EXPECT_GE(begin->probe_radius_m, 0.0);
  } else if (const auto* cell = std::get_if<PatchCell>(&datagram.message)) {
    ASSERT_LE(cell->level, static_cast<std::uint32_t>(kPatchDeepestLevel));
    for (const std::uint32_t i : cell->index) EXPECT_LT(i, 1U << cell->level);
    EXPECT_LE(cell->tile_count, cell->tiles.size());
  } else if (const auto* tile = std::get_if<PatchTile>(&datagram.message)) {
    ASSERT_LE(tile->vertex_count, PatchTile::kMostVertices);
    ASSERT_LE(tile->triangle_count, PatchTile::kMostTriangles);
    for (std::size_t i = 0; i < std::size_t{3} * tile->triangle_count; ++i) EXPECT_LT(tile->triangles[i], tile->vertex_count);
    EXPECT_TRUE(std::isfinite(tile->stiffness_n_per_m) && tile->stiffness_n_per_m >= 0.0);
    EXPECT_LE(tile->friction_dynamic, tile->friction_static);
  } else if (const auto* status = std::get_if<PatchStatus>(&datagram.message)) {
    EXPECT_TRUE(std::isfinite(status->round_trip_s) && status->round_trip_s >= 0.0F);
  } else if (const auto* request = std::get_if<MaterialRequest>(&datagram.message)) {
    EXPECT_NE(request->request, 0U);
    EXPECT_EQ(request->object.back(), '\0');
    EXPECT_NE(request->change.given, 0U);
    expect_sane(request->change);
  } else if (const auto* marker = std::get_if<Marker>(&datagram.message)) {
    EXPECT_NE(marker->request, 0U);
    EXPECT_EQ(marker->text.back(), '\0');
    EXPECT_TRUE(MarkerText::is_valid(marker->text.data()));
  } else if (const auto* reply = std::get_if<MarkerReply>(&datagram.message)) {
    EXPECT_LE(reply->status, MarkerStatus::no_room);
  } else if (const auto* state_of_materials = std::get_if<MaterialState>(&datagram.message)) {
    ASSERT_LE(state_of_materials->object_count, state_of_materials->objects.size());
    EXPECT_EQ(state_of_materials->rejection.back(), '\0');
    for (std::size_t i = 0; i < state_of_materials->object_count; ++i) {
      EXPECT_GE(state_of_materials->objects[i].object, -1);
      expect_sane(state_of_materials->objects[i].change);
    }
  } else if (const auto* wanted = std::get_if<MoveRequest>(&datagram.message)) {
    EXPECT_NE(wanted->request, 0U);
    EXPECT_EQ(wanted->object.back(), '\0');
    EXPECT_GE(wanted->number, 0);
    EXPECT_TRUE(wanted->p_m || wanted->q);
    EXPECT_TRUE(!wanted->p_m || wanted->p_m->allFinite());
    EXPECT_TRUE(!wanted->q || std::abs(wanted->q->norm() - 1.0) <= 1.1e-3);
    EXPECT_TRUE(!wanted->over_s || (*wanted->over_s > 0.0 && *wanted->over_s <= MoveRequest::kMostSeconds));
  } else if (const auto* move_reply = std::get_if<MoveReply>(&datagram.message)) {
    EXPECT_NE(move_reply->request, 0U);
    EXPECT_EQ(move_reply->rejection.back(), '\0');
    EXPECT_TRUE(std::isfinite(move_reply->over_s) && move_reply->over_s >= 0.0);
  } else if (const auto* move = std::get_if<ObjectMove>(&datagram.message)) {
    EXPECT_NE(move->source, 0U);
    EXPECT_GE(move->object, 0);
    EXPECT_GE(move->start_ns, 0);
    EXPECT_GE(move->end_ns, move->start_ns);
    EXPECT_TRUE(move->from_p_m.allFinite() && move->to_p_m.allFinite());
    EXPECT_NEAR(move->from_q.norm(), 1.0, 1.1e-3);
    EXPECT_NEAR(move->to_q.norm(), 1.0, 1.1e-3);
  } else if (const auto* carves = std::get_if<Carves>(&datagram.message)) {
    EXPECT_NE(carves->source, 0U);
    ASSERT_LE(carves->count, Carves::kMost);
    EXPECT_EQ(carves->count == 0, carves->first == 0);
    EXPECT_LE(std::uint64_t{carves->first} + carves->count, std::uint64_t{carves->newest} + 1);
    for (std::size_t n = 0; n < carves->count; ++n) {
      const Carves::One& one = carves->carves[n];
      if (one.is_undo()) {
        EXPECT_EQ(one.object, -1);
        EXPECT_LE(one.undone_first, one.undone_last);
        EXPECT_LT(one.undone_last, carves->first + n);
        continue;
      }
      EXPECT_GE(one.object, 0);
      const Vec3 from(one.from_m[0], one.from_m[1], one.from_m[2]);
      const Vec3 to(one.to_m[0], one.to_m[1], one.to_m[2]);
      EXPECT_TRUE((to - from).norm() <= 1000.0) << "finite as well";
      EXPECT_TRUE(one.radius_m > 0.0F && one.radius_m <= 1000.0F);
    }
  } else if (const auto* carve_status = std::get_if<CarveStatus>(&datagram.message)) {
    EXPECT_NE(carve_status->source, 0U);
  } else if (const auto* undo = std::get_if<CarveUndo>(&datagram.message)) {
    EXPECT_TRUE(undo->source != 0 && undo->serial != 0);
  } else if (const auto* wanted_shape = std::get_if<ShapeRequest>(&datagram.message)) {
    EXPECT_TRUE(wanted_shape->stream != 0 && wanted_shape->shape != 0);
    EXPECT_TRUE(wanted_shape->over_s >= 0.0 && wanted_shape->over_s <= ShapeRequest::kMostSeconds);
    EXPECT_GE(wanted_shape->number, 0);
    expect_sane(wanted_shape->part);
  } else if (const auto* shape = std::get_if<ObjectShape>(&datagram.message)) {
    EXPECT_TRUE(shape->source != 0 && shape->serial != 0 && shape->object >= 0);
    expect_sane(shape->part);
  } else if (const auto* start = std::get_if<ShapeStart>(&datagram.message)) {
    EXPECT_TRUE(start->source != 0 && start->object >= 0);
    EXPECT_TRUE(start->serial == 0 ? start->before == 0 : start->before < start->serial);
    EXPECT_TRUE(start->total > 0 && start->total <= ShapePart::kMostVertices);
    EXPECT_TRUE(start->start_ns >= 0 && start->end_ns >= start->start_ns);
  } else if (const auto* shape_status = std::get_if<ShapeStatus>(&datagram.message)) {
    EXPECT_TRUE(shape_status->source != 0 && shape_status->serial != 0 && shape_status->object >= 0);
    EXPECT_EQ(shape_status->first % ShapePart::kMostHere, 0U);
    EXPECT_LT(shape_status->first, ShapePart::kMostVertices);
  } else if (const auto* shape_reply = std::get_if<ShapeReply>(&datagram.message)) {
    EXPECT_TRUE(shape_reply->stream != 0 && shape_reply->shape != 0 && shape_reply->over_s >= 0.0);
  } else if (const auto* pose = std::get_if<ObjectPose>(&datagram.message)) {
    EXPECT_NE(pose->serial, 0U);
    EXPECT_GE(pose->object, 0);
    EXPECT_TRUE(pose->p_m.allFinite());
    EXPECT_NEAR(pose->q.norm(), 1.0, 1.1e-3);
  }
}

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
