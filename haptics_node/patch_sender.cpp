#include "haptics_node/patch_sender.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <tuple>
#include <utility>

#include "core/force/motion_groups.h"
#include "core/math/rigid_pose.h"
#include "link/commanded_move.h"
#include "patch/effect_codec.h"
#include "patch/patch_store.h"
#include "runtime/clock.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

constexpr std::int64_t kWantedNs = kNanosecondsPerSecond;  // parts count as wanted for this time after the last status that requests them
// The thread polls: waking it would be a system call in the loop that replies.
constexpr auto kIdleSenderPollPeriod = std::chrono::milliseconds(50);
constexpr auto kSenderPollPeriod = std::chrono::milliseconds(4);
// The scene time of this node is that of the hub's newest sample here. It is up to 50 ms old, as the hub sends 20 samples a second, plus
// half a round trip. A move takes another half. The rest is for jitter and, if the round trip is short, for sending the move again.
constexpr std::int64_t kLeadNs = 120 * kNanosecondsPerMillisecond;
constexpr double kLeadTrips = 1.25;
constexpr double kMaxLeadTripS = 2.0;  // a longer round trip counts as this
constexpr const char* kTooLarge = "the scene has more triangles than the hub keeps (about 500,000)";

const char* find_scene_obstacle(const TouchScene& scene) {
  if (scene.effects.size() > kMaxSpaceEffects) return "the scene has more than 256 effects in free space";
  if (scene.has_sculpt()) return "objects of the scene can be carved";
  std::size_t triangles = 0;
  for (const TouchObject& object : scene.objects) triangles += object.mesh->triangles.size();
  if (triangles > PatchStore::kMaxTiles * PatchTile::kMaxTriangles) return kTooLarge;
  if (!scene.has_motion()) return "";
  const std::vector<MotionGroup> groups = group_by_motion(scene);
  // The objects that stand still are one body as well, even if there are none.
  const auto moving = std::count_if(groups.begin(), groups.end(), [](const MotionGroup& group) { return group.moves(); });
  if (static_cast<std::size_t>(moving) >= PatchBody::kMaxBodies) return "more than 31 objects of the scene move";
  const auto has_many_weights = [](const TouchObject& object) {
    return object.deformation != nullptr && object.deformation->keys().size() > PatchDeformation::kMaxAllKeys;
  };
  if (std::any_of(scene.objects.begin(), scene.objects.end(), has_many_weights))
    return "an object of the scene has more than 4,096 keys of its shape";
  const auto is_long = [](const MotionGroup& group) {
    return group.motion != nullptr && group.motion->keyframes().size() > PatchBody::kMaxAllKeys;
  };
  return std::any_of(groups.begin(), groups.end(), is_long) ? "an object of the scene has more than 1,536 keyframes" : "";
}

// Why the parts cannot hold all of the scene; empty: they can.
const char* find_obstacle(const TiledScene& tiles, double probe_radius_m) {
  if (tiles.tiles.size() > PatchStore::kMaxTiles) return kTooLarge;
  if (tiles.has_unlisted_tiles) return "too many triangles of the scene overlap in one place";
  if (tiles.displaced.size() > PatchStore::kMaxDisplaced) return "the shapes of the objects that deform are more than the hub keeps";
  if (tiles.effects.size() > PatchEffects::kMaxAllBytes) return "images of effects of the scene are more than the hub keeps (2 MB)";
  if (!tiles.effects.empty() && !decode_effects(tiles.effects)) return "an effect of the scene has a number that the hub does not take";
  if (tiles.comes_apart) return "an object of the scene deforms and comes apart";
  return can_feel_what_deforms(tiles, probe_radius_m) ? "" : "an object that deforms cannot be felt from parts of the scene";
}

TiledScene make_no_tiles() {
  TiledScene none;
  none.grid = PatchGrid::around({Vec3::Constant(-1.0), Vec3::Constant(1.0)});
  return none;
}

std::vector<Material> materials_of(const TouchScene& scene) {
  std::vector<Material> materials;
  for (const TouchObject& object : scene.objects) materials.push_back(object.material);
  return materials;
}

}  // namespace

