#include "patch/patch_store.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <random>
#include <set>

#include "tests/patch/patch_stage.h"

namespace hapton {
namespace {

PatchTile numbered_tile(PatchTile tile, std::uint32_t epoch, std::uint32_t serial) {
  tile.epoch = epoch;
  tile.serial = serial;
  return tile;
}

// A scene, and a store that gets its cells and tiles one by one.
struct SceneStore {
  explicit SceneStore(const TouchScene& scene) : tiled(make_tiles(scene)) {
    store.accept(PatchBegin{1, ++serial, tiled.grid.origin_m, tiled.grid.step_m, 0.0, 7});
  }
  void accept_cell(std::size_t n) { store.accept(to_message(tiled.cells[n], 1, ++serial)); }
  void accept_tile(std::size_t n) { store.accept(numbered_tile(tiled.tiles[n], 1, ++serial)); }
  TiledScene tiled;
  PatchStore store;
  std::uint32_t serial = 0;
};

// By brute force: within the known radius no triangle of the scene may be missing.
TEST(PatchStore, WithinTheKnownRadiusNoTriangleIsMissing) {
  const TouchScene scene = scene_of(wavy_sheet(0.05, 60));
  SceneStore scene_store(scene);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> coordinate(-0.06, 0.06);
  std::vector<char> has_tile(scene_store.tiled.tiles.size(), 0);
  int known_count = 0;
  for (int round = 0; round < 400; ++round) {
    if (round % 2 == 0) scene_store.accept_cell(random() % scene_store.tiled.cells.size());
    for (int n = 0; n < 2; ++n) {
      const std::size_t tile = random() % scene_store.tiled.tiles.size();
      scene_store.accept_tile(tile);
      has_tile[tile] = 1;
    }
    const Vec3 p(coordinate(random), coordinate(random), 0.2 * coordinate(random));
    const double radius = scene_store.store.known_radius(p);
    known_count += radius > 0.0 ? 1 : 0;
    for (std::size_t tile = 0; tile < has_tile.size(); ++tile) {
      if (has_tile[tile] != 0) continue;
      for (std::size_t v = 0; v < scene_store.tiled.tiles[tile].vertex_count; ++v) {
        ASSERT_GE((scene_store.tiled.grid.at(read_vertex(scene_store.tiled.tiles[tile], v)) - p).norm(), radius);
      }
    }
  }
  EXPECT_GT(known_count, 10);
}

TEST(PatchStore, AWholeSceneIsKnownEverywhere) {
  SceneStore scene_store(scene_of(wavy_sheet(0.05, 30)));
  EXPECT_EQ(scene_store.store.known_radius(Vec3::Zero()), 0.0);
  for (std::size_t n = 0; n < scene_store.tiled.tiles.size(); ++n) scene_store.accept_tile(n);
  EXPECT_EQ(scene_store.store.known_radius(Vec3::Zero()), 0.0) << "no cell says that nothing is missing";
  for (std::size_t n = 0; n < scene_store.tiled.cells.size(); ++n) scene_store.accept_cell(n);
  EXPECT_EQ(scene_store.store.known_radius(Vec3(1, 2, 3)), std::numeric_limits<double>::infinity());
  const PatchStore::Piece piece = scene_store.store.make_piece(Vec3::Zero(), std::numeric_limits<double>::infinity(), 10'000);
  ASSERT_EQ(piece.scene.objects.size(), 1U);
  EXPECT_EQ(piece.scene.objects[0].mesh->triangles.size(), 1800U);
  EXPECT_EQ(piece.scene.objects[0].mesh->vertices.size(), 961U) << "a vertex that tiles share is one";
  EXPECT_EQ(piece.scene.part_of.low, scene_store.tiled.grid.box().low);
  EXPECT_EQ(piece.scene.part_of.high, scene_store.tiled.grid.box().high);
}

TEST(PatchStore, APieceHasNoMoreTrianglesThanRequested) {
  SceneStore scene_store(scene_of(wavy_sheet(0.05, 100)));
  for (std::size_t n = 0; n < scene_store.tiled.tiles.size(); ++n) scene_store.accept_tile(n);
  for (std::size_t n = 0; n < scene_store.tiled.cells.size(); ++n) scene_store.accept_cell(n);
  const PatchStore::Piece piece = scene_store.store.make_piece(Vec3::Zero(), std::numeric_limits<double>::infinity(), 5000);
  EXPECT_LE(piece.triangles, 5000U);
  EXPECT_GT(piece.triangles, 1000U);
  EXPECT_GT(piece.radius_m, 0.005);
  EXPECT_LT(piece.radius_m, 0.05);
}

bool is_confirmed(const PatchStatus& status, std::uint32_t serial) {
  const std::uint32_t back = status.newest_serial - serial;
  return serial <= status.newest_serial && back < PatchStatus::kSerials && ((status.received[back / 8] >> (back % 8)) & 1U) != 0;
}

TEST(PatchStore, ConfirmsWhatCameInAnyOrder) {
  SceneStore scene_store(scene_of(wavy_sheet(0.05, 10)));
  std::mt19937_64 random(3);
  std::set<std::uint32_t> received = {1};
  for (int n = 0; n < 3000; ++n) {
    const auto serial = static_cast<std::uint32_t>(1 + n + random() % 40);
    scene_store.store.accept(numbered_tile(scene_store.tiled.tiles[0], 1, serial));
    received.insert(serial);
    const PatchStatus& status = scene_store.store.status();
    ASSERT_EQ(status.newest_serial, *received.rbegin());
    for (std::uint32_t back = 0; back < 100 && back < status.newest_serial; ++back) {
      ASSERT_EQ(is_confirmed(status, status.newest_serial - back), received.contains(status.newest_serial - back));
    }
  }
}

TEST(PatchStore, ANewerEpochBeginsWithNothingAndAnOlderOneIsRejected) {
  SceneStore scene_store(scene_of(wavy_sheet(0.05, 10)));
  for (std::size_t n = 0; n < scene_store.tiled.tiles.size(); ++n) scene_store.accept_tile(n);
  for (std::size_t n = 0; n < scene_store.tiled.cells.size(); ++n) scene_store.accept_cell(n);
  scene_store.store.accept(numbered_tile(scene_store.tiled.tiles[0], 2, 1));
  EXPECT_FALSE(scene_store.store.has_begun());
  EXPECT_EQ(scene_store.store.status().epoch, 2U);
  EXPECT_EQ(scene_store.store.status().newest_serial, 1U);
  scene_store.store.accept(numbered_tile(scene_store.tiled.tiles[0], 1, 500));
  EXPECT_EQ(scene_store.store.status().epoch, 2U);
  EXPECT_GT(scene_store.store.counts().rejected, 0U);
  scene_store.store.clear();
  scene_store.store.accept(PatchBegin{1, 1, Vec3::Zero(), 1.0, 0.0, 0});
  EXPECT_TRUE(scene_store.store.has_begun()) << "another sender may count from anywhere";
}

// Whatever an authenticated sender sends, memory stays bounded, and what is not complete is not known.
TEST(PatchStore, IsBoundedWhateverComes) {
  PatchStore store;
  std::mt19937_64 random(9);
  store.accept(PatchBegin{1, 1, Vec3::Zero(), 1e-9, 0.0, 0});
  PatchTile tile;
  tile.vertex_count = 3;
  tile.triangle_count = 1;
  tile.triangles = {0, 1, 2};
  for (std::uint32_t n = 0; n < PatchStore::kMaxTiles + 100; ++n) {
    tile.tile = n;
    store.accept(numbered_tile(tile, 1, 2 + n));
  }
  EXPECT_EQ(store.counts().rejected, 100U);
  PatchCell cell{1, 1, kPatchDeepestLevel};
  cell.empty_children.fill(0xFF);
  for (std::uint32_t n = 0; n < PatchStore::kMaxCells; ++n) {
    for (std::uint32_t& i : cell.index) i = static_cast<std::uint32_t>(random() % (1U << kPatchDeepestLevel));
    cell.serial = 10'000 + n;
    store.accept(cell);
  }
  EXPECT_GT(store.counts().rejected, PatchStore::kMaxCells / 2);
  (void)store.known_radius(Vec3::Zero());
  (void)store.make_piece(Vec3::Zero(), 1.0, 100);
  // The same cells twice: first with no empty cells beside them, then with so many that there is no room for all.
  PatchStore full;
  full.accept(PatchBegin{1, 1, Vec3::Zero(), 1e-9, 0.0, 0});
  for (const auto empty : {std::uint8_t{0}, std::uint8_t{0xFF}}) {
    cell.empty_children.fill(empty);
    for (std::uint32_t n = 0; n < 2500; ++n) {
      cell.index = {n, (n * 97) % (1U << kPatchDeepestLevel), (n * 4001) % (1U << kPatchDeepestLevel)};
      cell.serial = 2 + n;
      full.accept(cell);
    }
    EXPECT_EQ(full.counts().rejected > 500, empty != 0) << full.counts().rejected;
  }
  // A cell whose tile never comes: nothing in it is known.
  PatchStore other;
  other.accept(PatchBegin{1, 1, Vec3::Zero(), 1e-9, 0.0, 0});
  cell = {1, 2, 0, {}, {}, 1, {}};
  cell.tiles[0] = 77;
  other.accept(cell);
  EXPECT_LE(other.known_radius(Vec3::Zero()), 0.0);
}

// More triangles meet at one point than were requested. The piece has all tiles there, as a piece without a radius would be of no use.
TEST(PatchStore, APieceHasWhatLiesAtItsCentreHoweverMuchThatIs) {
  TouchScene scene;
  for (int n = 0; n < 40; ++n) scene.objects.push_back(scene_of(wavy_sheet(0.05, 20)).objects.front());
  SceneStore scene_store(scene);
  for (std::size_t n = 0; n < scene_store.tiled.cells.size(); ++n) scene_store.accept_cell(n);
  for (std::size_t n = 0; n < scene_store.tiled.tiles.size(); ++n) scene_store.accept_tile(n);
  const auto piece = scene_store.store.make_piece(Vec3(0.01, 0.01, 0.0), 1.0, 10);
  EXPECT_GT(piece.triangles, 40U);
  EXPECT_LT(piece.triangles, 40U * 800U);
  EXPECT_GT(piece.radius_m, 1e-4);
}

// A body that moves by two keyframes, for a scene of two bodies.
PatchBody possible_body(std::uint32_t serial) {
  PatchBody body{
      .epoch = 1, .serial = serial, .body = 1, .motion = PatchBody::Motion::keyframes, .lowest = {0, 0, 0}, .highest = {64, 64, 64}};
  body.radius_m = 64e-6;
  body.all_keys = body.key_count = 2;
  body.keys[1] = {1.0, Vec3(0.1, 0, 0), Quat::Identity()};
  return body;
}

// A store that knows a scene of two bodies, of which body 0 stands still and body 1 is still to come.
struct MovingBodyStore {
  PatchStore store;
  std::uint32_t serial = 1;

  MovingBodyStore() {
    store.accept(PatchBegin{.epoch = 1, .serial = 1, .step_m = 1e-6, .body_count = 2});
    store.accept(PatchBody{.epoch = 1, .serial = 2});
    serial = 2;
  }
  // Sends a possible body 1 with this change. Returns whether the store then knows all bodies.
  bool has_bodies_after(const std::function<void(PatchBody&)>& change) {
    PatchBody body = possible_body(++serial);
    change(body);
    store.accept(body);
    return store.has_bodies();
  }
};

TEST(PatchStore, KnowsABodyWhenAllOfItHasCome) {
  MovingBodyStore moving;
  EXPECT_FALSE(moving.store.has_bodies());
  EXPECT_TRUE(moving.has_bodies_after([](PatchBody&) {}));
  EXPECT_EQ(moving.store.make_bodies(4)->bodies[1].keyframes->duration_s(), 1.0);
  MovingBodyStore parts;
  EXPECT_FALSE(parts.has_bodies_after([](PatchBody& body) {
    body.first_key = 1;
    body.key_count = 1;
    body.keys[0] = body.keys[1];
  }));
  EXPECT_TRUE(parts.has_bodies_after([](PatchBody& body) { body.key_count = 1; })) << "in any order";
}

// The codec checks each number by itself. Together the numbers may still be a motion that no scene can have.
TEST(PatchStore, DropsABodyThatMovesAsNothingMay) {
  const std::vector<std::function<void(PatchBody&)>> changes = {
      [](PatchBody& body) { body.keys[1].p_S.x() = 0.2501; },
      [](PatchBody& body) { body.keys[1].turn = Quat(Eigen::AngleAxisd(3.0, Vec3::UnitX())), body.radius_m = 1.0; },
      [](PatchBody& body) { body.radius_m = 30e-6; }, [](PatchBody& body) { body.keys[1].turn = Quat(1.0 + 1e-6, 0, 0, 0); },
      [](PatchBody& body) { body.keys[0].time_s = 1.0; }, [](PatchBody& body) { body.loops = true; },
      // The body ends where it began, but turned: it would jump at each repetition.
      [](PatchBody& body) {
        body.loops = true, body.keys[1].p_S = body.keys[0].p_S, body.keys[1].turn = Quat(Eigen::AngleAxisd(1e-3, Vec3::UnitX()));
      },
      [](PatchBody& body) { body.motion = PatchBody::Motion::still, body.all_keys = body.key_count = 0; },
      [](PatchBody& body) { body.keys[1].time_s = 0.39; }};
  for (std::size_t n = 0; n < changes.size(); ++n) {
    MovingBodyStore moving;
    const std::uint64_t parts = moving.store.counts().parts;
    EXPECT_FALSE(moving.has_bodies_after(changes[n])) << n;
    // None of them is confirmed, except the one whose box is too wide for its radius: the grid is needed to know that.
    if (n != 2) {
      EXPECT_EQ(moving.store.counts().parts, parts) << n;
    }
  }
  MovingBodyStore slower;
  EXPECT_TRUE(slower.has_bodies_after([](PatchBody& body) { body.keys[1].time_s = 2.0, body.keys[1].p_S.x() = 0.4; }));
  MovingBodyStore moving;
  EXPECT_TRUE(moving.has_bodies_after([](PatchBody&) {}));
  const std::uint64_t rejected = moving.store.counts().rejected;
  EXPECT_TRUE(moving.has_bodies_after([](PatchBody& body) { body.keys[1].p_S.x() = 0.3, body.pivot_m.x() = 1.0; }))
      << "another body of that number";
  EXPECT_EQ(moving.store.counts().rejected, rejected + 1);
  EXPECT_EQ(moving.store.make_bodies(0)->bodies[1].keyframes->keyframes()[1].p_S.x(), 0.1);
}

// A hostile haptics node may announce too many: the memory for all keyframes is taken when the first ones come.
TEST(PatchStore, NoBodyHasMoreKeyframesThanABodyMay) {
  for (const auto motion : {PatchBody::Motion::still, PatchBody::Motion::keyframes, PatchBody::Motion::commanded}) {
    MovingBodyStore moving;
    EXPECT_FALSE(moving.has_bodies_after([&](PatchBody& body) {
      body.motion = motion;
      body.key_count = 0;
      body.all_keys = PatchBody::kMaxAllKeys + 1;
    }));
    EXPECT_EQ(moving.store.counts().rejected, 1U);
    EXPECT_TRUE(moving.has_bodies_after([](PatchBody&) {})) << "nothing of it counts";
  }
}

// Even before any cell of a body has come, it is known that the body has no triangle outside its box.
TEST(PatchStore, AwayFromABodyNothingOfItIsMissing) {
  MovingBodyStore moving;
  ASSERT_TRUE(moving.has_bodies_after([](PatchBody&) {}));
  EXPECT_NEAR(moving.store.known_radius(Vec3(100e-6, 32e-6, 32e-6), 1), 36e-6, 1e-12);
  EXPECT_EQ(moving.store.known_radius(Vec3(32e-6, 32e-6, 32e-6), 1), 0.0);
  EXPECT_EQ(moving.store.known_radius(Vec3(1, 2, 3), 0), std::numeric_limits<double>::infinity()) << "it has no triangles";
}

TEST(PatchStore, TakesThePartsOfASceneAndNoOtherMessage) {
  PatchStore store;
  std::uint64_t parts = 0;
  const auto takes = [&](const Message& message) {
    EXPECT_EQ(store.accept_part(message), is_scene_part(message));
    return store.counts().parts == ++parts;
  };
  EXPECT_TRUE(takes(PatchBegin{.epoch = 1, .serial = 1, .step_m = 1e-8, .body_count = 2}));
  EXPECT_TRUE(takes(PatchCell{.epoch = 1, .serial = 2}));
  EXPECT_TRUE(takes(PatchTile{.epoch = 1, .serial = 3, .vertex_count = 1, .triangle_count = 1}));
  EXPECT_TRUE(takes(PatchBody{.epoch = 1, .serial = 4}));
  EXPECT_TRUE(takes(PatchMaterial{.epoch = 1, .serial = 5}));
  EXPECT_TRUE(
      takes(PatchDeformation{.epoch = 1, .serial = 6, .body = 1, .tile_count = 1, .target_count = 1, .all_keys = 1, .key_count = 1}));
  EXPECT_TRUE(takes(PatchDisplacements{.epoch = 1, .serial = 7, .vertex_count = 1}));
  for (const Message& other : {Message(ObjectMove()), Message(PatchStatus{.epoch = 1}), Message(Bye()), Message(ForceCommand())}) {
    EXPECT_FALSE(store.accept_part(other)) << other.index();
    EXPECT_FALSE(is_scene_part(other)) << other.index();
  }
  EXPECT_EQ(store.counts().parts, parts);
}

TEST(PatchStore, ANewerEpochHasTheMaterialsOfItsOwnOnly) {
  PatchStore store;
  store.accept(PatchBegin{.epoch = 1, .serial = 1, .step_m = 1e-8});
  store.accept(PatchMaterial{.epoch = 1, .serial = 900, .object = 3, .stiffness_n_per_m = 300.0});
  ASSERT_EQ(store.materials().size(), 1U);
  store.accept(PatchBegin{.epoch = 2, .serial = 1, .step_m = 1e-8});
  EXPECT_TRUE(store.materials().empty());
  store.accept(PatchMaterial{.epoch = 2, .serial = 2, .object = 3, .stiffness_n_per_m = 500.0});
  EXPECT_EQ(store.materials().at(3).stiffness_n_per_m, 500.0) << "serials count within an epoch";
}

// A hostile haptics node may send many epochs, each with other objects, and each object with shapes of its own.
TEST(PatchStore, KnowsTheShapesOfNoMoreObjectsThanThereMayBeBodies) {
  PatchStore store;
  const auto announce = [&](std::uint32_t epoch, std::uint32_t body, std::int32_t object) {
    store.accept(PatchStream{.epoch = epoch, .serial = 2 + body, .body = body, .tile_count = 1, .object = object, .total = 5});
  };
  std::int32_t object = 0;
  for (std::uint32_t epoch = 1; epoch <= 50; ++epoch) {
    store.accept(PatchBegin{.epoch = epoch, .serial = 1, .step_m = 1e-6, .body_count = 9});
    announce(epoch, 1, 0);
    for (std::uint32_t body = 2; body <= 8; ++body) announce(epoch, body, ++object);
    EXPECT_EQ(store.counts().rejected, 0U);
    EXPECT_LE(store.shapes().count_objects(), PatchBody::kMaxBodies);
    (void)store.accept_shape(ShapeStart{.source = 5, .serial = epoch == 1 ? 1U : 0U, .object = 0, .total = 5, .end_ns = 1},
                             Arrival::newest);
    EXPECT_NE(store.shapes().newest_start(0), nullptr) << "it is still there, " << epoch;
    EXPECT_TRUE(store.shapes().find(static_cast<std::size_t>(object), 0)) << "as are those of this epoch";
  }
}

std::vector<Message> one_part_of_each_kind(std::uint32_t epoch, std::uint32_t serial) {
  return {PatchBegin{.epoch = epoch, .serial = serial, .step_m = 1e-8, .body_count = 2},
          PatchCell{.epoch = epoch, .serial = serial},
          PatchTile{.epoch = epoch, .serial = serial, .vertex_count = 1, .triangle_count = 1},
          PatchBody{.epoch = epoch, .serial = serial},
          PatchMaterial{.epoch = epoch, .serial = serial},
          PatchDeformation{.epoch = epoch, .serial = serial, .body = 1, .tile_count = 1, .target_count = 1, .all_keys = 1, .key_count = 1},
          PatchDisplacements{.epoch = epoch, .serial = serial, .vertex_count = 1},
          PatchStream{.epoch = epoch, .serial = serial, .body = 1, .tile_count = 1, .total = 1},
          PatchEffects{.epoch = epoch, .serial = serial, .byte_count = 1}};
}

// A surface of the earlier scene must not be felt in this one.
TEST(PatchStore, NoPartOfAnEarlierEpochOrWithoutANumberIsTaken) {
  for (const auto& [epoch, serial] : {std::pair(6U, 9U), std::pair(0U, 9U), std::pair(7U, 0U)}) {
    PatchStore store;
    store.accept(PatchMaterial{.epoch = 7, .serial = 1, .object = 4});
    std::uint64_t rejected = 0;
    for (const Message& part : one_part_of_each_kind(epoch, serial)) {
      EXPECT_TRUE(store.accept_part(part));
      EXPECT_EQ(store.counts().rejected, ++rejected) << epoch << " " << serial << ", kind " << part.index();
      EXPECT_EQ(store.counts().parts, 1U);
    }
    EXPECT_FALSE(store.has_begun());
    EXPECT_EQ(store.status().epoch, 7U);
    EXPECT_EQ(store.status().newest_serial, 1U);
    EXPECT_EQ(store.materials().size(), 1U);
  }
}

// A body that is not announced yet may be anywhere, and have triangles anywhere.
TEST(PatchStore, AllOfABodyIsMissingUntilItIsAnnounced) {
  PatchStore store;
  store.accept(PatchBegin{.epoch = 1, .serial = 1, .step_m = 1e-6, .body_count = 2});
  EXPECT_EQ(store.known_radius(Vec3(1, 2, 3), 0), 0.0);
  EXPECT_EQ(store.known_radius(Vec3(1, 2, 3), 1), 0.0);
}

// Each of these changes alone shows that a part is of another body than the first part.
TEST(PatchStore, NothingOfABodyIsMixedWithAnotherOneOfItsNumber) {
  const std::vector<std::function<void(PatchBody&)>> changes = {[](PatchBody& body) { body.motion = PatchBody::Motion::commanded; },
                                                                [](PatchBody& body) { body.deforms = true; },
                                                                [](PatchBody& body) { body.all_keys = 3; },
                                                                [](PatchBody& body) { body.loops = true; },
                                                                [](PatchBody& body) { body.lowest[2] = 1; },
                                                                [](PatchBody& body) { body.highest[1] = 63; },
                                                                [](PatchBody& body) { body.pivot_m.z() = 1e-6; },
                                                                [](PatchBody& body) { body.radius_m = 65e-6; },
                                                                [](PatchBody& body) { body.object = 1; },
                                                                [](PatchBody& body) { body.first_key = 1; }};
  for (std::size_t n = 0; n < changes.size(); ++n) {
    MovingBodyStore moving;
    ASSERT_TRUE(moving.has_bodies_after([](PatchBody&) {}));
    EXPECT_TRUE(moving.has_bodies_after([&](PatchBody& body) {
      body.keys[0].time_s = 0.5;
      changes[n](body);
    }));
    EXPECT_EQ(moving.store.counts().rejected, 1U) << n;
    EXPECT_EQ(moving.store.make_bodies(0)->bodies[1].keyframes->keyframes()[0].time_s, 0.0) << n;
  }
}

// The same for the way in which a body deforms.
TEST(PatchStore, NothingOfADeformationIsMixedWithAnotherOne) {
  const std::vector<std::function<void(PatchDeformation&)>> changes = {
      [](PatchDeformation& part) { part.first_tile = 4; },
      [](PatchDeformation& part) { part.tile_count = 2; },
      [](PatchDeformation& part) { part.displaced_count = 2; },
      [](PatchDeformation& part) { part.target_count = 2; },
      [](PatchDeformation& part) { part.loops = true; },
      [](PatchDeformation& part) { part.all_keys = 3; },
      [](PatchDeformation& part) { part.body = PatchBody::kMaxBodies; },
      [](PatchDeformation& part) { part.body = 2, part.tile_count = PatchStore::kMaxTiles + 1; },
      [](PatchDeformation& part) { part.body = 2, part.first_tile = ~0U; }};
  const PatchDeformation first{.epoch = 1,
                               .serial = 2,
                               .body = 1,
                               .first_tile = 3,
                               .tile_count = 1,
                               .displaced_count = 1,
                               .target_count = 1,
                               .all_keys = 2,
                               .key_count = 1};
  for (std::size_t n = 0; n < changes.size(); ++n) {
    PatchStore store;
    store.accept(PatchBegin{.epoch = 1, .serial = 1, .step_m = 1e-6, .body_count = 3});
    store.accept(first);
    PatchDeformation other = first;
    other.serial = 3;
    other.first_key = 1;
    changes[n](other);
    store.accept(other);
    EXPECT_EQ(store.counts().rejected, 1U) << n;
    EXPECT_EQ(store.status().newest_serial, 2U) << n;
    other = first;
    other.serial = 4;
    other.first_key = 1;
    store.accept(other);
    EXPECT_EQ(store.counts().rejected, 1U) << n << ": what fits is taken after it";
  }
}

TEST(PatchStore, HasNoMoreDisplacementsAndMaterialsThanItMay) {
  PatchStore store;
  std::uint32_t serial = 0;
  for (std::uint32_t n = 0; n <= PatchStore::kMaxDisplaced; ++n) {
    EXPECT_EQ(store.counts().rejected, 0U);
    store.accept(PatchDisplacements{.epoch = 1, .serial = ++serial, .tile = n, .vertex_count = 1});
  }
  EXPECT_EQ(store.counts().rejected, 1U);
  EXPECT_EQ(store.status().newest_serial, PatchStore::kMaxDisplaced);
  store.accept(PatchDisplacements{.epoch = 1, .serial = ++serial, .tile = 0, .vertex_count = 1});
  EXPECT_EQ(store.counts().rejected, 1U) << "a tile that is there takes no other place";
  for (std::uint32_t n = 0; n <= PatchStore::kMaxTiles; ++n) store.accept(PatchMaterial{.epoch = 1, .serial = ++serial, .object = n});
  EXPECT_EQ(store.counts().rejected, 2U);
  EXPECT_EQ(store.materials().size(), PatchStore::kMaxTiles);
  store.accept(PatchMaterial{.epoch = 1, .serial = ++serial, .object = 0, .stiffness_n_per_m = 70.0});
  EXPECT_EQ(store.materials().at(0).stiffness_n_per_m, 70.0);
}

// Epochs wrap around at 32 bits.
TEST(PatchStore, TheEpochAfterTheLastNumberIsANewerOne) {
  PatchStore store;
  store.accept(PatchBegin{.epoch = ~0U, .serial = 1, .step_m = 1e-8, .scene_hash = 7});
  store.accept(PatchBegin{.epoch = 1, .serial = 1, .step_m = 1e-8, .scene_hash = 8});
  ASSERT_TRUE(store.has_begun());
  EXPECT_EQ(store.begin().scene_hash, 8U);
  store.accept(PatchBegin{.epoch = ~0U, .serial = 2, .step_m = 1e-8, .scene_hash = 7});
  EXPECT_EQ(store.begin().scene_hash, 8U) << "late";
  EXPECT_EQ(store.counts().rejected, 1U);
}

// The body was announced again after it had been moved. Only that move tells where the body is.
TEST(PatchStore, ABodyNeedsTheNewestMoveThatItWasAnnouncedWith) {
  PatchStore store;
  store.accept(PatchBegin{.epoch = 1, .serial = 1, .step_m = 1e-6, .body_count = 2});
  store.accept(PatchBody{.epoch = 1, .serial = 2});
  PatchBody body{.epoch = 1, .serial = 3, .body = 1, .motion = PatchBody::Motion::commanded, .object = 4};
  for (const std::uint32_t move_serial : {3U, 7U, 5U}) {
    body.move_serial = move_serial;
    store.accept(body);
    ++body.serial;
  }
  ASSERT_TRUE(store.has_bodies());
  EXPECT_EQ(store.make_bodies(0)->bodies[1].object, 4);
  EXPECT_EQ(store.make_bodies(0)->bodies[1].move_serial, 7U);
  EXPECT_EQ(store.counts().rejected, 0U);
}

}  // namespace
}  // namespace hapton
