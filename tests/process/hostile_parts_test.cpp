// A hostile haptics node: it has the right key, and sends parts that no scene has to an io_node that computes the force from parts.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "patch/effect_codec.h"
#include "patch/effect_parts.h"
#include "tests/process/system.h"
#include "tests/process/watched_force.h"

namespace hapton::process {
namespace {

class HostileHaptics {
 public:
  explicit HostileHaptics(const System& system)
      : hub_(*parse_address(system.hub())), sealed_(*endpoint_, clock_, RoleKey(system.key(), KeyRole::haptics), hub_) {}

  // Joins the hub and receives a state; false: none came.
  bool join() {
    const std::int64_t end_ns = clock_.now_ns() + static_cast<std::int64_t>(1e9 * kPatience.count());
    while (!has_state_ && clock_.now_ns() < end_ns) listen(20 * kNanosecondsPerMillisecond);
    return has_state_;
  }
  void listen(std::int64_t for_ns) {
    Datagram datagram;
    for (const std::int64_t end_ns = clock_.now_ns() + for_ns; client_.receive(datagram, end_ns);) {
      if (const auto* state = std::get_if<DeviceState>(&datagram.message)) {
        state_ = *state;
        has_state_ = true;
      }
      if (clock_.now_ns() >= end_ns) return;
    }
  }
  void send(const Message& message) { client_.send(message); }
  const DeviceState& state() const { return state_; }

 private:
  SteadyClock clock_;
  Address hub_;
  std::unique_ptr<Endpoint> endpoint_ = *open_udp_endpoint("127.0.0.1:0");
  SealedClient sealed_;
  HubClient client_{sealed_, clock_, NodeRole::haptics, hub_};
  DeviceState state_;
  bool has_state_ = false;
};

// Parts that the codec lets through, with each number from the whole range that the codec permits.
class RandomParts {
 public:
  explicit RandomParts(unsigned seed) : random_(seed) {}