// Force shading needs smooth normals, which the parts do not have yet.
bool PatchSender::can_offer(std::string_view method_text) noexcept {
  method_text = method_text.substr(0, method_text.find('\0'));
  if (method_text.find(" effects=") != std::string_view::npos) return false;
  return method_text.find("name=proxy") != std::string_view::npos && method_text.find("shading=") == std::string_view::npos;
}

PatchSender::PatchSender(TouchScene scene, double probe_radius_m, std::uint64_t scene_hash, bool is_offered,
                         const PatchSource::Options& options)
    : scene_(std::move(scene)),
      scene_obstacle_(find_scene_obstacle(scene_)),
      probe_radius_m_(probe_radius_m),
      scene_hash_(scene_hash),
      options_(options),
      can_offer_method_(is_offered),
      thread_(start_thread([this] { run(); })) {}

PatchSender::~PatchSender() {
  stop_.store(true);
  thread_.join();
}

void PatchSender::accept(const PatchStatus& status, std::int64_t now_ns, std::uint64_t session) noexcept {
  wanted_until_ns_ = status.is_wanted ? now_ns + kWantedNs : 0;
  hub_session_ = session;
  hub_requests_parts_ = status.is_wanted;
  numbers_requests_ = status.request != 0;
  // If nothing was withdrawn or offered since the epoch without parts was made, no part was sent after it.
  const std::uint64_t empty = empty_epoch_.load(std::memory_order_acquire);
  const bool is_current = static_cast<std::uint32_t>(empty >> 32) == withdrawals_.load(std::memory_order_relaxed);
  if (is_current && status.epoch != 0 && status.epoch == static_cast<std::uint32_t>(empty)) has_sent_parts_ = false;
  round_trip_s_ = status.round_trip_s;
  shape_s_per_vertex_ = status.shape_s_per_vertex;
  statuses_.publish({status, now_ns});
}

void PatchSender::note_hand(const DeviceState& state, const std::array<float, 12>& X_WS, std::int64_t scene_time_ns) noexcept {
  hands_.publish({state.p_WD, state.sample_time_ns, X_WS, scene_time_ns});
}

void PatchSender::note_move(const ObjectMove& move, std::int64_t now_ns) noexcept {
  if (!sent_moves_.table.take(move)) return;
  const std::span<const ObjectMove> moves = sent_moves_.table.moves();
  for (std::size_t n = 0; n < moves.size(); ++n) {
    if (moves[n].object == move.object) sent_moves_.sent_ns[n] = now_ns;
  }
  moves_.publish(sent_moves_);
}

void PatchSender::note_shape(const ShapeStart& start) noexcept {
  auto& newest = sent_shapes_.newest;
  const auto is_it = [&](const SentShapes::One& one) { return one.object == start.object || one.object < 0; };
  const auto found = std::find_if(newest.begin(), newest.end(), is_it);
  if (found == newest.end()) return;
  *found = {start.object, start.serial};
  shapes_.publish(sent_shapes_);
}

void PatchSender::set_withdrawn(bool is_withdrawn, std::uint32_t method_serial) noexcept {
  const std::uint32_t withdrawals = withdrawals_.load(std::memory_order_relaxed);
  if (is_withdrawn == (withdrawals % 2 == 1)) return;
  if (!is_withdrawn) method_serial_.store(method_serial, std::memory_order_relaxed);
  withdrawals_.store(withdrawals + 1, std::memory_order_release);
}

const Message* PatchSender::front() noexcept {
  const std::uint32_t withdrawals = withdrawals_.load(std::memory_order_relaxed);
  std::size_t begin = begin_.load(std::memory_order_relaxed);
  const std::size_t end = end_.load(std::memory_order_acquire);
  while (begin != end && ring_[begin % kRingSlots].withdrawals != withdrawals) ++begin;
  begin_.store(begin, std::memory_order_release);
  return begin == end ? nullptr : &ring_[begin % kRingSlots].message;
}

std::int64_t PatchSender::find_lead_ns(std::int64_t now_ns) const noexcept {
  if (!is_wanted(now_ns) || !is_offered() || is_withdrawn(hub_session_)) return 0;
  return kLeadNs + static_cast<std::int64_t>(kLeadTrips * static_cast<double>(round_trip_ns()));
}

std::int64_t PatchSender::round_trip_ns() const noexcept {
  const double round_trip_s = std::min(static_cast<double>(round_trip_s_.load(std::memory_order_relaxed)), kMaxLeadTripS);
  return static_cast<std::int64_t>(1e9 * round_trip_s);
}

