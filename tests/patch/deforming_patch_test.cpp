// Compares touch by patches of surfaces that deform with touch of the whole scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "core/force/deforming_method.h"
#include "patch/deforming_parts.h"
#include "tests/patch/chain_stage.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

// A displacement that is exact as a float, as messages carry it.
Vec3 rounded_to_floats(const Vec3& v) { return v.cast<float>().cast<double>(); }

template <class Displacement>
MorphTarget cushion_target(const TriangleMesh& mesh, Displacement&& displacement) {
  MorphTarget target;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const Vec3 by = rounded_to_floats(displacement(mesh.vertices[v]));
    if (by.isZero(0.0)) continue;
    target.vertices.push_back(v);
    target.displacements.push_back(by);
  }
  return target;
}

// A sheet of 40 mm that deforms in a loop: in one target its middle rises by 4 mm, in another the sheet leans to a side.
TouchObject cushion(double friction = 0.0) {
  TouchObject object{made::shared(made::sheet(0.02, 0.002, 24)),
                     {.stiffness_n_per_m = 800.0, .friction_static = friction, .friction_dynamic = 0.8 * friction}};
  const auto hump = [](const Vec3& p) {
    const double r = p.head<2>().norm() / 0.012;
    return r < 1.0 ? Vec3(0, 0, 0.004 * (1.0 - r * r) * (1.0 - r * r)) : Vec3(Vec3::Zero());
  };
  const auto lean = [](const Vec3& p) { return Vec3(0.05 * (p.z() + p.x()), 0.0, 0.06 * p.x()); };
  object.deformation = std::make_shared<const MeshDeformation>(
      std::vector{cushion_target(*object.mesh, hump), cushion_target(*object.mesh, lean)},
      std::vector<MorphKey>{{0.0, {0.0, 0.0}}, {0.1, {1.0, 0.0}}, {0.25, {0.5, 1.0}}, {0.4, {0.0, 0.0}}}, true);
  return object;
}

// A floor, and on it a cushion that deforms; `slides`: the cushion also moves by keyframes.
TouchScene cushion_on_floor(double friction = 0.0, bool slides = false) {
  TouchScene scene;
  scene.objects.push_back({made::shared(made::sheet(0.05, 0.0, 10)), cushion(friction).material});
  scene.objects.push_back(cushion(friction));
  if (slides) {
    scene.objects.back().motion = std::make_shared<const KeyframeMotion>(
        Vec3::Zero(),
        std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()},
                              {0.3, Vec3(0.006, 0, 0.001), Quat(Eigen::AngleAxisd(0.1, Vec3::UnitZ()))},
                              {0.7, Vec3::Zero(), Quat::Identity()}},
        true);
  }
  return on_patch_grid(scene);
}

// The hand presses in, moves to and fro, up and down, and now and then off the edge of the cushion.
Vec3 cushion_hand(double t_s) { return {0.03 * std::sin(2.1 * t_s), 0.009 * std::cos(1.3 * t_s), 0.0045 + 0.0055 * std::cos(5.0 * t_s)}; }

TEST(DeformingPatch, GivesTheForceOfTheHapticsNodesStepOnAnIdealLink) {
  for (const bool slides : {false, true}) {
    for (const double friction : {0.0, 0.5}) {
      ChainStage stage(cushion_on_floor(friction, slides));
      double worst_share = 0.0;  // of an error in the force
      int on_cushion = 0;
      int on_floor = 0;
      for (int n = 0; n < 8000; ++n) {
        const ChainStage::Outputs felt = stage.step(cushion_hand(stage.time_s()));
        ASSERT_TRUE(felt.patch.has_value()) << n;
        ASSERT_EQ(felt.patch->contact, felt.whole.contact) << n;
        ASSERT_EQ(felt.patch->object, felt.whole.object) << n;
        on_cushion += felt.whole.object == 1 ? 1 : 0;
        on_floor += felt.whole.object == 0 ? 1 : 0;
        worst_share = std::max(worst_share, (felt.patch->force_n - felt.whole.force_n).norm() / std::max(felt.whole.force_n.norm(), 1e-3));
      }
      EXPECT_LT(worst_share, friction == 0.0 ? 1e-9 : 0x1p-20) << friction << " " << slides;
      EXPECT_GT(on_cushion, 2000);
      EXPECT_GT(on_floor, 20);
    }
  }
}

