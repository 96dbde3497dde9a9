// Compares touch by patches of a surface that a program deforms with touch of the whole scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "core/math/commanded_motion.h"
#include "patch/streamed_parts.h"
#include "tests/patch/chain_stage.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr double kStreamReachM = 0.006;
constexpr std::int64_t kShapePeriodNs = 33'000'000;  // 30 shapes a second

// A floor, and above it a sheet of 40 mm that a program deforms.
TouchScene skin_on_floor(double friction = 0.0) {
  TouchScene scene;
  const Material material{.stiffness_n_per_m = 800.0, .friction_static = friction, .friction_dynamic = 0.8 * friction};
  scene.objects.push_back({made::shared(made::sheet(0.05, 0.0, 10)), material});
  scene.objects.push_back({made::shared(made::sheet(0.02, 0.007, 24)), material});
  scene.objects.back().stream_reach_m = kStreamReachM;
  return on_patch_grid(scene);
}

// The shape of a wave that runs through the sheet; each number has another phase.
ChainStage::Shape wave_of(const TouchScene& scene, int number) {
  ChainStage::Shape shape;
  for (const Vec3& p : scene.objects[1].mesh->vertices) {
    const double phase = 250.0 * p.x() + 120.0 * p.y() - 0.9 * number;
    shape.push_back({static_cast<float>(0.0004 * std::cos(phase)), 0.0F, static_cast<float>(0.0016 * std::sin(phase))});
  }
  return shape;
}

ShapeStart shape_start(const TouchScene& scene, std::uint32_t serial, std::int64_t start_ns, std::int64_t over_ns = kShapePeriodNs) {
  return {.source = 5,
          .serial = serial,
          .before = serial - 1,
          .object = 1,
          .total = static_cast<std::uint32_t>(scene.objects[1].mesh->vertices.size()),
          .start_ns = start_ns,
          .end_ns = start_ns + over_ns};
}

// The hand presses in, moves to and fro, and now and then off the edge of the sheet onto the floor.
Vec3 skin_hand(double t_s) { return {0.03 * std::sin(2.1 * t_s), 0.009 * std::cos(1.3 * t_s), 0.0045 + 0.0055 * std::cos(5.0 * t_s)}; }

struct SkinErrors {
  double worst_share = 0.0;  // of the force
  int skin_steps = 0;
  int floor_steps = 0;
  int steps_without_patch = 0;
};

void note(SkinErrors& errors, const ChainStage::Outputs& felt) {
  errors.skin_steps += felt.whole.object == 1 ? 1 : 0;
  errors.floor_steps += felt.whole.object == 0 ? 1 : 0;
  if (!felt.patch) {
    ++errors.steps_without_patch;
    return;
  }
  const double error_n = (felt.patch->force_n - felt.whole.force_n).norm();
  errors.worst_share = std::max(errors.worst_share, error_n / std::max(felt.whole.force_n.norm(), 1e-3));
}

TEST(StreamedPatch, GivesTheForceOfTheHapticsNodesStepOnAnIdealLink) {
  for (const double friction : {0.0, 0.5}) {
    const TouchScene scene = skin_on_floor(friction);
    ChainStage stage(scene);
    SkinErrors errors;
    std::uint32_t serial = 0;
    for (int n = 0; n < 8000; ++n) {
      // Each shape is announced 0.1 s before it begins, so that three or four wait.
      const std::int64_t next_ns = 120'000'000 + serial * kShapePeriodNs;
      if (1e9 * stage.time_s() > static_cast<double>(next_ns) - 1e8 && n < 7000) {
        const ShapeStart start = shape_start(scene, ++serial, next_ns);
        const ChainStage::Shape shape = wave_of(scene, static_cast<int>(serial));
        ASSERT_TRUE(stage.deform(start, shape)) << serial;
        stage.announce(start, shape);
      }
      note(errors, stage.step(skin_hand(stage.time_s())));
    }
    EXPECT_EQ(errors.steps_without_patch, 0);
    EXPECT_LT(errors.worst_share, friction == 0.0 ? 1e-9 : 0x1p-20) << friction;
    EXPECT_GT(errors.skin_steps, 1500);
    EXPECT_GT(errors.floor_steps, 20);
    EXPECT_GT(serial, 200U);
    EXPECT_EQ(stage.chain().counts().late_shapes, 0U);
    EXPECT_EQ(stage.chain().counts().shapes, serial) << "all that were announced after its patch was made";
  }
}