void PatchSender::run() {
  const SteadyClock clock;
  std::int64_t wanted_until_ns = 0;
  while (!stop_.load()) {
    const std::int64_t now_ns = clock.now_ns();
    const bool has_status = statuses_.take();
    if (has_status) {
      const auto& [status, time_ns] = statuses_.value();
      wanted_until_ns = status.is_wanted ? time_ns + kWantedNs : 0;
      wants_parts_ = status.is_wanted;
      request_ = status.request;
      hub_knows_effects_ = status.knows_effects;
      if (source_) source_->accept(status);
    }
    // Read after the status: what was withdrawn before the hub requested parts stays withdrawn. Read before the scene: if parts are offered
    // again, this thread sees the scene that was set before.
    const std::uint32_t withdrawals = withdrawals_.load(std::memory_order_acquire);
    follow_scene();
    follow_moves();
    if (shapes_.take()) follow_shapes();
    const bool is_busy = now_ns < wanted_until_ns || must_withdraw(withdrawals);
    if (is_busy) {
      follow_method(withdrawals);
      if (hands_.take()) follow_hand(hands_.value());
      // The time now: making parts took time.
      if (fill(clock.now_ns(), withdrawals) || has_status) counts_.publish(source_->counts());
    }
    std::this_thread::sleep_for(is_busy ? kSenderPollPeriod : kIdleSenderPollPeriod);
  }
}

// Parts are withdrawn even if no status has arrived for long: the hub may still have them.
bool PatchSender::must_withdraw(std::uint32_t withdrawals) const noexcept {
  return withdrawals % 2 == 1 && wants_parts_ && source_ && (source_withdrawals_ != withdrawals || source_->counts().held == 0);
}

// Materials that were set for the scene before do not apply to this one.
void PatchSender::set_scene(TouchScene scene, std::uint64_t scene_hash, std::uint32_t revision) {
  const std::scoped_lock lock(scene_mutex_);
  scene_obstacle_.store(find_scene_obstacle(scene), std::memory_order_release);
  next_scene_.emplace(std::move(scene), scene_hash);
  next_materials_.clear();
  revision_.store(revision, std::memory_order_release);
}

void PatchSender::set_materials(const std::vector<Material>& materials) {
  const std::scoped_lock lock(scene_mutex_);
  next_materials_ = materials;
}

// Takes both at once: freeing the old scene takes time, in which another scene may be set, with materials of its own.
void PatchSender::follow_scene() {
  std::optional<std::pair<TouchScene, std::uint64_t>> next;
  std::vector<Material> materials;
  {
    const std::scoped_lock lock(scene_mutex_);
    next.swap(next_scene_);
    materials.swap(next_materials_);
  }
  if (next) {
    std::tie(scene_, scene_hash_) = std::move(*next);
    source_.reset();
    tiles_.reset();
    hand_motions_.clear();
    commanded_motions_.clear();
  }
  if (!materials.empty()) follow_materials(materials);
}

// A tile has the material that its object had when it was made; changed materials are sent separately.
void PatchSender::follow_materials(const std::vector<Material>& materials) {
  for (std::size_t o = 0; o < std::min(materials.size(), scene_.objects.size()); ++o) {
    scene_.objects[o].material = with_numbers_of(scene_.objects[o].material, materials[o]);
  }
  if (source_) source_->set_materials(materials_of(scene_));
}

void PatchSender::follow_moves() {
  if (!moves_.take()) return;
  const auto& [table, sent_ns] = moves_.value();
  const std::span<const ObjectMove> moves = table.moves();
  for (std::size_t n = 0; source_ && n < moves.size(); ++n) source_->note_move(moves[n], sent_ns[n]);
  begin_moves();
}

void PatchSender::follow_shapes() {
  for (const SentShapes::One& one : shapes_.value().newest) {
    if (source_ && one.object >= 0) source_->note_shape(one.object, one.serial);
  }
}

// Begins the known moves of the bodies of the present parts.
void PatchSender::begin_moves() {
  for (const ObjectMove& move : moves_.value().table.moves()) {
    for (std::size_t b = 1; tiles_ && b < commanded_motions_.size(); ++b) {
      const MotionGroup& group = tiles_->bodies[b].group;
      if (group.commanded >= 0 && group.objects.front() == move.object) commanded_motions_[b].begin(to_command(move));
    }
  }
}