// The largest difference to the force on the whole scene. The hand is pressed in, and delay_s after step `begin` the patches come.
double find_worst_error_n(double friction, int begin, double delay_s) {
  const TouchScene scene = cushion_on_floor(friction);
  ChainStage stage(scene);
  const auto whole = std::make_unique<TouchStep>(*make_method({}, scene), scene);
  const Vec3 resting_hand(0.003, 0.002, 0.003);
  TouchInput input{.p_WD = Vec3(0.003, 0.002, 0.01)};
  whole->reset(input);
  TouchOutput felt;
  for (int n = 0; n <= begin; ++n) {
    input.time_s = 1e-3 * n;
    input.p_WD = Vec3(0.003, 0.002, 0.01) + std::min(1.0, n / 100.0) * Vec3(0, 0, resting_hand.z() - 0.01);
    felt = whole->step(input);
  }
  EXPECT_TRUE(felt.contact);
  const double begin_s = 1e-3 * begin;
  stage.skip_to(begin_s);
  stage.chain().start_at(resting_hand + felt.visual_offset_m, felt.visual_offset_m.normalized(), 0.0, begin_s);
  double worst_n = 0.0;
  for (int n = 1; n <= 500; ++n) {
    const double time_s = begin_s + 1e-3 * n;
    const bool has_parts = 1e-3 * n > delay_s;
    const ChainStage::Outputs both = stage.step(resting_hand, Pose::Identity(), has_parts);
    input.time_s = time_s;
    felt = whole->step(input);
    if (!has_parts) continue;
    EXPECT_TRUE(both.patch.has_value()) << n;
    if (both.patch) worst_n = std::max(worst_n, (both.patch->force_n - felt.force_n).norm());
  }
  return worst_n;
}

// The parts of the cushion come while the hand presses on it. Where contact was, and when, is known from the replies of the haptics node.
// The cushion sinks at 0.3 s and rises at 0.45 s.
TEST(DeformingPatch, GoesOnFromWhereTheProxyWasWhenThePartsCome) {
  for (const double friction : {0.0, 0.3}) {
    for (const int begin : {300, 450}) {
      for (const double delay_s : {0.0, 0.02, 0.15}) {
        // The chain does not know what friction held before the parts came.
        EXPECT_LT(find_worst_error_n(friction, begin, delay_s), friction == 0.0 ? 1e-9 : 0.3) << friction << " " << begin << " " << delay_s;
      }
    }
  }
}

// The cushion has so many keys that they take several messages. The tiles of a body that programs move beside it come after its own.
TouchScene busy_cushion() {
  TouchScene scene = cushion_on_floor();
  std::vector<MorphKey> keys;
  for (int n = 0; n <= 100; ++n) keys.push_back({0.05 * n, {n % 2 == 0 ? 0.0 : 1.0, 0.01 * (n % 7)}});
  scene.objects[1].deformation = std::make_shared<const MeshDeformation>(scene.objects[1].deformation->targets(), std::move(keys), false);
  scene.objects.push_back({made::shared(made::box(Vec3(0.03, 0, 0.001), Vec3(0.04, 0.01, 0.01))), Material()});
  scene.objects.back().command_pivot = Vec3(0.035, 0.005, 0.005);
  return on_patch_grid(scene);
}

