#include "haptics_node/patch_sender.h"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include "patch/patch_store.h"
#include "runtime/clock.h"
#include "tests/haptics_node/sender_with_hub.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_scene.h"

namespace hapton {
namespace {

std::uint32_t epoch_of(const Message& part) {
  if (const auto* begin = std::get_if<PatchBegin>(&part)) return begin->epoch;
  if (const auto* cell = std::get_if<PatchCell>(&part)) return cell->epoch;
  return std::get<PatchTile>(part).epoch;
}

TEST(PatchSender, SendsNothingBeforeTheHubWantsIt) {
  SenderWithHub setup;
  setup.sender.note_hand({}, kIdentityPose);
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  EXPECT_EQ(setup.sender.front(), nullptr);
  EXPECT_FALSE(setup.sender.is_wanted(setup.clock.now_ns()));
}

TEST(PatchSender, SendsTheWholeSceneAndThenNothingMore) {
  SenderWithHub setup;
  ASSERT_TRUE(setup.receive_until([&] { return setup.is_whole(); }));
  EXPECT_EQ(setup.store.begin().scene_hash, 7U);
  EXPECT_EQ(setup.store.make_piece(Vec3::Zero(), 1.0, 100'000).triangles, 800U);
  // Parts that arrived are confirmed, so that after a while none is sent again.
  int before = -1;
  EXPECT_TRUE(setup.receive_until([&] {
    setup.receive_for(std::chrono::milliseconds(300));
    return std::exchange(before, setup.received_count) == setup.received_count;
  }));
  const PatchSource::Counts counts = setup.sender.counts();
  EXPECT_EQ(counts.held, counts.sent - counts.repeated);
}

TEST(PatchSender, StopsWhenTheHubDoesNotWantItAnyMore) {
  SenderWithHub setup;
  setup.request_parts();
  EXPECT_TRUE(setup.sender.is_wanted(setup.clock.now_ns()));
  setup.sender.accept({}, setup.clock.now_ns());
  EXPECT_FALSE(setup.sender.is_wanted(setup.clock.now_ns()));
}

TEST(PatchSender, AMethodThatPartsDoNotServeGetsAnEpochWithoutAny) {
  SenderWithHub setup;
  ASSERT_TRUE(setup.receive_until([&] { return setup.is_whole(); }));
  const std::uint32_t epoch = setup.store.status().epoch;
  setup.sender.set_offered(false);
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.status().epoch == epoch + 1; }));
  setup.receive_for(std::chrono::milliseconds(200));
  EXPECT_EQ(setup.store.make_piece(Vec3::Zero(), 1.0, 100'000).triangles, 0U);
  setup.sender.set_offered(true);
  EXPECT_TRUE(setup.receive_until([&] { return setup.store.status().epoch == epoch + 2 && setup.is_whole(); }));
}

// A scene is read again: the hub gets the parts of the new scene, with its own materials, and no part of the scene before.
TEST(PatchSender, AnotherSceneIsOfferedAsAnEpochOfItsOwn) {
  SenderWithHub setup;
  ASSERT_TRUE(setup.receive_until([&] { return setup.is_whole(); }));
  const std::uint32_t epoch = setup.store.status().epoch;
  setup.sender.set_materials({{.stiffness_n_per_m = 321.0}});
  TouchScene other = scene_of(made::sheet(0.05, 0.0, 10));
  other.objects[0].material.stiffness_n_per_m = 654.0;
  setup.sender.set_scene(other, 8);
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.status().epoch == epoch + 1 && setup.is_whole(); }));
  EXPECT_EQ(setup.store.begin().scene_hash, 8U);
  const PatchStore::Piece piece = setup.store.make_piece(Vec3::Zero(), 1.0, 100'000);
  EXPECT_EQ(piece.triangles, 200U);
  EXPECT_EQ(piece.scene.objects.at(0).material.stiffness_n_per_m, 654.0);
}

// The scene changes to one that parts cannot represent, and back. The method may be taken over before or after the change.
TEST(PatchSender, AnotherSceneIsOfferedWherePartsCanRepresentIt) {
  SenderWithHub setup;
  ASSERT_TRUE(setup.receive_until([&] { return setup.is_whole(); }));
  const std::uint32_t epoch = setup.store.status().epoch;
  TouchScene carved = scene_of(made::sheet(0.05, 0.0, 20));
  carved.objects[0].sculpt.emplace();
  setup.sender.set_offered(true);
  setup.sender.set_scene(carved, 8);
  EXPECT_FALSE(setup.sender.is_offered());
  EXPECT_EQ(setup.sender.obstacle(), "objects of the scene can be carved");
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.status().epoch == epoch + 1; }));
  setup.receive_for(std::chrono::milliseconds(200));
  EXPECT_EQ(setup.store.make_piece(Vec3::Zero(), 1.0, 100'000).triangles, 0U);
  setup.sender.set_scene(scene_of(made::sheet(0.05, 0.0, 10)), 9);
  setup.sender.set_offered(true);
  EXPECT_TRUE(setup.sender.is_offered());
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.status().epoch == epoch + 2 && setup.is_whole(); }));
  EXPECT_EQ(setup.store.make_piece(Vec3::Zero(), 1.0, 100'000).triangles, 200U);
}

// The hub keeps the parts that it has: none of them is sent again.
TEST(PatchSender, OtherMaterialsComeBesideTheParts) {
  SenderWithHub setup;
  ASSERT_TRUE(setup.receive_until([&] { return setup.is_whole(); }));
  const std::uint32_t epoch = setup.store.status().epoch;
  const std::uint64_t sent = setup.sender.counts().sent;
  const auto received_material = [&] { return setup.store.make_piece(Vec3::Zero(), 1.0, 100'000).scene.objects.at(0).material; };
  setup.sender.set_materials({{.stiffness_n_per_m = 321.0, .friction_static = 0.3}});
  ASSERT_TRUE(setup.receive_until([&] { return received_material().stiffness_n_per_m == 321.0; }));
  EXPECT_EQ(received_material().friction_static, 0.3);
  EXPECT_EQ(setup.store.status().epoch, epoch);
  setup.receive_for(std::chrono::milliseconds(300));
  EXPECT_LE(setup.sender.counts().sent, sent + 2);
  // A new epoch has these materials, too, although its tiles are the same as before.
  setup.sender.set_offered(false);
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.status().epoch == epoch + 1; }));
  setup.sender.set_offered(true);
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.status().epoch == epoch + 2 && setup.is_whole(); }));
  EXPECT_TRUE(setup.receive_until([&] { return received_material().stiffness_n_per_m == 321.0; }));
}