// A patch that is made while the surface moves, or long after, begins in its present shape.
TEST(StreamedPatch, APatchBeginsInThePresentShape) {
  for (const int begin : {140, 150, 400}) {
    const TouchScene scene = skin_on_floor();
    ChainStage stage(scene);
    for (std::uint32_t serial = 1; serial <= 4; ++serial) {
      const ShapeStart start = shape_start(scene, serial, 30'000'000 + serial * kShapePeriodNs);
      ASSERT_TRUE(stage.deform(start, wave_of(scene, static_cast<int>(serial))));
      stage.announce(start, wave_of(scene, static_cast<int>(serial)));
    }
    SkinErrors errors;
    for (int n = 0; n < 800; ++n) {
      const Vec3 hand(0.003, 0.002, n < begin + 5 ? 0.02 : 0.02 - std::min(0.016, 2e-4 * (n - begin - 5)));
      const ChainStage::Outputs felt = stage.step(hand, Pose::Identity(), n >= begin);
      if (n >= begin) note(errors, felt);
    }
    EXPECT_EQ(errors.steps_without_patch, 0) << begin;
    EXPECT_LT(errors.worst_share, 1e-9) << begin;
    EXPECT_GT(errors.skin_steps, 200) << begin;
  }
}

// The parts of the sheet come while the hand presses on it and the surface moves.
TEST(StreamedPatch, GoesOnFromWhereTheProxyWasWhenThePartsCome) {
  for (const int late_steps : {0, 20, 150}) {
    const TouchScene scene = skin_on_floor();
    ChainStage stage(scene);
    const auto whole = std::make_unique<TouchStep>(*make_method({}, scene), scene);
    const Vec3 resting_hand(0.003, 0.002, 0.005);
    // The whole scene a second time, with the shapes that the stage gets: this one has felt contact before.
    StreamedMethod& method = *whole->find_streamed(1);
    std::vector<Vec3> from(method.stager().rest().begin(), method.stager().rest().end());
    for (std::uint32_t serial = 1; serial <= 6; ++serial) {
      const ShapeStart start = shape_start(scene, serial, 30'000'000 + serial * kShapePeriodNs, serial == 6 ? 900'000'000 : kShapePeriodNs);
      const ChainStage::Shape shape = wave_of(scene, static_cast<int>(serial));
      std::vector<Vec3> to(method.stager().rest().begin(), method.stager().rest().end());
      for (std::size_t v = 0; v < to.size(); ++v) to[v] += Vec3(shape[v][0], shape[v][1], shape[v][2]);
      (void)method.offer_at(*method.stager().make(from, to), 1e-9 * static_cast<double>(start.start_ns),
                            1e-9 * static_cast<double>(start.end_ns - start.start_ns));
      from = to;
      stage.announce(start, shape);
    }
    TouchInput input{.p_WD = Vec3(0.003, 0.002, 0.02)};
    whole->reset(input);
    TouchOutput felt;
    for (int n = 0; n <= 260; ++n) {
      input.time_s = 1e-3 * n;
      input.p_WD.z() = 0.02 - std::min(1.0, n / 100.0) * 0.015;
      felt = whole->step(input);
    }
    ASSERT_TRUE(felt.contact);
    stage.skip_to(0.26);
    stage.chain().start_at(resting_hand + felt.visual_offset_m, felt.visual_offset_m.normalized(), 0.0, 0.26);
    double worst_n = 0.0;
    for (int n = 1; n <= 500; ++n) {
      input.time_s = 0.26 + 1e-3 * n;
      felt = whole->step(input);
      const ChainStage::Outputs both = stage.step(resting_hand, Pose::Identity(), n > late_steps);
      if (n <= late_steps) continue;
      ASSERT_TRUE(both.patch.has_value()) << n;
      worst_n = std::max(worst_n, (both.patch->force_n - felt.force_n).norm());
    }
    EXPECT_LT(worst_n, 1e-9) << late_steps;
  }
}

