// Compares the effects of a scene on patches of it with those on the whole scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "patch/effect_parts.h"
#include "patch/felt_effects.h"
#include "tests/core/force/made_effects.h"
#include "tests/core/force/made_maps.h"
#include "tests/patch/chain_stage.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr double kFloorStiffness = 800.0;
constexpr double kNanCoordinate = std::numeric_limits<double>::quiet_NaN();

// How the block moves.
enum class BlockMotion : std::uint8_t { still, keyframed, commanded, deforming };

// A block with these effects, on a floor without any. The steps on the floor show whether the effects end at the block's edge.
TouchScene block_on_floor(const NamedEffects& effects, BlockMotion block_motion, double friction = 0.0) {
  const Material material{.stiffness_n_per_m = kFloorStiffness, .friction_static = friction, .friction_dynamic = 0.8 * friction};
  TouchScene scene;
  scene.objects.push_back({made::shared(made::sheet(0.06, -0.002, 12)), material});
  TouchObject block{made::shared(made::box({-0.02, -0.02, -0.01}, {0.02, 0.02, 0.0})), material};
  block.effects = effects.make(*block.mesh);
  if (block_motion == BlockMotion::keyframed) {
    block.motion = std::make_shared<const KeyframeMotion>(
        Vec3::Zero(),
        std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()},
                              {0.5, Vec3(0.004, 0.002, 0.001), Quat(Eigen::AngleAxisd(0.15, Vec3(1, 2, 5).normalized()))},
                              {1.0, Vec3::Zero(), Quat::Identity()}},
        true);
  }
  if (block_motion == BlockMotion::commanded) block.command_pivot = Vec3::Zero();
  if (block_motion == BlockMotion::deforming) {
    MorphTarget lean;
    for (std::uint32_t v = 0; v < block.mesh->vertices.size(); ++v) {
      const Vec3& p = block.mesh->vertices[v];
      lean.vertices.push_back(v);
      lean.displacements.emplace_back(Vec3(0.1 * p.x(), 0.0, 0.05 * p.y()).cast<float>().cast<double>());
    }
    block.deformation =
        std::make_shared<const MeshDeformation>(std::vector{lean}, std::vector<MorphKey>{{0.0, {0.0}}, {0.3, {1.0}}, {0.6, {0.0}}}, true);
  }
  scene.objects.push_back(block);
  return on_patch_grid(scene);
}

// Taps the block, slides over it with changing depth, leaves it by less than the range of a snap and comes back. If reach_m is more than
// the block's 20 mm, the hand goes down beside the block as well.
Vec3 hand_on_block(double t_s, double reach_m = 0.024) {
  return {reach_m * std::sin(2.3 * t_s), 0.012 * std::cos(3.1 * t_s), 0.004 * std::cos(17.0 * t_s) - 0.0028};
}

struct Difference {
  double worst_error_n = 0.0;
  double largest_force_n = 0.0;
  int block_contacts = 0;  // steps
};

Difference compare_block(const TouchScene& scene, int steps, double reach_m = 0.024, const Pose& X_WS = Pose::Identity()) {
  ChainStage stage(scene);
  stage.begin_together();
  Difference difference;
  for (int n = 0; n < steps; ++n) {
    const ChainStage::Outputs felt = stage.step(X_WS * hand_on_block(stage.time_s(), reach_m), X_WS);
    EXPECT_TRUE(felt.patch.has_value()) << n;
    if (!felt.patch) return difference;
    EXPECT_EQ(felt.patch->contact, felt.whole.contact) << n;
    difference.worst_error_n = std::max(difference.worst_error_n, (felt.patch->force_n - felt.whole.force_n).norm());
    difference.worst_error_n =
        std::max(difference.worst_error_n, kFloorStiffness * (felt.patch->visual_offset_m - felt.whole.visual_offset_m).norm());
    difference.largest_force_n = std::max(difference.largest_force_n, felt.whole.force_n.norm());
    difference.block_contacts += felt.whole.object == 1 ? 1 : 0;
  }
  return difference;
}