// Freeing a large scene takes so long that meanwhile the next scene comes, and a change of its material.
TEST(PatchSender, WhileASceneIsFreedTheNextOneComesWithItsMaterials) {
  std::function<void()> meanwhile;
  const auto free = [&](const TriangleMesh* mesh) {
    meanwhile();
    delete mesh;
  };
  TouchScene first;
  first.objects.push_back({std::shared_ptr<const TriangleMesh>(new TriangleMesh(made::sheet(0.05, 0.0, 20)), free), {}});
  SenderWithHub setup(true, std::move(first));
  meanwhile = [&] {
    setup.sender.set_scene(scene_of(made::sheet(0.05, 0.0, 10)), 9);
    setup.sender.set_materials({{.stiffness_n_per_m = 321.0}});
  };
  setup.sender.set_scene(scene_of(made::sheet(0.05, 0.0, 20)), 8);
  ASSERT_TRUE(setup.receive_until([&] { return setup.is_whole() && setup.store.begin().scene_hash == 9U; }));
  EXPECT_TRUE(setup.receive_until(
      [&] { return setup.store.make_piece(Vec3::Zero(), 1.0, 100'000).scene.objects.at(0).material.stiffness_n_per_m == 321.0; }));
}

// A hub that does not know effects would compute other forces.
TEST(PatchSender, ASceneWithEffectsIsForHubsThatKnowThem) {
  TouchScene scene = scene_of(made::sheet(0.05, 0.0, 20));
  scene.objects[0].effects.viscosity.damping_ns_per_m = 1.0;
  scene.effects = {ConstantEffect{.force_n = {0, 0, 1}}};
  SenderWithHub setup(true, scene);
  setup.knows_effects = false;
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.has_begun(); }));
  setup.receive_for(std::chrono::milliseconds(200));
  EXPECT_EQ(setup.triangles(), 0U);
  EXPECT_EQ(setup.store.begin().effect_bytes, 0U);
  setup.knows_effects = true;
  setup.request += 2;
  ASSERT_TRUE(setup.receive_until([&] { return setup.is_whole() && setup.store.has_bodies(); }));
  EXPECT_EQ(setup.triangles(), 800U);
  EXPECT_NE(setup.store.make_bodies(0)->effects, nullptr);
}

// An image of more than a million texels.
TEST(PatchSender, ASceneWithMoreEffectsThanTheHubKeepsIsNotOffered) {
  TouchScene scene = scene_of(made::sheet(0.05, 0.0, 2));
  SurfaceMaps& maps = scene.objects[0].effects.maps;
  maps.triangles = std::make_shared<const std::vector<MappedTriangle>>(1);
  maps.height.image = std::make_shared<const SurfaceImage>(1100, 1000, std::vector<float>(1'100'000, 0.5F));
  maps.height.at_black = -1e-3;
  SenderWithHub setup(true, scene);
  ASSERT_TRUE(setup.receive_until([&] { return !setup.sender.obstacle().empty(); }));
  EXPECT_EQ(setup.sender.obstacle(), "images of effects of the scene are more than the hub keeps (2 MB)");

  TouchScene many = scene_of(made::sheet(0.05, 0.0, 2));
  many.effects.resize(257, ConstantEffect());
  EXPECT_EQ(SenderWithHub(true, many).sender.obstacle(), "the scene has more than 256 effects in free space");
}

// Otherwise the hub would wait for effects that it has rejected, and no message would say why the force stays remote.
TEST(PatchSender, ASceneWithAnEffectThatTheHubRejectsIsNotOffered) {
  TouchScene scene = scene_of(made::sheet(0.05, 0.0, 2));
  SurfaceMaps& maps = scene.objects[0].effects.maps;
  std::vector<MappedTriangle> triangles(1);
  triangles[0].texcoord[0].x() = 2e6;
  maps.triangles = std::make_shared<const std::vector<MappedTriangle>>(std::move(triangles));
  maps.height.image = std::make_shared<const SurfaceImage>(2, 2, std::vector<float>(4, 0.5F));
  maps.height.at_black = -1e-3;
  SenderWithHub setup(true, scene);
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.has_begun(); }));
  EXPECT_EQ(setup.sender.obstacle(), "an effect of the scene has a number that the hub does not take");
  EXPECT_EQ(setup.store.begin().effect_bytes, 0U);
}