TEST(DeformingPatch, IsKnownOnlyWhenAllOfItIsThere) {
  std::vector<Message> parts = parts_of(make_tiles(busy_cushion()));
  std::mt19937_64 random(58);
  std::shuffle(parts.begin(), parts.end(), random);
  const auto is_of_cushion = [](const Message& part) {
    if (const auto* tile = std::get_if<PatchTile>(&part)) return tile->object == 1;
    return std::holds_alternative<PatchDeformation>(part) || std::holds_alternative<PatchDisplacements>(part);
  };
  const Vec3 above(0.0, 0.0, 0.02);
  PatchStore store;
  std::vector<Message> of_cushion;
  for (const Message& part : parts) {
    if (is_of_cushion(part)) {
      of_cushion.push_back(part);
    } else {
      (void)store.accept_part(part);
    }
  }
  ASSERT_GT(of_cushion.size(), 30U);
  ASSERT_GT(
      std::count_if(of_cushion.begin(), of_cushion.end(), [](const Message& m) { return std::holds_alternative<PatchDeformation>(m); }), 2);
  for (const Message& part : of_cushion) {
    // The radius ends at the highest shape that the cushion can have.
    const double known_m = store.known_radius(above, 1);
    EXPECT_GT(known_m, 0.0125);
    EXPECT_LT(known_m, 0.0142);
    EXPECT_TRUE(store.make_piece(above, 1.0, 100, 1).scene.objects.empty());
    for (int repeat = 0; repeat < 3; ++repeat) (void)store.accept_part(part);
  }
  EXPECT_TRUE(std::isinf(store.known_radius(above, 1)));
  (void)store.accept_part(PatchMaterial{.epoch = 1, .serial = 5000, .object = 1, .stiffness_n_per_m = 321.0});
  const PatchStore::Piece piece = store.make_piece(above, 1.0, 1, 1);
  ASSERT_EQ(piece.scene.objects.size(), 1U);
  const TouchObject& whole = piece.scene.objects.front();
  EXPECT_EQ(whole.mesh->triangles.size(), 2U * 24 * 24);
  EXPECT_EQ(whole.material.stiffness_n_per_m, 321.0);
  ASSERT_TRUE(whole.deformation);
  EXPECT_EQ(whole.deformation->keys().size(), 101U);
  EXPECT_EQ(store.counts().rejected, 0U);
  EXPECT_EQ(piece.objects, std::vector<int>{1});
}

TEST(DeformingPatch, IsKnownInWhateverOrderItsPartsCome) {
  expect_known_whichever_is_last<PatchBegin, PatchBody, PatchTile, PatchDeformation, PatchDisplacements>(make_tiles(busy_cushion()), 1);
}

TEST(DeformingPatch, SeveralObjectsThatDeformAreEachSentWhole) {
  TouchScene scene = cushion_on_floor();
  TouchObject other = cushion();
  TriangleMesh mesh = *other.mesh;
  for (Vec3& vertex : mesh.vertices) vertex += Vec3(0, 0, 0.02);
  other.mesh = made::shared(std::move(mesh));
  scene.objects.push_back(std::move(other));
  PatchStore store;
  for (const Message& part : parts_of(make_tiles(on_patch_grid(scene)))) (void)store.accept_part(part);
  for (const std::uint32_t body : {1U, 2U}) {
    const PatchStore::Piece piece = store.make_piece(Vec3::Zero(), 1.0, 1, body);
    ASSERT_TRUE(piece.scene.has_deformation()) << body;
    EXPECT_EQ(piece.objects, std::vector<int>{static_cast<int>(body)});
    const MeshDeformation& deformation = *piece.scene.objects.front().deformation;
    const MeshDeformation& own = *scene.objects[body].deformation;
    EXPECT_EQ(deformation.moved().size(), own.moved().size());
  }
}

// Each vertex of the joined mesh is always where the scene's vertex is that has the same position at rest.
TEST(DeformingPatch, HasTheShapesOfTheScene) {
  const TouchScene scene = cushion_on_floor();
  PatchStore store;
  for (const Message& part : parts_of(make_tiles(scene))) (void)store.accept_part(part);
  const PatchStore::Piece piece = store.make_piece(Vec3::Zero(), 1.0, 1, 1);
  ASSERT_EQ(piece.scene.objects.size(), 1U);
  const TouchObject& joined = piece.scene.objects.front();
  const TouchObject& scene_object = scene.objects[1];
  EXPECT_EQ(joined.deformation->keys(), scene_object.deformation->keys());
  for (const double time_s : {0.0, 0.07, 0.1, 0.2, 0.33, 1.21}) {
    const auto shape = joined.deformation->vertices_at(joined.mesh->vertices, joined.deformation->weights_at(time_s));
    const auto expected = scene_object.deformation->vertices_at(scene_object.mesh->vertices, scene_object.deformation->weights_at(time_s));
    for (std::size_t v = 0; v < joined.mesh->vertices.size(); ++v) {
      const auto at = std::find(scene_object.mesh->vertices.begin(), scene_object.mesh->vertices.end(), joined.mesh->vertices[v]);
      ASSERT_NE(at, scene_object.mesh->vertices.end());
      EXPECT_LT((shape[v] - expected[static_cast<std::size_t>(at - scene_object.mesh->vertices.begin())]).norm(), 1e-15);
    }
  }
}