// Messages round images and their triangles. All else is rounded only where bodies share the proxy (CommonProxy), and where two triangles
// that deform meet.
double tolerance_n(const NamedEffects& effects, const Difference& difference) {
  return (std::string(effects.name).ends_with("map") ? 1e-4 : 1e-6) * difference.largest_force_n;
}

struct EffectPatch : testing::TestWithParam<BlockMotion> {};

TEST_P(EffectPatch, FeelsEachSurfaceEffectAsTheHapticsNodeDoes) {
  for (const NamedEffects& effects : all_effects()) {
    for (const double friction : {0.0, 0.4}) {
      SCOPED_TRACE(std::string(effects.name) + " " + std::to_string(friction));
      const Difference difference = compare_block(block_on_floor(effects, GetParam(), friction), 3000, friction > 0.0 ? 0.015 : 0.024);
      EXPECT_LT(difference.worst_error_n, tolerance_n(effects, difference));
      EXPECT_GT(difference.largest_force_n, 0.5);
      EXPECT_GT(difference.block_contacts, 500);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Blocks, EffectPatch,
                         testing::Values(BlockMotion::still, BlockMotion::keyframed, BlockMotion::commanded, BlockMotion::deforming));

TEST(EffectPatches, IsFeltAlikeInATurnedView) {
  Pose X_WS = Pose::Identity();
  X_WS.linear() = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  X_WS.translation() = Vec3(0.1, -0.2, 0.05);
  for (const NamedEffects& effects : all_effects()) {
    const Difference difference = compare_block(block_on_floor(effects, BlockMotion::keyframed), 1500, 0.024, X_WS);
    EXPECT_LT(difference.worst_error_n, tolerance_n(effects, difference)) << effects.name;
  }
}

std::vector<SwitchedEffect> all_space_effects() {
  const EffectVolume ball = EffectVolume::ball({0.005, 0, 0}, 0.015);
  return {SpringEffect{.centre = {0.01, 0, 0.01}},
          ConstantEffect{.force_n = {0.1, 0.2, -0.3}, .volume = ball},
          SnapEffect{.target = SnapEffect::Target::line, .position = {0, 0, 0.001}, .direction = {1, 0, 0}},
          GravityWellEffect{.centre = {-0.01, 0.01, 0.0}},
          ViscousEffect{.volume = EffectVolume::box({-0.02, -0.02, -0.01}, {0.0, 0.02, 0.01})},
          WaveEffect{.waveform = Waveform::triangle, .frequency_hz = 13.0},
          BurstEffect{.volume = ball},
          MassEffect{.mass_kg = 0.04},
          SwitchedEffect(ConstantEffect{.force_n = {0, 0, 0.5}}, EffectSwitch{.button = 1})};
}

TEST(EffectPatches, FeelsEachEffectInFreeSpaceAsTheHapticsNodeDoes) {
  for (const SwitchedEffect& effect : all_space_effects()) {
    TouchScene scene = block_on_floor({"none", [](const TriangleMesh&) { return SurfaceEffects(); }}, BlockMotion::still);
    scene.effects = {effect};
    const Difference difference = compare_block(scene, 2000);
    EXPECT_LT(difference.worst_error_n, 1e-8 * difference.largest_force_n) << effect.effect.index();
    EXPECT_GT(difference.largest_force_n, 0.5) << effect.effect.index();
  }
}

TEST(EffectPatches, ActsWhileAButtonIsDown) {
  TouchScene scene = block_on_floor({"none", [](const TriangleMesh&) { return SurfaceEffects(); }}, BlockMotion::still);
  scene.effects = {all_space_effects().back()};
  ChainStage stage(scene);
  const Vec3 p_WD(0, 0, 0.01);
  for (int n = 0; n < 100; ++n) (void)stage.step(p_WD);
  // Longer than the ramp of an effect that is switched.
  const auto hold = [&](std::uint32_t buttons) {
    const TouchInput held{.p_WD = p_WD, .dt_s = 1e-3, .buttons = buttons, .time_s = 0.1};
    for (int n = 0; n < 30; ++n) (void)stage.chain().step(held);
    return stage.chain().step(held);
  };
  const auto expect_nothing_felt = [&](std::uint32_t buttons) {
    const auto output = hold(buttons);
    ASSERT_TRUE(output.has_value());
    EXPECT_EQ(output->force_n, Vec3::Zero());
    EXPECT_FALSE(output->contact);
  };
  for (const std::uint32_t other : {0U, 2U}) expect_nothing_felt(other);
  const auto felt = hold(1);
  ASSERT_TRUE(felt.has_value());
  EXPECT_NEAR(felt->force_n.z(), 0.5, 1e-12);
  EXPECT_TRUE(felt->contact);
  EXPECT_EQ(felt->visual_offset_m, Vec3::Zero());
  expect_nothing_felt(0);
}

class OneBody final : public BodyPlaces {
 public:
  Pose pose(std::size_t) const noexcept override { return Pose::Identity(); }
  std::optional<SurfacePlace> place(std::size_t, int) const noexcept override { return std::nullopt; }
  double stiffness(std::size_t, int) const noexcept override { return kFloorStiffness; }
};

// The output of a patch for a floor at z = 0, which is object 2.
std::optional<PatchOutput> on_floor(double z, bool is_beyond) {
  if (z >= 0.0) return PatchOutput{.is_beyond = is_beyond};
  return PatchOutput{.force_n = {0, 0, -kFloorStiffness * z},
                     .visual_offset_m = {0, 0, -z},
                     .contact = true,
                     .is_beyond = is_beyond,
                     .object = is_beyond ? -1 : 2};
}

// A needle in the second layer: past the edge of a patch the plane holds it as the surface did, and punctured layers stay punctured.
TEST(EffectPatches, GoesOnPastTheEdgeOfAPatch) {
  SceneEffectSet effects;
  effects.surfaces.resize(3);
  effects.surfaces[2] = skin_and_flesh();
  effects.body_of.resize(3, 0);
  FeltEffects felt(effects);
  const auto press = [&](double z, bool is_beyond) {
    std::optional<PatchOutput> output = on_floor(z, is_beyond);
    felt.add({.p_WD = {0, 0, z}, .dt_s = 1e-3}, OneBody(), output);
    return *output;
  };
  for (int n = 0; n <= 800; ++n) (void)press(0.002 - 1e-5 * n, false);
  for (int n = 0; n < 10; ++n) (void)press(-0.006, false);
  const double held_n = 800.0 * (0.006 - 0.004);
  const PatchOutput held_output = press(-0.006, false);
  EXPECT_NEAR(held_output.force_n.z(), held_n, 1e-9);
  EXPECT_NEAR(held_output.visual_offset_m.z(), 0.002, 1e-12) << "drawn on the layer";
  ASSERT_TRUE(held_output.held_offset_m.has_value());
  EXPECT_EQ(held_output.held_offset_m->z(), 0.006);
  EXPECT_NEAR(press(-0.006, true).force_n.z(), held_n, 1e-9);
  EXPECT_NEAR(press(-0.006, false).force_n.z(), held_n, 1e-9) << "another patch";
  (void)press(0.001, true);
  EXPECT_NEAR(press(-0.001, true).force_n.z(), kFloorStiffness * 0.001, 1e-9)
      << "a new contact past the edge: it is unknown with which surface";
}

// A fast push into a damped surface: its force is ten times that of its spring, but the spring of friction is no stiffer.
TEST(EffectPatches, FrictionOfAnImageIsNoStifferThanTheMaterial) {
  SceneEffectSet effects;
  effects.surfaces.resize(3);
  SurfaceMaps& maps = effects.surfaces[2].maps = made_maps(made::sheet(0.1, 0.0, 4));
  maps.friction = {.image = maps.height.image, .at_black = 2.0, .at_white = 2.0};
  maps.height = {};
  effects.body_of.resize(3, 0);
  FeltEffects felt(effects);
  const auto push = [&](double x) {
    std::optional<PatchOutput> output = on_floor(-1e-4, false);
    output->force_n *= 10.0;
    felt.add({.p_WD = {x, 0.004, -1e-4}, .dt_s = 1e-3}, OneBody(), output);
    return output->force_n;
  };
  (void)push(0.003);
  EXPECT_NEAR(push(0.00301).x(), -1e-5 * kFloorStiffness, 1e-9);
}

// forget() acts as if the hand had been away: layers are whole again, and the time of effects starts again.
TEST(EffectPatches, ForgetsContactAndTime) {
  SceneEffectSet effects;
  effects.surfaces.resize(3);
  effects.surfaces[2] = skin_and_flesh();
  effects.body_of.resize(3, 0);
  effects.space = {WaveEffect{.direction = {1, 0, 0}, .amplitude_n = 1.0, .frequency_hz = 7.0}};
  FeltEffects felt(effects);
  const auto feel_all = [&] {
    std::vector<Vec3> forces_n;
    for (int n = 0; n <= 700; ++n) {
      std::optional<PatchOutput> output = on_floor(0.001 - 1e-5 * n, false);
      felt.add({.p_WD = {0, 0, 0.001 - 1e-5 * n}, .dt_s = 1e-3}, OneBody(), output);
      forces_n.push_back(output->force_n);
    }
    return forces_n;
  };
  const std::vector<Vec3> first = feel_all();
  felt.forget();
  EXPECT_EQ(feel_all(), first);
}

// The scene comes again while the hand moves: a damper in free space continues with the speed of the hand.
TEST(EffectPatches, BodiesThatReplaceOthersGoOnWithTheSpeedOfTheHand) {
  TouchScene scene = block_on_floor({"none", [](const TriangleMesh&) { return SurfaceEffects(); }}, BlockMotion::still);
  scene.effects = {ViscousEffect{.damping_ns_per_m = 5.0, .volume = EffectVolume::everywhere()}};
  ChainStage stage(scene);
  int n = 0;
  const auto step = [&] { return stage.step(Vec3(0, 0, 0.01 + 1e-5 * ++n)); };
  for (; n < 30;) (void)step();
  const auto before = step();
  ASSERT_TRUE(before.patch.has_value());
  EXPECT_NEAR(before.patch->force_n.z(), -5.0 * 0.01, 1e-9);
  (void)stage.chain().take(stage.store().make_bodies(0));
  const auto after = step();
  ASSERT_TRUE(after.patch.has_value());
  EXPECT_NEAR(after.patch->force_n.z(), -5.0 * 0.01, 1e-9);
}

// A hostile haptics node may send thousands of surfaces with one list of triangles.
TEST(EffectPatches, SurfacesWithTheSameTrianglesPrepareThemOnce) {
  constexpr std::size_t kSurfaces = 100;
  const SurfaceEffects mapped_block = with_map(made::box({-0.02, -0.02, -0.01}, {0.02, 0.02, 0.0}), &SurfaceMaps::stiffness, 0.2, 1.0);
  SceneEffectSet effects;
  effects.surfaces.resize(kSurfaces, mapped_block);
  effects.body_of.resize(kSurfaces, 0);
  const long before = mapped_block.maps.triangles.use_count();
  const FeltEffects felt(effects);
  EXPECT_EQ(mapped_block.maps.triangles.use_count() - before, 2 * static_cast<long>(kSurfaces) + 1)
      << "an owner for each surface and each finder, and one for the prepared list";
}

// If the patches give no output, it is unknown what they would give: then effects add no force and no contact.
TEST(EffectPatches, AddsNothingToNoForce) {
  SceneEffectSet effects;
  effects.space = {ConstantEffect{.force_n = {1, 0, 0}}};
  FeltEffects felt(effects);
  std::optional<PatchOutput> none;
  felt.add({.p_WD = {0, 0, 1}}, OneBody(), none);
  EXPECT_FALSE(none.has_value());
  std::optional<PatchOutput> free = PatchOutput();
  felt.add({.p_WD = {0, 0, 1}}, OneBody(), free);
  EXPECT_EQ(free->force_n, Vec3(1, 0, 0));
  free = PatchOutput();
  felt.add({.p_WD = {0, 0, kNanCoordinate}}, OneBody(), free);
  EXPECT_EQ(free->force_n, Vec3::Zero());
}

TEST(EffectPatches, NothingIsFeltBeforeAllPartsHaveCome) {
  TouchScene scene = block_on_floor(all_effects().back(), BlockMotion::keyframed);
  scene.effects = all_space_effects();
  const std::vector<Message> parts = parts_of(make_tiles(scene));
  const auto is_effects = [](const Message& part) { return std::holds_alternative<PatchEffects>(part); };
  ASSERT_GT(std::count_if(parts.begin(), parts.end(), is_effects), 3);
  std::vector<Message> last_first(parts.rbegin(), parts.rend());
  std::stable_partition(last_first.begin(), last_first.end(), [&](const Message& part) { return !is_effects(part); });
  PatchStore store;
  for (const Message& part : last_first) {
    EXPECT_FALSE(store.has_bodies());
    (void)store.accept_part(part);
  }
  ASSERT_TRUE(store.has_bodies());
  EXPECT_NE(store.make_bodies(0)->effects, nullptr);
  EXPECT_EQ(store.counts().rejected, 0U);
  (void)store.accept_part(PatchBegin{.epoch = 2, .serial = 1, .step_m = 1e-8});
  EXPECT_TRUE(store.has_bodies()) << "a scene without any";
  EXPECT_EQ(store.make_bodies(0)->effects, nullptr);
}

// Bytes that are not effects are never confirmed.
TEST(EffectPatches, WhatNoSceneMayHaveIsDropped) {
  TouchScene scene = block_on_floor(all_effects().front(), BlockMotion::still);
  scene.effects = {SpringEffect{.max_force_n = 101.0}};
  PatchStore store;
  for (const Message& part : parts_of(make_tiles(scene))) (void)store.accept_part(part);
  EXPECT_FALSE(store.has_bodies());
  EXPECT_GT(store.counts().rejected, 0U);

  PatchStore other;
  (void)other.accept_part(PatchBegin{.epoch = 1, .serial = 1, .step_m = 1e-8, .effect_bytes = 2});
  (void)other.accept_part(PatchEffects{.epoch = 1, .serial = 2, .part = 0, .byte_count = 3});
  EXPECT_FALSE(other.has_bodies()) << "more bytes than announced";
  (void)other.accept_part(PatchEffects{.epoch = 1, .serial = 3, .part = 2000, .byte_count = 960});
  EXPECT_FALSE(other.has_bodies());
  EXPECT_EQ(other.status().newest_serial, 3U) << "what may still become whole is kept";
}

TEST(EffectPatches, JoinsPartsInAnyOrderToTheSameBytes) {
  std::string bytes(3 * PatchEffects::kMaxBytes + 5, 'x');
  for (std::size_t n = 0; n < bytes.size(); ++n) bytes[n] = static_cast<char>(n * 7);
  ASSERT_EQ(count_effect_parts(bytes.size()), 4U);
  EXPECT_EQ(count_effect_parts(3 * PatchEffects::kMaxBytes), 3U);
  EXPECT_EQ(count_effect_parts(0), 0U);
  EffectParts parts;
  for (const std::uint32_t part : {3U, 0U, 2U, 0U, 1U}) {
    EXPECT_FALSE(parts.is_whole(bytes.size()));
    EXPECT_TRUE(parts.take(make_effect_part(bytes, part)));
  }
  ASSERT_TRUE(parts.is_whole(bytes.size()));
  EXPECT_EQ(parts.join(), bytes);
  PatchEffects other = make_effect_part(bytes, 1);
  other.bytes[3] ^= 1;
  EXPECT_FALSE(parts.take(other)) << "another part of that number";
}

TEST(EffectPatches, AStepUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  TouchScene scene = block_on_floor(all_effects().back(), BlockMotion::deforming);
  scene.objects[0].effects = SurfaceEffects{.texture = {.models = made::texture(1000.0, 20, 18)}};
  scene.effects = all_space_effects();
  ChainStage stage(scene);
  for (int n = 0; n < 200; ++n) (void)stage.step(hand_on_block(stage.time_s()));
  const AllocationGuard guard;
  for (int n = 0; n < 400; ++n) {
    const double time_s = 0.2 + 1e-3 * n;
    (void)stage.chain().step({.p_WD = hand_on_block(time_s), .dt_s = 1e-3, .time_s = time_s});
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