// The hub would keep only some parts of it, and would treat the rest as unknown.
TEST(PatchSender, ASceneThatTheHubCannotKeepIsNeverOffered) {
  SenderWithHub setup(true, scene_of(made::sheet(0.05, 0.0, 520)));
  EXPECT_FALSE(setup.sender.is_offered());
  EXPECT_EQ(setup.sender.obstacle(), "the scene has more triangles than the hub keeps (about 500,000)");
}

// Large triangles cross each other everywhere: one place has too many of them for the datagram of a part.
TEST(PatchSender, ASceneWithTooManyTrianglesInOnePlaceIsNotOffered) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> place(-0.05, 0.05);
  TriangleMesh mesh;
  for (std::uint32_t n = 0; n < 20'000; ++n) {
    for (int corner = 0; corner < 3; ++corner) mesh.vertices.emplace_back(place(random), place(random), place(random));
    mesh.triangles.push_back({3 * n, 3 * n + 1, 3 * n + 2});
  }
  SenderWithHub setup(true, scene_of(std::move(mesh)));
  EXPECT_TRUE(setup.sender.is_offered()) << "not known before the scene is divided into parts";
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.has_begun(); }));
  EXPECT_FALSE(setup.sender.is_offered());
  EXPECT_EQ(setup.sender.obstacle(), "too many triangles of the scene overlap in one place");
  setup.receive_for(std::chrono::milliseconds(200));
  EXPECT_EQ(setup.store.counts().parts, 1U) << "only the message that begins the epoch";
  setup.sender.set_scene(scene_of(made::sheet(0.05, 0.0, 10)), 8);
  EXPECT_TRUE(setup.receive_until([&] { return setup.is_whole(); }));
}

std::shared_ptr<const KeyframeMotion> slow_motion(std::size_t keys = 2) {
  std::vector<Keyframe> keyframes;
  for (std::size_t n = 0; n < keys; ++n)
    keyframes.push_back({0.1 * static_cast<double>(n), Vec3(0, 0, 1e-3 * static_cast<double>(n % 7)), {}});
  for (Keyframe& each : keyframes) each.turn = Quat::Identity();
  return std::make_shared<const KeyframeMotion>(Vec3::Zero(), std::move(keyframes), false);
}