// A shape that comes late is still reached, no faster than a surface may move. A shape that never comes is left out.
TEST(StreamedPatch, WhatComesLateOrNeverLeadsToTheSameShape) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    std::mt19937_64 random(seed);
    const TouchScene scene = skin_on_floor();
    ChainStage stage(scene);
    const Vec3 resting_hand(0.003, 0.002, 0.004);
    std::vector<std::pair<int, std::uint32_t>> on_their_way;  // step of arrival, serial
    constexpr std::uint32_t kShapes = 40;
    double last_n = -1.0;
    double largest_change_n = 0.0;
    std::uint64_t lost = 0;
    ChainStage::Outputs felt;
    for (int n = 0; n < 2500; ++n) {
      const auto serial = static_cast<std::uint32_t>(n / 33 + 1);
      if (n % 33 == 0 && serial <= kShapes) {
        const ShapeStart start = shape_start(scene, serial, static_cast<std::int64_t>(1e9 * stage.time_s()) + 2'000'000);
        ASSERT_TRUE(stage.deform(start, wave_of(scene, static_cast<int>(serial))));
        const bool is_lost = serial != kShapes && random() % 3 == 0;
        lost += is_lost ? 1 : 0;
        if (!is_lost) on_their_way.emplace_back(n + static_cast<int>(random() % 200), serial);
      }
      for (const auto& [arrival, one] : on_their_way) {
        if (arrival == n)
          stage.announce(shape_start(scene, one, static_cast<std::int64_t>(33'000'000) * (one - 1) + 2'000'000),
                         wave_of(scene, static_cast<int>(one)));
      }
      const double down = std::min(1.0, n / 200.0);
      felt = stage.step(Vec3(0.003, 0.002, 0.02) + down * Vec3(0, 0, resting_hand.z() - 0.02));
      ASSERT_TRUE(felt.patch.has_value()) << n;
      const double force_n = felt.patch->force_n.norm();
      if (n > 250) largest_change_n = std::max(largest_change_n, std::abs(force_n - last_n));
      last_n = force_n;
    }
    EXPECT_LT((felt.patch->force_n - felt.whole.force_n).norm(), 1e-9) << seed;
    EXPECT_GT(felt.whole.force_n.norm(), 0.5);
    // The hand holds still. The surface moves at kMaxSurfaceSpeed at most, and the slope of its facets is less than 0.5.
    EXPECT_LT(largest_change_n, 800.0 * kMaxSurfaceSpeed * ChainStage::kStepS * 1.5) << seed;
    EXPECT_GT(stage.chain().counts().late_shapes, 5U) << seed;
    EXPECT_GT(lost, 5U);
  }
}

bool is_of_skin(const Message& part) {
  if (const auto* tile = std::get_if<PatchTile>(&part)) return tile->object == 1;
  return std::holds_alternative<PatchStream>(part);
}