Pose PatchSender::pose_of(std::size_t body, double time_s) const noexcept {
  const MotionGroup& group = tiles_->bodies[body].group;
  if (group.commanded >= 0) return commanded_motions_[body].pose_at(time_s);
  return group.motion != nullptr ? group.motion->pose_at(time_s) : Pose(Pose::Identity());
}

// False: the parts cannot hold all of the scene.
bool PatchSender::make_parts() {
  auto tiles = std::make_unique<TiledScene>(make_tiles(scene_));
  if (const char* const why = find_obstacle(*tiles, probe_radius_m_); *why != '\0') {
    const std::scoped_lock lock(scene_mutex_);
    if (!next_scene_) scene_obstacle_.store(why, std::memory_order_release);
    return false;
  }
  tiles_ = std::move(tiles);
  hand_motions_.assign(tiles_->bodies.size(), HandMotion());
  commanded_motions_.clear();
  for (const TileBody& body : tiles_->bodies) commanded_motions_.emplace_back(body.pivot_m);
  last_hand_ns_ = 0;
  begin_moves();
  const std::string effects =
      tiles_->effects.empty() ? "" : fmt::format(", {:.3g} kB of effects", 1e-3 * static_cast<double>(tiles_->effects.size()));
  log_info("the hub requests the scene in parts: {} tiles in {} cells{}, at most {:g} Mbit/s", tiles_->tiles.size(), tiles_->cells.size(),
           effects, 1e-6 * options_.bits_per_s);
  return true;
}

// If the method cannot be computed from parts, and while parts are withdrawn, the hub gets an epoch without parts.
void PatchSender::follow_method(std::uint32_t withdrawals) {
  bool offers = withdrawals % 2 == 0 && is_offered() && (tiles_ || make_parts());
  if (offers && !tiles_->effects.empty() && !hub_knows_effects_) {
    offers = false;
    if (!std::exchange(has_warned_of_effects_, true))
      log_warning("io_node is of an earlier version, which cannot compute effects itself: the force stays remote; update io_node");
  }
  if (source_ && offers == was_offered_ && source_withdrawals_ == withdrawals && source_request_ == request_) return;
  was_offered_ = offers;
  source_withdrawals_ = withdrawals;
  source_request_ = request_;
  source_ = std::make_unique<PatchSource>(offers ? *tiles_ : make_no_tiles(), probe_radius_m_, scene_hash_, ++epoch_, options_);
  source_->reply_to(request_, method_serial_.load(std::memory_order_relaxed));
  if (withdrawals % 2 == 1) empty_epoch_.store((std::uint64_t{withdrawals} << 32) | epoch_, std::memory_order_release);
  source_->set_materials(materials_of(scene_));
  for (const ObjectMove& move : moves_.value().table.moves()) source_->note_move(move, -1);
  follow_shapes();
}

void PatchSender::follow_hand(const Hand& hand) {
  const auto X_WS = find_rigid_pose(hand.X_WS);
  if (!X_WS) return;
  const Vec3 p_SD = X_WS->inverse(Eigen::Isometry) * hand.p_WD;
  const double dt_s = 1e-9 * static_cast<double>(hand.time_ns - std::exchange(last_hand_ns_, hand.time_ns));
  for (std::size_t body = 0; body < hand_motions_.size(); ++body) {
    HandMotion& motion = hand_motions_[body];
    const Vec3 p_OD = pose_of(body, 1e-9 * static_cast<double>(hand.scene_time_ns)).inverse(Eigen::Isometry) * p_SD;
    motion.follow(p_OD, dt_s);
    source_->aim(motion, body);
  }
}

bool PatchSender::fill(std::int64_t now_ns, std::uint32_t withdrawals) {
  const std::size_t first = end_.load(std::memory_order_relaxed);
  std::size_t end = first;
  while (end - begin_.load(std::memory_order_acquire) < kRingSlots) {
    auto part = source_->take(now_ns);
    if (!part) break;
    ring_[end % kRingSlots] = {*part, withdrawals, was_offered_};
    end_.store(++end, std::memory_order_release);
  }
  return end != first;
}

}  // namespace hapton