TEST(DeformingPatch, WhatCannotBeFeltOrComesApartIsNoticed) {
  EXPECT_TRUE(can_feel_what_deforms(make_tiles(cushion_on_floor()), 0.0));
  EXPECT_FALSE(can_feel_what_deforms(make_tiles(cushion_on_floor()), 0.001)) << "a ball cannot feel what deforms";
  EXPECT_FALSE(make_tiles(cushion_on_floor()).comes_apart);

  // An inner edge of the sheet gets a third triangle.
  TouchScene unwalkable_scene = cushion_on_floor();
  TriangleMesh finned_sheet = *unwalkable_scene.objects[1].mesh;
  const Triangle inner = finned_sheet.triangles[24 * 24 + 24];
  finned_sheet.vertices.emplace_back(0.0, 0.0, 0.03);
  finned_sheet.triangles.push_back({inner[0], inner[1], static_cast<std::uint32_t>(finned_sheet.vertices.size() - 1)});
  unwalkable_scene.objects[1].mesh = made::shared(std::move(finned_sheet));
  EXPECT_FALSE(can_feel_what_deforms(make_tiles(unwalkable_scene), 0.0)) << "an edge of three triangles is not walkable";

  // Vertices at the same position that move alike count as one.
  TouchScene doubled_scene = cushion_on_floor();
  TriangleMesh seam_mesh = *doubled_scene.objects[1].mesh;
  const MeshDeformation& deformation = *doubled_scene.objects[1].deformation;
  std::vector<MorphTarget> targets = deformation.targets();
  const std::uint32_t moved_vertex = targets[0].vertices[0];
  seam_mesh.vertices.push_back(seam_mesh.vertices[moved_vertex]);
  for (MorphTarget& target : targets) {
    const auto at = std::find(target.vertices.begin(), target.vertices.end(), moved_vertex);
    if (at == target.vertices.end()) continue;
    target.displacements.push_back(target.displacements[static_cast<std::size_t>(at - target.vertices.begin())]);
    target.vertices.push_back(static_cast<std::uint32_t>(seam_mesh.vertices.size() - 1));
  }
  doubled_scene.objects[1].deformation =
      std::make_shared<const MeshDeformation>(std::move(targets), deformation.keys(), deformation.loops());
  doubled_scene.objects[1].mesh = made::shared(std::move(seam_mesh));
  EXPECT_FALSE(make_tiles(doubled_scene).comes_apart);

  // Two sheets that share an edge at rest only.
  TouchScene parting_scene;
  TriangleMesh two_sheets = made::sheet(0.01, 0.0, 2);
  const auto first = static_cast<std::uint32_t>(two_sheets.vertices.size());
  for (std::size_t v = 0; v < first; ++v) two_sheets.vertices.push_back(two_sheets.vertices[v] + Vec3(0.02, 0, 0));
  const std::size_t triangles = two_sheets.triangles.size();
  for (std::size_t t = 0; t < triangles; ++t) {
    two_sheets.triangles.push_back(
        {two_sheets.triangles[t][0] + first, two_sheets.triangles[t][1] + first, two_sheets.triangles[t][2] + first});
  }
  MorphTarget up;
  for (std::uint32_t v = first; v < two_sheets.vertices.size(); ++v) {
    up.vertices.push_back(v);
    up.displacements.emplace_back(0, 0, 0.01);
  }
  parting_scene.objects.push_back({made::shared(std::move(two_sheets)), Material()});
  parting_scene.objects.back().deformation =
      std::make_shared<const MeshDeformation>(std::vector{up}, std::vector<MorphKey>{{0.0, {0.0}}, {1.0, {1.0}}}, false);
  EXPECT_TRUE(make_tiles(parting_scene).comes_apart);
}