  void begin_epoch() {
    ++epoch_;
    serial_ = 0;
  }
  Message begin() {
    PatchBegin begin{.epoch = epoch_, .serial = ++serial_, .scene_hash = 7};
    begin.origin_m = Vec3(random_number(), random_number(), random_number());
    begin.step_m = std::abs(random_number()) + 1e-300;
    begin.probe_radius_m = one_in(2) ? 0.0 : std::abs(random_number());
    begin.body_count = one_in(2) ? 1U : static_cast<std::uint32_t>(1 + random_() % 3);
    effects_ = one_in(2) ? draw_effects() : std::string();
    begin.effect_bytes = static_cast<std::uint32_t>(effects_.size());
    return begin;
  }
  // Sends all effects of the epoch; if it has none, some that were not announced.
  void send_effects(HostileHaptics& hostile) {
    const std::string& bytes = effects_.empty() ? kNotAnnounced : effects_;
    for (std::uint32_t part = 0; part < count_effect_parts(bytes.size()); ++part) {
      PatchEffects effects = make_effect_part(bytes, part);
      effects.epoch = epoch_;
      effects.serial = ++serial_;
      hostile.send(effects);
    }
  }
  // Sends the whole of a small scene around the hand: as many triangles through one another as one cell can hold.
  void send_tangle(HostileHaptics& hostile, const Vec3& p_WD) {
    begin_epoch();
    const double width_m = 0.1;
    const double step_m = std::ldexp(width_m, -kPatchGridBits);
    hostile.send(PatchBegin{.epoch = epoch_, .serial = ++serial_, .origin_m = p_WD - Vec3::Constant(0.5 * width_m), .step_m = step_m});
    PatchCell cell{.epoch = epoch_, .serial = ++serial_};
    cell.tile_count = PatchCell::kMaxTiles;
    for (std::uint32_t n = 0; n < cell.tile_count; ++n) cell.tiles[n] = n;
    hostile.send(cell);
    for (std::uint32_t n = 0; n < cell.tile_count; ++n) {
      PatchTile tile = std::get<PatchTile>(this->tile());
      tile.tile = n;
      tile.stiffness_n_per_m = 1e5;
      tile.triangle_count = PatchTile::kMaxTriangles;
      hostile.send(tile);
      if (n % 16 == 0) hostile.listen(5 * kNanosecondsPerMillisecond);
    }
  }
  Message cell() {
    PatchCell cell{.epoch = epoch_, .serial = ++serial_};
    cell.level = one_in(3) ? 0U : static_cast<std::uint32_t>(random_() % (kPatchDeepestLevel + 1));
    for (auto& index : cell.index) index = static_cast<std::uint32_t>(random_() % (std::uint64_t{1} << cell.level));
    cell.body = static_cast<std::uint32_t>(one_in(2) ? 0 : random_() % 3);
    for (std::uint32_t n = 0; n < cell.level; ++n) cell.empty_children[n] = static_cast<std::uint8_t>(random_());
    cell.tile_count = PatchCell::kMaxTiles;
    for (auto& tile : cell.tiles) tile = static_cast<std::uint32_t>(one_in(20) ? random_() : random_() % 600);
    return cell;
  }
  Message tile() {
    PatchTile tile{.epoch = epoch_, .serial = ++serial_};
    tile.tile = static_cast<std::uint32_t>(one_in(50) ? random_() : random_() % 600);
    tile.object = static_cast<std::uint32_t>(one_in(5) ? random_() : random_() % 3);
    tile.stiffness_n_per_m = std::abs(random_number());
    tile.damping_ns_per_m = one_in(2) ? 0.0 : std::abs(random_number());
    tile.friction_static = one_in(2) ? 0.0 : std::abs(random_number());
    tile.friction_dynamic = tile.friction_static * 0.5;
    tile.two_sided = one_in(2);
    tile.vertex_count = static_cast<std::uint8_t>(1 + random_() % PatchTile::kMaxVertices);
    tile.triangle_count = static_cast<std::uint8_t>(1 + random_() % PatchTile::kMaxTriangles);
    for (auto& byte : tile.vertices) byte = static_cast<std::uint8_t>(one_in(4) ? 0 : random_());
    for (auto& corner : tile.triangles) corner = static_cast<std::uint8_t>(random_() % tile.vertex_count);
    return tile;
  }
  // A body of a scene that moves; nine of ten have a motion that no scene may have.
  Message body() {
    PatchBody body{.epoch = epoch_, .serial = ++serial_, .body = static_cast<std::uint32_t>(random_() % PatchBody::kMaxBodies)};
    body.motion = static_cast<PatchBody::Motion>(random_() % 3);
    body.deforms = one_in(3);
    if (one_in(2)) {
      body.lowest = {0, 0, 0};
      for (auto& most : body.highest) most = static_cast<std::uint32_t>(random_() >> (64 - kPatchGridBits));
    }
    body.radius_m = std::min(std::abs(random_number()), kMaxTranslationM);
    body.object = static_cast<std::int32_t>(random_() % 3);
    body.move_serial = one_in(2) ? 0U : static_cast<std::uint32_t>(random_());
    if (body.motion != PatchBody::Motion::still) body.pivot_m = random_position();
    if (body.motion != PatchBody::Motion::keyframes) return body;
    body.loops = one_in(3);
    body.key_count = static_cast<std::uint32_t>(1 + random_() % PatchBody::kMaxKeys);
    body.first_key = one_in(4) ? static_cast<std::uint32_t>(random_() % 100) : 0U;
    body.all_keys = std::max(2U, body.first_key + body.key_count);
    double time_s = 0.0;
    for (std::size_t n = 0; n < body.key_count; ++n)
      body.keys[n] = {time_s += 1e-3 + std::min(std::abs(random_number()), 1e6), random_position(), random_rotation()};
    return body;
  }
  // A deformation of few tiles, so that some deformations become complete.
  Message deformation() {
    PatchDeformation deformation{.epoch = epoch_, .serial = ++serial_, .body = static_cast<std::uint32_t>(random_() % 4)};
    deformation.first_tile = static_cast<std::uint32_t>(one_in(20) ? random_() : random_() % 600);
    deformation.tile_count = static_cast<std::uint32_t>(one_in(10) ? random_() | 1U : 1 + random_() % 3);
    deformation.displaced_count = static_cast<std::uint32_t>(one_in(10) ? random_() : random_() % 3);
    deformation.target_count = static_cast<std::uint32_t>(1 + random_() % PatchDeformation::kMaxTargets);
    deformation.loops = one_in(3);
    const std::size_t numbers_per_key = PatchDeformation::numbers_of_key(deformation.target_count);
    deformation.key_count = static_cast<std::uint32_t>(1 + random_() % (PatchDeformation::kMaxNumbers / numbers_per_key));
    deformation.first_key = one_in(4) ? static_cast<std::uint32_t>(random_() % 100) : 0U;
    deformation.all_keys = deformation.first_key + deformation.key_count;
    double time_s = 0.0;
    for (std::size_t i = 0; i < deformation.key_count * numbers_per_key; ++i) {
      deformation.keys[i] =
          i % numbers_per_key == 0 ? time_s += 1e-3 + std::min(std::abs(random_number()), 1e6) : std::clamp(random_number(), -1e6, 1e6);
    }
    return deformation;
  }
  Message displacements() {
    PatchDisplacements displacements{.epoch = epoch_, .serial = ++serial_};
    displacements.tile = static_cast<std::uint32_t>(one_in(50) ? random_() : random_() % 600);
    displacements.target = static_cast<std::uint32_t>(random_() % PatchDeformation::kMaxTargets);
    displacements.vertex_count = static_cast<std::uint8_t>(1 + random_() % PatchTile::kMaxVertices);
    for (float& by_m : displacements.displacements_m) by_m = static_cast<float>(std::clamp(random_number(), -1e6, 1e6));
    return displacements;
  }
  // A part of an object that programs deform, of few tiles, as in deformation(). For three in four of them, one shape() message has a whole
  // shape.
  Message stream() {
    PatchStream stream{.epoch = epoch_, .serial = ++serial_, .body = static_cast<std::uint32_t>(random_() % 4)};
    stream.first_tile = static_cast<std::uint32_t>(one_in(20) ? random_() >> 33 : random_() % 600);
    stream.tile_count = static_cast<std::uint32_t>(1 + random_() % 3);
    stream.object = static_cast<std::int32_t>(random_() % 3);
    stream.total = static_cast<std::uint32_t>(one_in(4) ? ShapePart::kMaxVertices : 64);
    stream.reach_m = std::clamp(std::abs(random_number()), 1e-6, 1e6);
    for (int n = 0; n < 9; ++n) stream.to_scene(n / 3, n % 3) = std::clamp(random_number(), -1e6, 1e6);
    stream.shape_serial = one_in(2) ? 0U : shapes_;
    stream.tile = stream.first_tile + static_cast<std::uint32_t>(random_() % stream.tile_count);
    stream.vertex_count = static_cast<std::uint8_t>(1 + random_() % PatchTile::kMaxVertices);
    for (auto& vertex : stream.vertices) vertex = static_cast<std::uint32_t>(random_() % stream.total);
    return stream;
  }
  Message shape() {
    ObjectShape shape{.source = 9, .serial = ++shapes_, .object = static_cast<std::int32_t>(random_() % 3), .part = {.total = 64}};
    for (auto& by_m : shape.part.displacements_m) {
      for (float& k : by_m) k = static_cast<float>(std::clamp(random_number(), -100.0, 100.0));
    }
    return shape;
  }
  Message shape_start() {
    ShapeStart start{.source = one_in(50) ? 8U : 9U, .serial = std::max(1U, shapes_), .object = static_cast<std::int32_t>(random_() % 3)};
    start.total = 64;
    start.before = start.serial - 1;
    start.start_ns = static_cast<std::int64_t>(random_() >> (2 + random_() % 40));
    start.end_ns = start.start_ns + static_cast<std::int64_t>(random_() >> (3 + random_() % 40));
    return start;
  }
  Message move() {
    ObjectMove move{.source = one_in(50) ? 8U : 7U, .serial = ++moves_, .object = static_cast<std::int32_t>(random_() % 3)};
    move.start_ns = static_cast<std::int64_t>(random_() >> (1 + random_() % 40));
    move.end_ns = move.start_ns + static_cast<std::int64_t>(random_() >> (2 + random_() % 40));
    if (move.end_ns < move.start_ns) move.end_ns = move.start_ns;
    move.from_p_m = random_position();
    move.from_q = random_rotation();
    move.to_p_m = random_position();
    move.to_q = random_rotation();
    return move;
  }
  Message material() {
    PatchMaterial material{
        .epoch = epoch_, .serial = ++serial_, .object = static_cast<std::uint32_t>(one_in(5) ? random_() : random_() % 3)};
    material.stiffness_n_per_m = std::min(std::abs(random_number()), 1e9);
    material.friction_static = one_in(2) ? 0.0 : std::min(std::abs(random_number()), 1e9);
    return material;
  }
  Message force(const DeviceState& state) {
    ForceCommand force{.echo_sample = state.sample, .echo_sample_time_ns = state.sample_time_ns};
    force.force_n = Vec3(random_number(), random_number(), random_number());
    force.visual_offset_m = Vec3(random_number(), random_number(), random_number());
    force.contact = one_in(2);
    force.object = static_cast<std::int32_t>(random_());
    return force;
  }
  bool one_in(unsigned n) { return random_() % n == 0; }