std::shared_ptr<const MeshDeformation> slow_deformation(std::size_t keys) {
  std::vector<MorphKey> weights;
  for (std::size_t n = 0; n < keys; ++n) weights.push_back({0.1 * static_cast<double>(n), {0.1 * static_cast<double>(n % 2)}});
  const MorphTarget target{.vertices = {0, 1}, .displacements = {Vec3(0, 0, 0.002), Vec3(0, 0.001, 0)}};
  return std::make_shared<const MeshDeformation>(std::vector{target}, std::move(weights), false);
}

// Each body is announced before it can be felt, with all its keyframes.
TEST(PatchSender, ASceneThatMovesIsOfferedWithItsBodies) {
  TouchScene scene = scene_of(made::sheet(0.05, 0.0, 20));
  scene.objects.push_back({made::shared(made::box(Vec3(0, 0, 0.01), Vec3(0.01, 0.01, 0.02))), {}});
  scene.objects[1].motion = slow_motion(100);
  scene.objects.push_back({made::shared(made::box(Vec3(0.02, 0, 0.01), Vec3(0.03, 0.01, 0.02))), {}});
  scene.objects[2].command_pivot = Vec3(0.025, 0.005, 0.01);
  SenderWithHub setup(true, scene);
  EXPECT_TRUE(setup.sender.is_offered());
  EXPECT_EQ(setup.sender.obstacle(), "");
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.has_bodies(); }));
  const auto bodies = setup.store.make_bodies(3);
  ASSERT_EQ(bodies->bodies.size(), 3U);
  EXPECT_EQ(bodies->generation, 3U);
  ASSERT_TRUE(bodies->bodies[1].keyframes);
  EXPECT_EQ(*bodies->bodies[1].keyframes, *scene.objects[1].motion) << "to the last bit";
  EXPECT_TRUE(bodies->bodies[2].is_commanded);
  EXPECT_EQ(bodies->bodies[2].object, 2);
  for (const std::uint32_t body : {0U, 1U, 2U}) {
    EXPECT_TRUE(setup.receive_until([&] { return std::isinf(setup.store.known_radius(Vec3::Zero(), body)); })) << body;
  }
  EXPECT_EQ(setup.store.make_piece(Vec3::Zero(), 1.0, 100'000, 1).triangles, 12U);
}

TEST(PatchSender, KnowsHowLongTheHubTakesForAShape) {
  SenderWithHub setup(true);
  EXPECT_EQ(setup.sender.shape_ns_per_vertex(), 0);
  PatchStatus status;
  for (const auto& [reported_s, expected_ns] : {std::pair(2.5e-5F, 25'000), std::pair(1e9F, 1'000'000), std::pair(0.0F, 0)}) {
    status.shape_s_per_vertex = reported_s;
    setup.sender.accept(status, setup.clock.now_ns());
    EXPECT_NEAR(static_cast<double>(setup.sender.shape_ns_per_vertex()), expected_ns, 1.0);
  }
}

// The caller sends a move at once; the sender sends it again until the hub confirms it.
TEST(PatchSender, AMoveIsSentAgainUntilTheHubConfirmsIt) {
  TouchScene scene = scene_of(made::sheet(0.05, 0.0, 20));
  scene.objects[0].command_pivot = Vec3::Zero();
  SenderWithHub setup(true, scene);
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.has_bodies(); }));
  EXPECT_EQ(setup.sender.find_lead_ns(setup.clock.now_ns()), 120'000'000);
  EXPECT_TRUE(setup.moves.empty());
  const ObjectMove move{.source = 3, .serial = 1, .object = 0, .start_ns = 1, .end_ns = 2};
  setup.sender.note_move(move, setup.clock.now_ns());
  ASSERT_TRUE(setup.receive_until([&] { return setup.moves.size() >= 2; }));
  EXPECT_EQ(setup.moves.front().serial, 1U);
  (void)setup.confirmed_moves.take(move);
  setup.receive_for(std::chrono::milliseconds(50));
  const std::size_t before = setup.moves.size();
  setup.receive_for(std::chrono::milliseconds(400));
  EXPECT_EQ(setup.moves.size(), before);
  // A hub that has restarted knows nothing of the move.
  setup.confirmed_moves.clear();
  EXPECT_TRUE(setup.receive_until([&] { return setup.moves.size() > before; }));
}