// A deformation that no scene can have is never felt.
TEST(DeformingPatch, ImpossibleDeformationsAreRejected) {
  const TiledScene tiled = make_tiles(cushion_on_floor());
  const auto is_felt = [&](auto&& change) {
    PatchStore store;
    for (Message part : parts_of(tiled)) {
      if (auto* deformation = std::get_if<PatchDeformation>(&part)) change(*deformation);
      (void)store.accept_part(part);
    }
    return store.make_piece(Vec3::Zero(), 1.0, 1, 1).scene.has_deformation();
  };
  EXPECT_TRUE(is_felt([](PatchDeformation&) {}));
  EXPECT_FALSE(is_felt([](PatchDeformation& m) {
    for (std::size_t n = 0; n < m.key_count; ++n) m.keys[3 * n] *= 0.1;
  })) << "ten times as fast";
  EXPECT_FALSE(is_felt([](PatchDeformation& m) { m.keys[1] = 0.1; })) << "the loop does not end where it begins";
  EXPECT_FALSE(is_felt([](PatchDeformation& m) {
    for (std::size_t n = 0; n < m.key_count; ++n) m.keys[3 * n + 1] += 3.0;
  })) << "beyond its bounds";
  EXPECT_FALSE(is_felt([](PatchDeformation& m) { ++m.displaced_count; })) << "one displacement is missing";
  EXPECT_FALSE(is_felt([](PatchDeformation& m) { m.tile_count = ~0U; }));
}

// Whether a body may deform like this: one vertex moves along z by the displacements of its targets, at the given weights. All numbers are
// exact as floats.
bool may_deform(const std::vector<float>& z_m, const std::vector<MorphKey>& keys) {
  PatchDeformation head{.tile_count = 1,
                        .displaced_count = static_cast<std::uint32_t>(z_m.size()),
                        .target_count = static_cast<std::uint32_t>(z_m.size()),
                        .all_keys = static_cast<std::uint32_t>(keys.size()),
                        .key_count = static_cast<std::uint32_t>(keys.size())};
  std::size_t number = 0;
  for (const MorphKey& key : keys) {
    head.keys[number++] = key.time_s;
    for (const double weight : key.weights) head.keys[number++] = weight;
  }
  DeformingParts parts;
  EXPECT_TRUE(parts.accept(head));
  std::vector<PatchDisplacements> displaced(z_m.size());
  std::vector<DeformingParts::DisplacedTile> tiles;
  const std::vector<std::uint32_t> vertices = {0};
  for (std::uint32_t j = 0; j < z_m.size(); ++j) {
    displaced[j].target = j;
    displaced[j].vertex_count = 1;
    displaced[j].displacements_m[2] = z_m[j];
    tiles.push_back({vertices, &displaced[j]});
  }
  return parts.make(tiles) != nullptr;
}

// The fastest motion that a scene may have, 0.25 m/s, is still accepted after its displacements were rounded to floats, and little more is.
TEST(DeformingPatch, TheFastestDeformationMayBeRounded) {
  const std::vector<MorphKey> one_way = {{0.0, {0.0}}, {0.5, {0.5}}};
  for (const int ulps : {0, 9}) EXPECT_TRUE(may_deform({0.25F + static_cast<float>(ulps) * 0x1p-25F}, one_way)) << ulps;
  EXPECT_FALSE(may_deform({0.25F + 10.0F * 0x1p-25F}, one_way)) << "faster by more than 1e-6, and the rounding of a float";
  // Two large displacements that nearly cancel out, each of which may be rounded.
  const auto far_to = [](float ulps) { return 64.25F + ulps * 0x1p-17F; };
  for (const auto& [z_m, key] : {std::pair(-64.0F, MorphKey{0.5, {0.5, 0.5}}), std::pair(64.0F, MorphKey{0.5, {0.5, -0.5}})}) {
    const std::vector<MorphKey> keys = {{0.0, {0.0, 0.0}}, key};
    for (const float ulps : {0.0F, 2.0F}) EXPECT_TRUE(may_deform({far_to(ulps), z_m}, keys)) << ulps;
    EXPECT_FALSE(may_deform({far_to(3.0F), z_m}, keys));
    // A part of the way that is too fast, after one that is not.
    const MorphKey then{0.75, {0.75 + key.weights[0] / 2.0, key.weights[1] * 2.0}};
    EXPECT_FALSE(may_deform({far_to(0.0F), z_m}, {keys[0], keys[1], then}));
  }
}

TEST(DeformingPatch, StepsUseNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  ChainStage stage(cushion_on_floor(0.4, true));
  for (int n = 0; n < 50; ++n) (void)stage.step(cushion_hand(stage.time_s()));
  PatchChain& chain = stage.chain();
  const double from_s = stage.time_s();
  const AllocationGuard guard;
  for (int n = 1; n <= 2000; ++n) {
    const double time_s = from_s + 1e-3 * n;
    (void)chain.step({.p_WD = cushion_hand(time_s), .dt_s = 1e-3, .time_s = time_s});
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