TEST(StreamedPatch, IsKnownWhenAllPartsAndItsShapeHaveCome) {
  const TouchScene scene = skin_on_floor();
  std::vector<Message> parts = parts_of(make_tiles(scene));
  std::mt19937_64 random(60);
  std::shuffle(parts.begin(), parts.end(), random);
  std::stable_partition(parts.begin(), parts.end(), [](const Message& part) { return !is_of_skin(part); });
  PatchStore store;
  const Vec3 above(0.0, 0.0, 0.03);
  int streams = 0;
  for (Message& part : parts) {
    if (is_of_skin(part)) {
      EXPECT_TRUE(store.make_piece(above, 1.0, 100, 1).scene.objects.empty());
      EXPECT_NEAR(store.known_radius(above, 1), 0.03 - 0.007 - kStreamReachM, 1e-5) << "no shape is nearer";
    }
    if (auto* stream = std::get_if<PatchStream>(&part)) {
      ++streams;
      stream->shape_serial = streams == 3 ? 7 : 2;
    }
    for (int repeat = 0; repeat < 2; ++repeat) EXPECT_TRUE(store.accept_part(part));
  }
  ASSERT_GT(streams, 10);
  EXPECT_FALSE(std::isinf(store.known_radius(above, 1))) << "it has had a shape, and none has come";

  const auto announce = [&](std::uint32_t serial, bool has_shape) {
    const ChainStage::Shape shape = wave_of(scene, 1);
    for (std::uint32_t first = 0; has_shape && first < shape.size(); first += ShapePart::kVerticesPerPart) {
      (void)store.accept_shape(ObjectShape{.source = 5, .serial = serial, .object = 1, .part = make_shape_part(shape, first)},
                               Arrival::newest);
    }
    EXPECT_TRUE(store.accept_shape(shape_start(scene, serial, 0), Arrival::newest));
  };
  announce(6, true);
  EXPECT_FALSE(std::isinf(store.known_radius(above, 1))) << "an older one than it has";
  announce(7, false);
  EXPECT_FALSE(std::isinf(store.known_radius(above, 1))) << "its vertices have not come";
  EXPECT_FALSE(store.take_shape_request(1));
  const auto request = store.take_shape_request(1'000'000'000);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->serial, 7U);
  announce(7, true);
  EXPECT_TRUE(std::isinf(store.known_radius(above, 1)));
  const PatchStore::Piece piece = store.make_piece(above, 1.0, 1, 1);
  ASSERT_EQ(piece.scene.objects.size(), 1U);
  EXPECT_EQ(piece.scene.objects[0].mesh->triangles.size(), 2U * 24 * 24);
  EXPECT_EQ(piece.scene.objects[0].stream_reach_m, kStreamReachM);
  EXPECT_EQ(store.counts().rejected, 0U);
}

TEST(StreamedPatch, IsKnownInWhateverOrderItsPartsCome) {
  expect_known_whichever_is_last<PatchBegin, PatchBody, PatchTile, PatchStream>(make_tiles(skin_on_floor()), 1);
}

// Each vertex of the joined mesh moves as the scene's vertex with the same position at rest does, turned and scaled as in the scene file.
TEST(StreamedPatch, HasTheShapesOfTheScene) {
  TouchScene scene = skin_on_floor();
  scene.objects[1].stream_to_scene = 0.5 * Quat(Eigen::AngleAxisd(0.3, Vec3::UnitX())).toRotationMatrix();
  PatchStore store;
  for (const Message& part : parts_of(make_tiles(scene))) (void)store.accept_part(part);
  const PatchStore::Piece piece = store.make_piece(Vec3::Zero(), 1.0, 1, 1);
  ASSERT_EQ(piece.scene.objects.size(), 1U);
  const ChainStage::Shape shape = wave_of(scene, 3);
  const std::vector<Vec3>& rest = piece.scene.objects[0].mesh->vertices;
  const std::vector<Vec3> vertices = store.find_stream(1)->vertices_at(rest, shape);
  const std::vector<Vec3>& scene_vertices = scene.objects[1].mesh->vertices;
  ASSERT_EQ(vertices.size(), scene_vertices.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const auto same = std::find(scene_vertices.begin(), scene_vertices.end(), rest[v]);
    ASSERT_NE(same, scene_vertices.end());
    const auto& by = shape[static_cast<std::size_t>(same - scene_vertices.begin())];
    EXPECT_EQ(vertices[v], rest[v] + scene.objects[1].stream_to_scene * Vec3(by[0], by[1], by[2]));
  }
}

TEST(StreamedPatch, WhatCannotBeFeltOnTheGridIsNoticed) {
  EXPECT_TRUE(can_feel_what_deforms(make_tiles(skin_on_floor()), 0.0));
  EXPECT_FALSE(can_feel_what_deforms(make_tiles(skin_on_floor()), 0.001)) << "a ball cannot feel what deforms";
  TouchScene finned = skin_on_floor();
  TriangleMesh finned_mesh = *finned.objects[1].mesh;
  // An inner edge of the sheet gets a third triangle.
  const Triangle inner = finned_mesh.triangles[24 * 24 + 24];
  finned_mesh.vertices.emplace_back(0.0, 0.0, 0.03);
  finned_mesh.triangles.push_back({inner[0], inner[1], static_cast<std::uint32_t>(finned_mesh.vertices.size() - 1)});
  finned.objects[1].mesh = made::shared(std::move(finned_mesh));
  EXPECT_FALSE(can_feel_what_deforms(make_tiles(finned), 0.0)) << "an edge of three triangles is not walkable";
  TouchScene torn = skin_on_floor();
  TriangleMesh mesh = *torn.objects[1].mesh;
  // One triangle gets corners of its own. Below, one of them is less than a step of the grid away from the old corner.
  const Triangle corners = mesh.triangles[0];
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const std::uint32_t corner : corners) mesh.vertices.push_back(mesh.vertices[corner]);
  mesh.triangles[0] = {first, first + 1, first + 2};
  torn.objects[1].mesh = made::shared(mesh);
  EXPECT_FALSE(make_tiles(torn).comes_apart) << "at the same place, they count as one";
  mesh.vertices[first].x() += 0.1 * make_tiles(torn).grid.step_m;
  torn.objects[1].mesh = made::shared(mesh);
  EXPECT_TRUE(make_tiles(torn).comes_apart);
}

TEST(StreamedPatch, TheStepsUseNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  const TouchScene scene = skin_on_floor(0.5);
  ChainStage stage(scene);
  for (int n = 0; n < 200; ++n) (void)stage.step(Vec3(0.003, 0.002, std::max(0.0045, 0.02 - 1e-4 * n)));
  for (std::uint32_t serial = 1; serial <= 6; ++serial) {
    stage.announce(shape_start(scene, serial, 150'000'000 + serial * kShapePeriodNs), wave_of(scene, static_cast<int>(serial)));
  }
  (void)stage.step(Vec3(0.003, 0.002, 0.0045));
  std::uint64_t allocations = 0;
  int in_contact = 0;
  for (int n = 0; n < 300; ++n) {
    const TouchInput input{.p_WD = Vec3(0.003 + 1e-5 * n, 0.002, 0.0045), .dt_s = 1e-3, .time_s = 0.202 + 1e-3 * n};
    const AllocationGuard guard;
    const auto output = stage.chain().step(input);
    allocations += guard.count();
    ASSERT_TRUE(output) << n;
    in_contact += output->contact ? 1 : 0;
  }
  EXPECT_EQ(allocations, 0U);
  EXPECT_GT(in_contact, 100);
  EXPECT_EQ(stage.chain().counts().shapes, 6U);
}