// It was announced before the hub requested parts, and may have been lost on the way.
TEST(PatchSender, AMoveFromBeforeTheFirstRequestIsSentToo) {
  TouchScene scene = scene_of(made::sheet(0.05, 0.0, 20));
  scene.objects[0].command_pivot = Vec3::Zero();
  SenderWithHub setup(true, scene);
  setup.sender.note_move({.source = 3, .serial = 1, .object = 0, .start_ns = 1, .end_ns = 2}, setup.clock.now_ns());
  ASSERT_TRUE(setup.receive_until([&] { return setup.moves.size() >= 2; }));
  (void)setup.confirmed_moves.take(setup.moves.front());
  setup.receive_for(std::chrono::milliseconds(100));
  EXPECT_EQ(setup.sender.counts().moves_repeated + 1U, setup.moves.size()) << "the first time it is not sent again";
}

// Each reason has its own line of text.
TEST(PatchSender, MovingObjectsThatCannotBeSentAreNeverOffered) {
  const auto obstacle_of = [](const TouchScene& scene) { return std::string(SenderWithHub(true, scene).sender.obstacle()); };
  TouchScene many;
  for (int n = 0; n < 32; ++n) {
    many.objects.push_back({made::shared(made::box(Vec3(0.02 * n, 0, 0), Vec3(0.02 * n + 0.01, 0.01, 0.01))), {}});
    many.objects.back().command_pivot = Vec3::Zero();
  }
  EXPECT_EQ(obstacle_of(many), "more than 31 objects of the scene move");
  many.objects.pop_back();
  EXPECT_EQ(obstacle_of(many), "");
  many.objects.push_back({made::shared(made::sheet(0.05, 0.0, 2)), {}});
  EXPECT_EQ(obstacle_of(many), "") << "31 that move, and one that does not";
  TouchScene scene = scene_of(made::sheet(0.05, 0.0, 20));
  scene.objects[0].motion = slow_motion(1537);
  EXPECT_EQ(obstacle_of(scene), "an object of the scene has more than 1,536 keyframes");
  scene = scene_of(made::sheet(0.05, 0.0, 20));
  scene.objects[0].stream_reach_m = 0.01;
  EXPECT_EQ(obstacle_of(scene), "");
  scene.objects[0].stream_reach_m.reset();
  scene.objects[0].deformation = slow_deformation(4097);
  EXPECT_EQ(obstacle_of(scene), "an object of the scene has more than 4,096 keys of its shape");
}

// A deforming object is sent complete; if it cannot be felt on the grid of its parts, it is not sent at all.
TEST(PatchSender, ASceneThatDeformsIsOfferedIfItCanBeFelt) {
  TouchScene scene = scene_of(made::sheet(0.05, 0.0, 20));
  scene.objects.push_back({made::shared(made::box(Vec3(0, 0, 0.01), Vec3(0.01, 0.01, 0.02))), {}});
  scene.objects[1].deformation = slow_deformation(100);
  SenderWithHub setup(true, scene);
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.has_bodies() && std::isinf(setup.store.known_radius(Vec3::Zero(), 1)); }));
  EXPECT_TRUE(setup.store.make_bodies(0)->bodies[1].deforms);
  EXPECT_EQ(setup.store.make_piece(Vec3::Zero(), 1.0, 1, 1).scene.objects.front().deformation->keys().size(), 100U);
  TriangleMesh mesh = made::box(Vec3(0, 0, 0.01), Vec3(0.01, 0.01, 0.02));  // gets three triangles at an edge: not walkable
  mesh.vertices.emplace_back(0.03, 0.03, 0.03);
  mesh.triangles.push_back({mesh.triangles[0][0], mesh.triangles[0][1], static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
  scene.objects[1].mesh = made::shared(std::move(mesh));
  SenderWithHub other(true, scene);
  ASSERT_TRUE(other.receive_until([&] { return other.store.has_begun(); }));
  EXPECT_EQ(other.sender.obstacle(), "an object that deforms cannot be felt from parts of the scene");
  other.receive_for(std::chrono::milliseconds(100));
  EXPECT_EQ(other.triangles(), 0U);
}

// A deformed object is sent with its newest announced shape, whether that was announced before or after the parts were made.
TEST(PatchSender, WhatProgramsDeformIsSentWithTheShapeThatItHas) {
  TouchScene scene = scene_of(made::sheet(0.05, 0.0, 20));
  scene.objects.push_back({made::shared(made::box(Vec3(0, 0, 0.01), Vec3(0.01, 0.01, 0.02))), {}});
  scene.objects[1].stream_reach_m = 0.002;
  SenderWithHub setup(true, scene);
  setup.sender.note_shape({.source = 3, .serial = 5, .object = 1, .total = 8});
  setup.sender.note_shape({.source = 3, .serial = 6, .object = 0, .total = 8});
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.has_bodies() && setup.store.find_stream(1) != nullptr; }));
  EXPECT_EQ(setup.store.find_stream(1)->shape_serial(), 5U);
  EXPECT_FALSE(std::isinf(setup.store.known_radius(Vec3::Zero(), 1))) << "the shape has not come";
  // Two vertices that coincide on the grid may move apart.
  TriangleMesh mesh = *scene.objects[1].mesh;
  mesh.vertices.push_back(mesh.vertices[0] + Vec3(1e-10, 0, 0));
  mesh.triangles[0][0] = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  scene.objects[1].mesh = made::shared(std::move(mesh));
  SenderWithHub other(true, scene);
  ASSERT_TRUE(other.receive_until([&] { return other.store.has_begun(); }));
  EXPECT_EQ(other.sender.obstacle(), "an object of the scene deforms and comes apart");
}