 private:
  // Effects at the ends of the range of scene files; in one of four results, a byte is changed.
  std::string draw_effects() {
    SceneEffectSet effects;
    const double extreme = one_in(2) ? 1e9 : 1e-300;
    effects.space = {SpringEffect{.centre = random_position(), .stiffness_n_per_m = extreme, .max_force_n = 100.0},
                     WaveEffect{.waveform = Waveform::square, .amplitude_n = 100.0, .frequency_hz = extreme},
                     MassEffect{.mass_kg = extreme, .max_force_n = 100.0}};
    SurfaceEffects surface;
    surface.progressive.n_per_m2 = extreme;
    surface.snap = {.stiffness_n_per_m = 100.0 / 0.01, .range_m = 0.01};
    surface.tap = {.ns_per_m = extreme, .frequency_hz = extreme, .decay_s = 1e-300, .max_force_n = 100.0};
    surface.viscosity.damping_ns_per_m = extreme;
    if (one_in(2)) surface.layers.add({.depth_m = 1e-9, .stiffness_n_per_m = extreme, .drag_ns_per_m = 1e9});
    effects.surfaces.assign(3, surface);
    effects.body_of = {0, 1, 2};
    std::string bytes = encode_effects(effects);
    if (one_in(4)) bytes[random_() % bytes.size()] = static_cast<char>(random_());
    return bytes;
  }
  Vec3 random_position() {
    const auto number = [this] { return std::clamp(random_number(), -kMaxTranslationM, kMaxTranslationM); };
    return {number(), number(), number()};
  }
  Quat random_rotation() { return one_in(2) ? Quat::Identity() : Quat(0.6, 0.0, one_in(9) ? 0.8 + 5e-4 : 0.8, 0.0); }
  double random_number() {
    constexpr double kValues[] = {0.0, 1e-300, 1e-12, 1e-9, 1e-6, 1e-3, 0.05, 1.0, 1e3, 1e9, 1e30, 1e300};
    const double value = kValues[random_() % std::size(kValues)] * std::uniform_real_distribution(0.5, 1.5)(random_);
    return one_in(2) ? value : -value;
  }

