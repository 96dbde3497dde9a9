#include "patch/patch_source.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <type_traits>
#include <utility>
#include <variant>

#include "core/force/deforming_method.h"
#include "core/force/streamed_method.h"
#include "core/math/commanded_motion.h"
#include "patch/patch_store.h"

namespace hapton {
namespace {

constexpr std::int64_t kPlanEveryNs = 20'000'000;     // at 1 m/s the hand moves 2 cm in this time
constexpr std::int64_t kMinPatienceNs = 150'000'000;  // the hub's status comes ten times a second
constexpr std::uint32_t kReordered = 64;              // a part this many serials before the newest received one counts as lost
// If the round trip is longer than this, a lost part would be missing for long: each part is sent again before it can be confirmed.
constexpr double kLongRoundTripS = 0.3;
constexpr double kBurstBytes = 5000.0;  // at most four datagrams at once, however long nothing was sent
// What the envelope, the seal, UDP and IP add to a part's own numbers.
constexpr double kOverheadBytes = 150.0;
// A move that the hub has not confirmed after this time and a round trip is sent again; the hub confirms within 50 ms.
constexpr std::int64_t kMovePatienceNs = 70'000'000;
constexpr int kMaxMoveRepeats = 8;  // after so many a move counts as received

bool is_same(const Material& a, const Material& b) {
  return a.stiffness_n_per_m == b.stiffness_n_per_m && a.damping_ns_per_m == b.damping_ns_per_m && a.friction_static == b.friction_static &&
         a.friction_dynamic == b.friction_dynamic;
}

double bytes_of(const PatchTile& tile) {
  return kOverheadBytes + static_cast<double>(PatchTile::kVertexBytes) * tile.vertex_count + 3.0 * tile.triangle_count;
}
double bytes_of(const PatchCell& cell) { return kOverheadBytes + 3.0 * cell.tile_count; }
double bytes_of(const PatchBegin&) { return kOverheadBytes; }

double bytes_of(const PatchBody& body) { return kOverheadBytes + 100.0 + 64.0 * body.key_count; }
double bytes_of(const PatchMaterial&) { return kOverheadBytes; }
double bytes_of(const PatchEffects& effects) { return kOverheadBytes + effects.byte_count; }
double bytes_of(const ObjectMove&) { return kOverheadBytes + 150.0; }

double bytes_of(const PatchDeformation& deformation) {
  return kOverheadBytes + 8.0 * deformation.key_count * static_cast<double>(PatchDeformation::numbers_of_key(deformation.target_count));
}
double bytes_of(const PatchDisplacements& displaced) { return kOverheadBytes + 12.0 * displaced.vertex_count; }
double bytes_of(const PatchStream& stream) { return kOverheadBytes + 120.0 + 2.0 * stream.vertex_count; }

// The size of a message that PatchSource sends; 0 for other messages.
double compute_bytes(const Message& message) {
  return std::visit(
      []<class Kind>(const Kind& one) {
        if constexpr (kIsScenePart<Kind> || std::is_same_v<Kind, ObjectMove>) return bytes_of(one);
        return 0.0;
      },
      message);
}

}  // namespace

void HandMotion::follow(const Vec3& p, double dt_s) noexcept {
  const Vec3 moved = p - std::exchange(p_SD, p);
  if (dt_s > 0.0 && dt_s < 1.0) v_SD += std::min(dt_s / kMeanS, 1.0) * (moved / dt_s - v_SD);
}

PatchSource::PatchSource(TiledScene scene, double probe_radius_m, std::uint64_t scene_hash, std::uint32_t epoch, const Options& options)
    : scene_(std::move(scene)),
      begin_{epoch, 0, scene_.grid.origin_m, scene_.grid.step_m, probe_radius_m, scene_hash},
      options_(options),
      in_flight_(kSerials, 0),
      credit_bytes_(kBurstBytes) {
  begin_.body_count = static_cast<std::uint32_t>(std::max<std::size_t>(scene_.bodies.size(), 1));
  begin_.effect_bytes = static_cast<std::uint32_t>(scene_.effects.size());
  hands_.resize(begin_.body_count);
  hand_ahead_.resize(begin_.body_count);
  for (std::uint32_t b = 0; begin_.body_count > 1 && b < begin_.body_count; ++b) {
    const KeyframeMotion* motion = scene_.bodies[b].group.motion.get();
    const std::size_t keys = motion != nullptr ? motion->keyframes().size() : 1;
    for (std::uint32_t first = 0; first < keys; first += PatchBody::kMaxKeys) body_parts_.push_back({b, first});
  }
  for (std::uint32_t b = 0; b < scene_.bodies.size(); ++b) {
    const MeshDeformation* deformation = scene_.bodies[b].deformation.get();
    if (deformation == nullptr) continue;
    const std::size_t in_message = PatchDeformation::kMaxNumbers / (1 + deformation->targets().size());
    for (std::size_t first = 0; first < deformation->keys().size(); first += in_message) {
      weight_parts_.push_back({b, static_cast<std::uint32_t>(first)});
    }
  }
  items_.resize(item_of_material(0));
  for (const PatchTile& tile : scene_.tiles) {
    if (tile.object >= tile_materials_.size()) tile_materials_.resize(tile.object + 1);
    tile_materials_[tile.object] = material_of(tile);
  }
}

std::int64_t PatchSource::resend_after_ns() const noexcept {
  const double round_trip_s = std::min(round_trip_s_, 10.0);
  const double wait_s = round_trip_s < kLongRoundTripS ? 1.2 * round_trip_s : 0.5 * round_trip_s;
  return kMinPatienceNs + static_cast<std::int64_t>(1e9 * wait_s);
}

bool PatchSource::is_due(const Item& item, std::int64_t now_ns) const noexcept {
  return item.state == State::missing || (item.state == State::sent && now_ns - item.sent_ns > resend_after_ns());
}

void PatchSource::accept(const PatchStatus& status) noexcept {
  round_trip_s_ = status.round_trip_s;
  for (MoveItem& item : moves_) {
    const std::uint32_t back = status.newest_move - item.move.serial;
    if (item.is_held && item.move.serial > status.newest_move) item = {item.move};
    if (item.move.serial <= status.newest_move && back < 64 && ((status.moves_received >> back) & 1U) != 0) item.is_held = true;
  }
  if (status.epoch == 0 && counts_.held > 0) return begin_again();
  if (status.epoch != begin_.epoch || status.newest_serial > serial_) return;
  for (std::uint32_t back = 0; back < PatchStatus::kSerials && back < status.newest_serial; ++back) {
    const std::uint32_t serial = status.newest_serial - back;
    if (serial_ - serial >= kSerials) break;
    Item& item = items_[in_flight_[serial % kSerials]];
    const bool is_received = ((status.received[back / 8] >> (back % 8)) & 1U) != 0;
    // A material can change after it was sent: the hub may have received the older one.
    const bool is_current = item.first_serial != 0 && serial >= item.first_serial;
    if (is_received && is_current && item.state != State::held) {
      item.state = State::held;
      item.serial = serial;
      ++counts_.held;
    } else if (!is_received && item.state == State::held && item.serial == serial) {
      return begin_again();  // confirmed before: the status in which the hub said that it begins again was lost
    } else if (!is_received && back >= kReordered && item.state == State::sent && item.serial == serial) {
      item.state = State::missing;
    }
  }
}

// The hub has started again and has lost what it had received.
void PatchSource::begin_again() noexcept {
  std::fill(items_.begin(), items_.end(), Item());
  counts_.held = 0;
}

void PatchSource::note_move(const ObjectMove& move, std::int64_t sent_ns) noexcept {
  if (move.serial == 0) return;
  const auto known = std::find_if(moves_.begin(), moves_.end(), [&](const MoveItem& one) { return one.move.object == move.object; });
  if (known == moves_.end()) {
    if (moves_.size() < PatchBody::kMaxBodies) moves_.push_back({.move = move, .sent_ns = sent_ns});
  } else if (known->move.serial < move.serial) {
    *known = {.move = move, .sent_ns = sent_ns};
  }
}

void PatchSource::note_shape(std::int32_t object, std::uint32_t serial) {
  for (PatchStream& stream : scene_.streams) {
    if (stream.object == object) stream.shape_serial = std::max(stream.shape_serial, serial);
  }
}

void PatchSource::set_materials(const std::vector<Material>& materials) {
  for (std::uint32_t object = 0; object < std::min(materials.size(), tile_materials_.size()); ++object) {
    auto known = std::find_if(tuned_objects_.begin(), tuned_objects_.end(), [&](const TunedObject& one) { return one.object == object; });
    if (is_same(known != tuned_objects_.end() ? known->material : tile_materials_[object], materials[object])) continue;
    if (known == tuned_objects_.end()) {
      known = tuned_objects_.insert(known, {object, materials[object]});
      items_.resize(item_of_material(tuned_objects_.size()));
    }
    known->material = materials[object];
    items_[item_of_material(static_cast<std::size_t>(known - tuned_objects_.begin()))] = Item();
  }
  planned_ns_ = 0;
}

// From the box to the hand or to its expected places; such a place counts as farther away, by half its distance from the hand.
double PatchSource::distance_of(const Box& bounds, std::uint32_t body) const noexcept {
  const std::array<Vec3, 3>& ahead = hand_ahead_[body];
  double nearest = std::sqrt(bounds.distance_squared(ahead[0]));
  for (std::size_t i = 1; i < ahead.size(); ++i) {
    nearest = std::min(nearest, std::sqrt(bounds.distance_squared(ahead[i])) + 0.5 * (ahead[i] - ahead[0]).norm());
  }
  return nearest;
}

// A part is sent if it is within this distance of the hand, in steps of the grid; a moving body may also come towards the hand.
double PatchSource::reach_of(std::uint32_t body) const noexcept {
  const double body_m_per_s = scene_.bodies[body].moves() ? kMaxSurfaceSpeed : 0.0;
  return (options_.least_reach_m + 2.0 * (0.1 + round_trip_s_) * (options_.fastest_m_per_s + body_m_per_s)) / scene_.grid.step_m;
}

void PatchSource::plan(std::int64_t now_ns) {
  planned_.clear();
  planned_ns_ = now_ns;
  plan_bodies(now_ns);
  plan_tiles(now_ns);
  std::reverse(planned_.begin(), planned_.end());
}

// Plans the parts that concern the whole scene, wherever the hand is.
void PatchSource::plan_bodies(std::int64_t now_ns) {
  for (std::size_t item = 0; item < item_of_cell(0); ++item) {
    if (is_due(items_[item], now_ns)) planned_.push_back(item);
  }
  for (std::size_t item = item_of_material(0); item < items_.size(); ++item) {
    if (is_due(items_[item], now_ns)) planned_.push_back(item);
  }
}

// A deforming body can be felt only when all of it has arrived, so all its parts are planned.
template <class Add>
void PatchSource::plan_deforming(std::uint32_t body, Add&& add) {
  for (std::size_t part = 0; part < weight_parts_.size(); ++part) {
    if (weight_parts_[part].body == body) add(item_of_weights(part));
  }
  const TileBody& deforming_body = scene_.bodies[body];
  for (std::size_t n = 0; n < deforming_body.tile_count; ++n) add(item_of_tile(deforming_body.first_tile + n));
  for (std::size_t n = 0; n < deforming_body.displaced_count; ++n) add(item_of_displaced(deforming_body.first_displaced + n));
  for (std::size_t n = 0; n < deforming_body.stream_count; ++n) add(item_of_stream(deforming_body.first_stream + n));
}

// Plans the cells nearest to the hand first, each cell before its tiles: a tile without its cell is of no use.
void PatchSource::plan_tiles(std::int64_t now_ns) {
  const double lead_s = 0.1 + round_trip_s_;
  for (std::size_t body = 0; body < hand_ahead_.size(); ++body) {
    for (std::size_t i = 0; i < hand_ahead_[body].size(); ++i) {
      hand_ahead_[body][i] = scene_.grid.to_steps(hands_[body].p_SD + static_cast<double>(i) / 2.0 * lead_s * hands_[body].v_SD);
    }
  }
  using AtDistance = std::pair<double, std::size_t>;
  std::priority_queue<AtDistance, std::vector<AtDistance>, std::greater<>> nearest;
  const auto consider = [&](const Box& bounds, std::uint32_t body, std::size_t key) {
    const double distance = distance_of(bounds, body);
    if (distance <= reach_of(body)) nearest.emplace(distance, key);
  };
  const auto consider_node = [&](std::size_t node) { consider(scene_.nodes[node].key.bounds(), scene_.nodes[node].body, node); };
  const std::size_t first_body = scene_.nodes.size();
  for (std::uint32_t b = 0; b < scene_.bodies.size(); ++b) {
    const TileBody& body = scene_.bodies[b];
    if (body.deforms()) consider(body.bounds, b, first_body + b);
    if (body.root >= 0) consider_node(static_cast<std::size_t>(body.root));
  }
  // Parts that have not been sent come before parts that may have arrived.
  std::vector<std::size_t> repeated_items;
  const auto add = [&](std::size_t item) {
    if (items_[item].state == State::missing && planned_.size() < kMaxPlanned) planned_.push_back(item);
    if (items_[item].state == State::sent && repeated_items.size() < kMaxPlanned && is_due(items_[item], now_ns))
      repeated_items.push_back(item);
  };
  while (!nearest.empty() && planned_.size() < kMaxPlanned) {
    const std::size_t key = nearest.top().second;
    nearest.pop();
    if (key >= first_body) {
      plan_deforming(static_cast<std::uint32_t>(key - first_body), add);
      continue;
    }
    const TileNode node = scene_.nodes[key];
    if (node.first_child >= 0) {
      for (std::size_t octant = 0; octant < 8; ++octant) consider_node(static_cast<std::size_t>(node.first_child) + octant);
    } else if (node.cell >= 0) {
      const auto cell = static_cast<std::size_t>(node.cell);
      add(item_of_cell(cell));
      for (const std::uint32_t tile : scene_.cells[cell].tiles) add(item_of_tile(tile));
    }
  }
  planned_.insert(planned_.end(), repeated_items.begin(), repeated_items.end());
}

PatchBody PatchSource::make_body(const BodyPart& part) const {
  const TileBody& body = scene_.bodies[part.body];
  PatchBody message{.epoch = begin_.epoch, .serial = serial_, .body = part.body};
  if (!body.bounds.is_empty()) {
    for (int axis = 0; axis < 3; ++axis) {
      message.lowest[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(body.bounds.low[axis]);
      message.highest[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(body.bounds.high[axis]);
    }
  }
  message.deforms = body.deforms();
  message.pivot_m = body.pivot_m;
  message.radius_m = body.radius_m;
  if (body.group.commanded >= 0) {
    message.motion = PatchBody::Motion::commanded;
    message.object = body.group.objects.front();
    for (const MoveItem& item : moves_) {
      if (item.move.object == message.object) message.move_serial = item.move.serial;
    }
  } else if (const KeyframeMotion* motion = body.group.motion.get(); motion != nullptr) {
    const std::vector<Keyframe>& keys = motion->keyframes();
    message.motion = PatchBody::Motion::keyframes;
    message.loops = motion->loops();
    message.all_keys = static_cast<std::uint32_t>(keys.size());
    message.first_key = part.first_key;
    message.key_count = std::min(message.all_keys - part.first_key, static_cast<std::uint32_t>(PatchBody::kMaxKeys));
    std::copy_n(keys.begin() + part.first_key, message.key_count, message.keys.begin());
  }
  return message;
}

PatchDeformation PatchSource::make_deformation(const WeightPart& part) const {
  const TileBody& body = scene_.bodies[part.body];
  const std::vector<MorphKey>& keys = body.deformation->keys();
  PatchDeformation message{.epoch = begin_.epoch, .serial = serial_, .body = part.body};
  message.first_tile = body.first_tile;
  message.tile_count = body.tile_count;
  message.displaced_count = static_cast<std::uint32_t>(body.displaced_count);
  message.target_count = static_cast<std::uint32_t>(body.deformation->targets().size());
  message.loops = body.deformation->loops();
  message.all_keys = static_cast<std::uint32_t>(keys.size());
  message.first_key = part.first_key;
  const std::size_t each = PatchDeformation::numbers_of_key(message.target_count);
  message.key_count = std::min(message.all_keys - part.first_key, static_cast<std::uint32_t>(PatchDeformation::kMaxNumbers / each));
  for (std::size_t n = 0; n < message.key_count; ++n) {
    const MorphKey& key = keys[part.first_key + n];
    message.keys[n * each] = key.time_s;
    std::copy(key.weights.begin(), key.weights.end(), message.keys.begin() + static_cast<std::ptrdiff_t>(n * each + 1));
  }
  return message;
}

// A move that has to be sent now; null: none.
PatchSource::MoveItem* PatchSource::find_due_move(std::int64_t now_ns) noexcept {
  const std::int64_t wait_ns = kMovePatienceNs + static_cast<std::int64_t>(1e9 * std::min(round_trip_s_, 10.0));
  const auto due = std::find_if(moves_.begin(), moves_.end(), [&](const MoveItem& item) {
    return !item.is_held && (item.sent_ns < 0 || now_ns - item.sent_ns >= wait_ns);
  });
  return due != moves_.end() ? &*due : nullptr;
}

std::optional<Message> PatchSource::take_move(MoveItem& item, std::int64_t now_ns) {
  if (!spend_credit(item.move, now_ns)) return std::nullopt;
  counts_.moves_repeated += item.sent_ns >= 0 ? 1 : 0;
  item.sent_ns = now_ns;
  // The hub confirms only the last 64 moves of all objects: an older move would be repeated without end.
  item.is_held = ++item.repeats >= kMaxMoveRepeats;
  return item.move;
}

Message PatchSource::make_message(std::size_t item) {
  if (item == 0) {
    begin_.serial = serial_;
    return begin_;
  }
  if (item < item_of_effects(0)) return make_body(body_parts_[item - 1]);
  if (item < item_of_cell(0)) {
    PatchEffects effects = make_effect_part(scene_.effects, static_cast<std::uint32_t>(item - item_of_effects(0)));
    effects.epoch = begin_.epoch;
    effects.serial = serial_;
    return effects;
  }
  if (item >= item_of_material(0)) {
    const auto& [object, material] = tuned_objects_[item - item_of_material(0)];
    return PatchMaterial{begin_.epoch,
                         serial_,
                         object,
                         material.stiffness_n_per_m,
                         material.damping_ns_per_m,
                         material.friction_static,
                         material.friction_dynamic};
  }
  if (item >= item_of_stream(0)) {
    PatchStream stream = scene_.streams[item - item_of_stream(0)];
    stream.epoch = begin_.epoch;
    stream.serial = serial_;
    return stream;
  }
  if (item >= item_of_displaced(0)) {
    PatchDisplacements displaced = scene_.displaced[item - item_of_displaced(0)];
    displaced.epoch = begin_.epoch;
    displaced.serial = serial_;
    return displaced;
  }
  if (item >= item_of_weights(0)) return make_deformation(weight_parts_[item - item_of_weights(0)]);
  if (item < item_of_tile(0)) return to_message(scene_.cells[item - item_of_cell(0)], begin_.epoch, serial_);
  PatchTile tile = scene_.tiles[item - item_of_tile(0)];
  tile.epoch = begin_.epoch;
  tile.serial = serial_;
  return tile;
}

bool PatchSource::spend_credit(const Message& message, std::int64_t now_ns) noexcept {
  const double passed_s = 1e-9 * static_cast<double>(std::max<std::int64_t>(now_ns - credited_ns_, 0));
  credited_ns_ = now_ns;
  credit_bytes_ = std::min(kBurstBytes, credit_bytes_ + passed_s * options_.bits_per_s / 8.0);
  const double bytes = compute_bytes(message);
  if (credit_bytes_ < bytes) return false;
  credit_bytes_ -= bytes;
  counts_.bytes += static_cast<std::uint64_t>(bytes);
  return true;
}

std::optional<Message> PatchSource::take(std::int64_t now_ns) {
  // Parts wait while a move is due: smaller parts would take the bandwidth from the move until all of them were sent.
  if (MoveItem* const move = find_due_move(now_ns)) return take_move(*move, now_ns);
  if (now_ns - planned_ns_ >= kPlanEveryNs || planned_ns_ == 0) plan(now_ns);
  while (!planned_.empty() && !is_due(items_[planned_.back()], now_ns)) planned_.pop_back();
  if (planned_.empty()) return std::nullopt;
  ++serial_;
  const std::size_t item_index = planned_.back();
  Message message = make_message(item_index);
  if (!spend_credit(message, now_ns)) {
    --serial_;
    return std::nullopt;
  }
  planned_.pop_back();
  Item& item = items_[item_index];
  ++counts_.sent;
  counts_.repeated += item.serial != 0 ? 1 : 0;
  item = {State::sent, serial_, item.first_serial != 0 ? item.first_serial : serial_, now_ns};
  in_flight_[serial_ % kSerials] = static_cast<std::uint32_t>(item_index);
  return message;
}

namespace {

bool can_make(const MethodSettings& settings, const TouchScene& deforming) {
  const TouchObject& object = deforming.objects.front();
  if (!object.stream_reach_m) return DeformingMethod::make(settings, deforming).has_value();
  return StreamedMethod::make(settings, object.mesh, object.material, *object.stream_reach_m).has_value();
}

}  // namespace

bool can_feel_what_deforms(const TiledScene& scene, double probe_radius_m) {
  const auto deforms = [](const TileBody& body) { return body.deforms(); };
  if (std::none_of(scene.bodies.begin(), scene.bodies.end(), deforms)) return true;
  // Sends all parts, as over a link without delay, loss or limit.
  PatchSource source(scene, probe_radius_m, 0, 1, {.bits_per_s = 1e15, .least_reach_m = 1e6});
  PatchStore store;
  std::int64_t now_ns = kPlanEveryNs;
  for (bool has_accepted_any = true; has_accepted_any; now_ns += kPlanEveryNs) {
    has_accepted_any = false;
    while (auto part = source.take(now_ns += 1000)) has_accepted_any = store.accept_part(*part) || has_accepted_any;
    source.accept(store.status());
  }
  MethodSettings settings;
  settings.probe_radius_m = probe_radius_m;
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
    if (!deforms(scene.bodies[b])) continue;
    const PatchStore::Piece piece = store.make_piece(Vec3::Zero(), std::numeric_limits<double>::infinity(), 1, b);
    if (!piece.scene.has_deformation() || !can_make(settings, piece.scene)) return false;
  }
  return true;
}

}  // namespace hapton