TEST(PatchSender, ASceneThatCanBeCarvedIsNeverOffered) {
  TouchScene scene = scene_of(made::sheet(0.05, 0.0, 20));
  scene.objects[0].sculpt = SculptSettings{.voxel_m = 0.001, .tool_radius_m = 0.004, .button = 1};
  SenderWithHub setup(true, scene);
  setup.sender.set_offered(true);
  EXPECT_FALSE(setup.sender.is_offered());
  EXPECT_EQ(setup.sender.obstacle(), "objects of the scene can be carved");
}

TEST(PatchSender, OffersWhatPartsServe) {
  EXPECT_TRUE(PatchSender::can_offer("name=proxy probe_radius_m=0"));
  EXPECT_FALSE(PatchSender::can_offer("name=proxy probe_radius_m=0 shading=0.5"));
  EXPECT_FALSE(PatchSender::can_offer("name=smooth"));
  EXPECT_FALSE(PatchSender::can_offer(std::string_view("\0name=proxy", 11)));
}

TEST(PatchSender, PartsAreWithdrawnOnceTheHubHasConfirmedIt) {
  SenderWithHub setup;
  ASSERT_TRUE(setup.receive_until([&] { return setup.is_whole(); }));
  EXPECT_EQ(setup.store.begin().method_serial, 0U);
  setup.request_parts();
  EXPECT_FALSE(setup.sender.is_withdrawn(0));
  setup.sender.set_withdrawn(true, 0);
  setup.request_parts();
  EXPECT_FALSE(setup.sender.is_withdrawn(0)) << "the hub has parts";
  EXPECT_TRUE(setup.sender.is_withdrawn(1)) << "another hub has none";
  const std::uint32_t epoch = setup.store.status().epoch;
  EXPECT_TRUE(setup.lose_until([&] { return setup.sender.front() != nullptr && epoch_of(*setup.sender.front()) == epoch + 1; }));
  EXPECT_FALSE(setup.sender.is_withdrawn(0)) << "the hub has not confirmed it";
  ASSERT_TRUE(setup.receive_until([&] { return setup.sender.is_withdrawn(0); }));
  EXPECT_EQ(setup.store.status().epoch, epoch + 1);
  setup.receive_for(std::chrono::milliseconds(200));
  EXPECT_EQ(setup.store.status().epoch, epoch + 1);
  EXPECT_EQ(setup.triangles(), 0U);
  setup.sender.set_withdrawn(false, 31);
  EXPECT_FALSE(setup.sender.is_withdrawn(0));
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.status().epoch == epoch + 2 && setup.is_whole(); }));
  EXPECT_EQ(setup.store.begin().method_serial, 31U);
  EXPECT_EQ(setup.triangles(), 800U);
  // An earlier confirmation of the hub does not count for the parts that it has now.
  setup.sender.set_withdrawn(true, 31);
  setup.request_parts();
  EXPECT_FALSE(setup.sender.is_withdrawn(0));
  ASSERT_TRUE(setup.receive_until([&] { return setup.sender.is_withdrawn(0); }));
  EXPECT_EQ(setup.triangles(), 0U);
}