  std::mt19937_64 random_;
  std::uint32_t epoch_ = 0;
  std::uint32_t serial_ = 0;
  std::uint32_t moves_ = 0;
  std::uint32_t shapes_ = 0;
  inline static const std::string kNotAnnounced = std::string(2000, 'x');
  std::string effects_;  // of this epoch
};

TEST(Hostile, PartsOfTheSceneLeaveTheForceBoundedAndTheNextHapticsNodeServed) {
  System system(tight_limits("patch"));
  system.start("io_node");
  const auto first = 1 + static_cast<unsigned>(::testing::UnitTest::GetInstance()->random_seed());  // --gtest_random_seed
  for (unsigned seed = first; seed < first + 3; ++seed) {
    HostileHaptics hostile(system);
    ASSERT_TRUE(hostile.join());
    SessionObserver observer(system);
    RandomParts parts(seed);
    for (int round = 0; round < 40; ++round) {
      if (round % 4 == 0) {
        parts.begin_epoch();
        hostile.send(parts.begin());
        parts.send_effects(hostile);
      }
      if (round % 20 == 18) {
        parts.send_tangle(hostile, hostile.state().p_WD);
        EXPECT_GT(expect_within_limits(observer, 0.3).states, 0);
      }
      for (int n = 0; n < 60; ++n) hostile.send(parts.one_in(5) ? parts.cell() : parts.tile());
      for (int n = 0; n < 6; ++n) hostile.send(parts.body());
      for (int n = 0; n < 20; ++n) hostile.send(parts.one_in(4) ? parts.deformation() : parts.displacements());
      for (int n = 0; n < 8; ++n) hostile.send(parts.stream());
      for (int n = 0; n < 4; ++n) hostile.send(parts.one_in(2) ? parts.shape() : parts.shape_start());
      for (int n = 0; n < 3; ++n) hostile.send(parts.move());
      hostile.send(parts.material());
      hostile.send(parts.force(hostile.state()));
      hostile.listen(5 * kNanosecondsPerMillisecond);
      ASSERT_TRUE(system["io_node"].is_running()) << "seed " << seed << "\n" << system["io_node"].err();
      if (round % 10 == 9) {
        EXPECT_GT(expect_within_limits(observer, 0.1).states, 0);
      }
    }
  }
  const Json report = system.request_report();
  ASSERT_TRUE(report.is_object());
  EXPECT_GT(count(report, "patch_parts"), 1000) << "io_node accepted them";
  std::printf("%ld parts, %ld patches built, %ld steps on them\n", count(report, "patch_parts"), count(report, "patches_built"),
              count(report, "local_forces"));
  system.start("haptics_node");
  SessionObserver observer(system);
  ProbeState state;
  EXPECT_TRUE(feels_patches(system));
  EXPECT_TRUE(observer.wait_for_force(state));
  expect_within_limits(observer, 0.5);
  system.end_all();
}

}  // namespace
}  // namespace hapton::process