// A hostile haptics node may send such parts.
TEST(StreamedPatch, WhatContradictsItselfIsNeverConfirmed) {
  const TiledScene tiled = make_tiles(skin_on_floor());
  const auto expect_rejected = [&](auto&& change) {
    PatchStore store;
    for (Message part : parts_of(tiled)) {
      if (auto* stream = std::get_if<PatchStream>(&part)) change(*stream);
      (void)store.accept_part(part);
    }
    EXPECT_GT(store.counts().rejected, 0U);
    EXPECT_TRUE(store.make_piece(Vec3::Zero(), 1.0, 1, 1).scene.objects.empty());
  };
  expect_rejected([](PatchStream& stream) { stream.reach_m = 1.0; });
  expect_rejected([](PatchStream& stream) { stream.vertex_count = static_cast<std::uint8_t>(stream.vertex_count - 1); });
  expect_rejected([](PatchStream& stream) { stream.tile_count = PatchStore::kMaxTiles + 1; });
  int n = 0;
  expect_rejected([&](PatchStream& stream) { stream.total += ++n == 4 ? 1 : 0; });
  n = 0;
  expect_rejected([&](PatchStream& stream) { stream.object += ++n == 4 ? 1 : 0; });
}

// The shapes of an object belong to one body, and have as many vertices as that body.
TEST(StreamedPatch, NoOtherBodyTakesTheShapesOfAnObject) {
  const TouchScene scene = skin_on_floor();
  PatchStore store;
  PatchStream stream;
  for (const Message& part : parts_of(make_tiles(scene))) {
    (void)store.accept_part(part);
    if (const auto* one = std::get_if<PatchStream>(&part)) stream = *one;
  }
  const std::uint64_t rejected = store.counts().rejected;
  stream.body = 2;
  stream.total = 1;
  stream.vertices = {};
  store.accept(stream);
  EXPECT_EQ(store.counts().rejected, rejected + 1);
  (void)store.accept_shape(shape_start(scene, 1, 0), Arrival::newest);
  EXPECT_NE(store.shapes().newest_start(1), nullptr) << "of the body that there is";
}

// A motion waits for its patch, and for room there. The motion of a patch that was replaced is dropped: it would hold up all later ones.
TEST(StreamedPatch, AMotionWaitsForItsPatchAndEndsWithIt) {
  PatchTouch touch;
  auto method = StreamedMethod::make({}, made::shared(made::sheet(0.02, 0.0, 8)), Material(), kStreamReachM);
  ASSERT_TRUE(method) << method.error().what;
  StreamedMethod& streamed = **method;
  auto patch = std::make_unique<Patch>();
  patch->step = std::make_unique<TouchStep>(std::move(*method));
  patch->radius_m = std::numeric_limits<double>::infinity();
  patch->deforms = true;
  patch->streamed = &streamed;
  patch->number = 2;
  const auto motion = [&](std::uint32_t of_patch, std::int64_t start_s) {
    return PatchShape{streamed.stager().make_rest(), of_patch, 1'000'000'000 * start_s, 1'000'000'000 * start_s + 100'000'000};
  };
  PatchShape early = motion(2, 1);
  EXPECT_FALSE(touch.take(early)) << "there is no patch";
  (void)touch.offer(std::move(patch));
  PatchShape next = motion(3, 1);
  EXPECT_FALSE(touch.take(next)) << "its patch is not here yet";
  EXPECT_NE(next.stage, nullptr);
  PatchShape old = motion(1, 1);
  EXPECT_TRUE(touch.take(old)) << "its patch is gone";
  EXPECT_EQ(touch.counts().shapes, 0U);
  for (std::size_t n = 0; n < StreamedMethod::kMaxWaiting; ++n) {
    PatchShape one = motion(2, static_cast<std::int64_t>(n) + 1);
    EXPECT_TRUE(touch.take(one)) << n;
  }
  PatchShape more = motion(2, 100);
  EXPECT_FALSE(touch.take(more)) << "there is no room";
  EXPECT_NE(more.stage, nullptr);
  EXPECT_EQ(touch.counts().shapes, StreamedMethod::kMaxWaiting);
  EXPECT_EQ(touch.counts().late_shapes, 0U);
}

}  // namespace
}  // namespace hapton