TEST(PatchSender, WhatWasMadeBeforeAWithdrawalIsNeverSent) {
  SenderWithHub setup;
  for (int n = 0; n < 6000 && setup.sender.front() == nullptr; ++n) {
    setup.request_parts();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_NE(setup.sender.front(), nullptr);
  const std::uint32_t epoch = epoch_of(*setup.sender.front());
  setup.sender.set_withdrawn(true, 0);
  EXPECT_TRUE(setup.sender.front() == nullptr || epoch_of(*setup.sender.front()) > epoch);
  EXPECT_TRUE(setup.sender.is_withdrawn(0)) << "the hub was sent none";
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.has_begun(); }));
  EXPECT_EQ(setup.store.status().epoch, epoch + 1);
  setup.receive_for(std::chrono::milliseconds(200));
  EXPECT_EQ(setup.triangles(), 0U);
  EXPECT_TRUE(setup.sender.is_withdrawn(0));
}

TEST(PatchSender, AHubThatWantsNoPartsNeedNotConfirmThatItHasNone) {
  SenderWithHub setup;
  setup.sender.set_withdrawn(true, 0);
  EXPECT_TRUE(setup.sender.is_withdrawn(0)) << "nothing was sent";
  setup.sender.set_withdrawn(false, 0);
  ASSERT_TRUE(setup.receive_until([&] { return setup.is_whole(); }));
  setup.sender.accept({.epoch = setup.store.status().epoch, .request = 9}, setup.clock.now_ns());
  setup.sender.set_withdrawn(true, 0);
  EXPECT_TRUE(setup.sender.is_withdrawn(0));
  // The hub wants parts again: it then gets an epoch without any.
  setup.request = 11;
  setup.store.clear();
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.has_begun(); }));
  EXPECT_EQ(setup.store.begin().request, 11U);
  setup.receive_for(std::chrono::milliseconds(200));
  EXPECT_EQ(setup.triangles(), 0U);
}

// The hub has dropped its parts, and accepts nothing that was sent before its new request.
TEST(PatchSender, EachRequestGetsAnEpochOfItsOwn) {
  SenderWithHub setup;
  ASSERT_TRUE(setup.receive_until([&] { return setup.is_whole(); }));
  EXPECT_EQ(setup.store.begin().request, 9U);
  const std::uint32_t epoch = setup.store.status().epoch;
  setup.request = 11;
  ASSERT_TRUE(setup.receive_until([&] { return setup.store.status().epoch == epoch + 1 && setup.is_whole(); }));
  EXPECT_EQ(setup.store.begin().request, 11U);
}

// Such a hub may still compute forces from its parts.
TEST(PatchSender, PartsAreWithdrawnFromAHubThatHasBeenSilentForLong) {
  SenderWithHub setup;
  ASSERT_TRUE(setup.receive_until([&] { return setup.is_whole(); }));
  const std::uint32_t epoch = setup.store.status().epoch;
  std::this_thread::sleep_for(std::chrono::milliseconds(1200));
  ASSERT_FALSE(setup.sender.is_wanted(setup.clock.now_ns()));
  setup.sender.set_withdrawn(true, 0);
  const auto is_new = [&] { return setup.sender.front() != nullptr && epoch_of(*setup.sender.front()) == epoch + 1; };
  ASSERT_TRUE(setup.lose_until(is_new));
  setup.sender.pop();
  ASSERT_TRUE(setup.lose_until(is_new)) << "again, as it may be lost";
  EXPECT_FALSE(setup.sender.is_withdrawn(0));
  EXPECT_TRUE(setup.receive_until([&] { return setup.sender.is_withdrawn(0); }));
}

TEST(PatchSender, TheReplyLoopsCallsUseNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  SenderWithHub setup;
  setup.request_parts();
  const PatchStatus status{.is_wanted = true};
  const AllocationGuard guard;
  for (int n = 0; n < 100; ++n) {
    setup.sender.accept(status, n);
    setup.sender.note_hand({}, kIdentityPose);
    if (setup.sender.front() != nullptr) setup.sender.pop();
    setup.sender.set_withdrawn(n % 3 == 0 && !setup.sender.is_withdrawn(0), static_cast<std::uint32_t>(n));
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
