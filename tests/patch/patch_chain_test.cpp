// Compares touch of a scene that moves, by patches of its bodies, with touch of the whole scene.
#include "patch/patch_chain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/math/commanded_motion.h"
#include "patch/patch_source.h"
#include "tests/patch/chain_stage.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr double kChainStiffness = 1000.0;
constexpr std::int32_t kPlatform = 2;

Material chain_material(double friction = 0.0) {
  return {.stiffness_n_per_m = kChainStiffness, .friction_static = friction, .friction_dynamic = 0.8 * friction};
}

TouchObject chain_object(TriangleMesh mesh, double friction = 0.0) { return {made::shared(std::move(mesh)), chain_material(friction)}; }

// A floor; a piston that comes up through it, turns and goes down again and again; a platform that programs move.
TouchScene machine(double friction = 0.0) {
  TouchScene scene;
  scene.objects.push_back(chain_object(made::sheet(0.05, 0.0, 30), friction));
  TouchObject piston = chain_object(made::box(Vec3(-0.012, -0.011, -0.02), Vec3(0.011, 0.012, 0.001)), friction);
  const Quat turned(Eigen::AngleAxisd(0.3, Vec3(0.1, 0.2, 1.0).normalized()));
  piston.motion = std::make_shared<const KeyframeMotion>(
      Vec3(0.0, 0.0, 0.0),
      std::vector<Keyframe>{
          {0.0, Vec3(0, 0, 0), Quat::Identity()}, {0.2, Vec3(0, 0, 0.012), turned}, {0.5, Vec3(0, 0, 0), Quat::Identity()}},
      true);
  scene.objects.push_back(piston);
  TouchObject platform = chain_object(made::box(Vec3(0.02, -0.01, 0.001), Vec3(0.04, 0.01, 0.006)), friction);
  platform.command_pivot = Vec3(0.03, 0.0, 0.003);
  scene.objects.push_back(platform);
  return on_patch_grid(scene);
}

ObjectMove platform_move(std::uint32_t serial, double begin_s, double end_s, const Keyframe& from, const Vec3& to, double turn = 0.0) {
  ObjectMove move{.source = 9, .serial = serial, .object = kPlatform};
  move.start_ns = std::llround(1e9 * begin_s);
  move.end_ns = std::llround(1e9 * end_s);
  move.from_p_m = from.p_S;
  move.from_q = from.turn;
  move.to_p_m = to;
  move.to_q = Quat(Eigen::AngleAxisd(turn, Vec3::UnitY()));
  return move;
}

// Over the piston, then over the floor, then on the platform. The hand presses in and moves sideways.
Vec3 chain_hand(double t_s) {
  const double press = std::clamp((t_s - 0.05) / 0.2, 0.0, 1.0);
  const double over = std::clamp((t_s - 1.5) / 1.0, 0.0, 1.0);
  const double x = 0.004 * std::sin(3.0 * t_s) + 0.03 * over;
  return {x, 0.003 * std::cos(4.0 * t_s), 0.006 - 0.008 * press + 0.004 * over};
}

struct Comparison {
  double worst_share = 0.0;  // |patch - whole| / |whole|, of steps with a force
  double largest_n = 0.0;
  int contact_steps = 0;
  int steps_on_object[3] = {};
};

void compare(const ChainStage::Outputs& felt, Comparison& comparison) {
  ASSERT_TRUE(felt.patch.has_value());
  ASSERT_EQ(felt.patch->contact, felt.whole.contact);
  if (!felt.whole.contact) return;
  ++comparison.contact_steps;
  ASSERT_EQ(felt.patch->object, felt.whole.object);
  if (felt.whole.object >= 0) ++comparison.steps_on_object[felt.whole.object];
  const double whole_n = felt.whole.force_n.norm();
  comparison.largest_n = std::max(comparison.largest_n, whole_n);
  const double error_n = (felt.patch->force_n - felt.whole.force_n).norm();
  // A force that is only rounding of a coordinate, times the stiffness, has no relative accuracy.
  comparison.worst_share = std::max(comparison.worst_share, error_n / std::max(whole_n, 1e-3));
}

TEST(PatchChain, GivesTheForceOfTheHapticsNodesStepOnAnIdealLink) {
  for (const double friction : {0.0, 0.5}) {
    ChainStage stage(machine(friction));
    Comparison comparison;
    Keyframe start{0.0, Vec3(0.03, 0.0, 0.003), Quat::Identity()};
    for (int n = 1; n < 6000; ++n) {
      if (n % 700 == 400) {
        // The move is announced 0.1 s before it begins.
        const double begin_s = stage.time_s() + 0.1;
        const Vec3 to = Vec3(0.03, 0.0, 0.003) + Vec3(0.002, 0.001, n % 1400 == 400 ? 0.006 : 0.0);
        start = stage.find_commanded(kPlatform)->keyframe_at(begin_s);
        const ObjectMove move =
            platform_move(static_cast<std::uint32_t>(n), begin_s, begin_s + 0.3, start, to, n % 1400 == 400 ? 0.2 : 0.0);
        ASSERT_TRUE(stage.decide(move));
        stage.announce(move);
      }
      ASSERT_NO_FATAL_FAILURE(compare(stage.step(chain_hand(stage.time_s())), comparison)) << n;
    }
    // Parts agree to 2^-26 of the longest share of them (CommonProxy).
    // With friction a part that is close to that limit may be felt once more or once less than in the whole scene.
    EXPECT_LT(comparison.worst_share, friction == 0.0 ? 1e-9 : 0x1p-26) << friction;
    EXPECT_GT(comparison.contact_steps, 3000);
    EXPECT_GT(comparison.steps_on_object[0], 40);
    EXPECT_GT(comparison.steps_on_object[1], 300);
    EXPECT_GT(comparison.steps_on_object[2], 300);
    EXPECT_GT(comparison.largest_n, 3.0);
    EXPECT_EQ(stage.chain().late_moves(), 0U);
    EXPECT_EQ(stage.chain().counts().handed_over, 3U) << "one patch of each body, however often the probe goes from one to the next";
  }
}

// The same holds if a view transform turns the scene.
TEST(PatchChain, IsFeltAlikeInATurnedView) {
  ChainStage stage(machine());
  Comparison comparison;
  Pose X_WS = Pose::Identity();
  X_WS.linear() = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  X_WS.translation() = Vec3(0.1, -0.2, 0.05);
  for (int n = 1; n < 2000; ++n) ASSERT_NO_FATAL_FAILURE(compare(stage.step(X_WS * chain_hand(stage.time_s()), X_WS), comparison)) << n;
  EXPECT_LT(comparison.worst_share, 1e-9);
  EXPECT_GT(comparison.contact_steps, 1000);
}

// Patches of few triangles: each body passes from one patch to the next in its own frame, while it moves. The proxy starts again from its
// old position, so at most a difference of the contact offset is left.
TEST(PatchChain, PatchesThatFollowTheHandGiveTheSameForce) {
  TouchScene scene = machine();
  scene.objects[0].mesh = made::shared(made::sheet(0.05, 0.0, 60));
  scene = on_patch_grid(scene);
  ChainStage stage(scene, 256);
  Comparison comparison;
  for (int n = 1; n < 2000; ++n) ASSERT_NO_FATAL_FAILURE(compare(stage.step(chain_hand(stage.time_s())), comparison)) << n;
  EXPECT_GT(stage.chain().counts().handed_over, 5U);
  EXPECT_LT(comparison.worst_share, 1e-6);
  EXPECT_GT(comparison.contact_steps, 800);
}

// No new patch comes, and the hand goes past the edge of the present one.
TEST(PatchChain, CountsWhatItsBodiesCount) {
  TouchScene scene = machine();
  scene.objects[0].mesh = made::shared(made::sheet(0.05, 0.0, 60));
  scene = on_patch_grid(scene);
  ChainStage stage(scene, 256);
  for (int n = 1; n < 50; ++n) (void)stage.step({0.03, -0.03, std::max(0.001 - 0.0001 * n, -0.001)});
  EXPECT_EQ(stage.chain().counts().beyond, 0U);
  EXPECT_GT(stage.chain().counts().contact_steps, 0U);
  for (int n = 1; n < 60; ++n) (void)stage.step({0.03 - 0.001 * n, -0.03, -0.001}, Pose::Identity(), false);
  EXPECT_EQ(stage.chain().counts().beyond, 1U);
  EXPECT_GT(stage.chain().counts().beyond_steps, 10U);
  // When new patches come, the proxy follows the path that the hand has taken meanwhile.
  const std::uint64_t before = stage.chain().counts().followed;
  for (int n = 1; n < 60; ++n) (void)stage.step({-0.029, -0.03, -0.001});
  EXPECT_GT(stage.chain().counts().followed, before);
  EXPECT_LT(stage.chain().counts().followed, 200U);
}

// Each move reaches the hub up to half a second after it began, and maybe in another order. The surface under the hand never jumps, and
// at rest it is where the whole scene has it.
TEST(PatchChain, AMoveThatComesLateMovesTheSurfaceWithoutAJump) {
  ChainStage stage(machine());
  std::mt19937_64 random(5);
  std::uniform_int_distribution<int> delay_steps(0, 500);
  std::vector<std::pair<int, ObjectMove>> moves_under_way;
  double worst_jump_n = 0.0;
  double largest_n = 0.0;
  Vec3 last_force_n = Vec3::Zero();
  const auto hand = [](double t_s) { return Vec3(0.03, 0.001, t_s < 0.3 ? 0.008 - 0.004 * t_s / 0.3 : 0.004); };
  for (int n = 1; n < 9000; ++n) {
    if (n % 400 == 350 && n < 7000) {
      const double begin_s = stage.time_s();
      const Keyframe at = stage.find_commanded(kPlatform)->keyframe_at(begin_s);
      const Vec3 to = Vec3(0.03, 0.0, 0.003 + 0.004 * static_cast<double>(n % 3) / 2.0);
      const ObjectMove move = platform_move(static_cast<std::uint32_t>(n), begin_s, begin_s + 0.1, at, to);
      ASSERT_TRUE(stage.decide(move));
      moves_under_way.emplace_back(n + delay_steps(random), move);
    }
    for (const auto& [due_step, move] : moves_under_way) {
      if (due_step == n) stage.announce(move);
    }
    const auto felt = stage.step(hand(stage.time_s()));
    ASSERT_TRUE(felt.patch.has_value());
    if (n > 400) worst_jump_n = std::max(worst_jump_n, (felt.patch->force_n - last_force_n).norm());
    largest_n = std::max(largest_n, felt.patch->force_n.norm());
    last_force_n = felt.patch->force_n;
    if (n > 8500) {
      EXPECT_NEAR((felt.patch->force_n - felt.whole.force_n).norm(), 0.0, 1e-9);
    }
  }
  EXPECT_GT(stage.chain().late_moves(), 10U);
  EXPECT_GT(largest_n, 1.0);
  EXPECT_LE(worst_jump_n, kChainStiffness * kMaxSurfaceSpeed * ChainStage::kStepS * (1.0 + 1e-6)) << "the largest speed of a surface";
}

// Moves of an unknown object, to turns that are not unit quaternions, to positions far away, at any time: all forces stay finite.
TEST(PatchChain, AbsurdMovesGiveFiniteForces) {
  ChainStage stage(machine());
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> any(-1e6, 1e6);
  int steps_with_patch = 0;
  int contact_steps = 0;
  for (std::uint32_t n = 1; n < 3000; ++n) {
    if (n % 10 == 0) {
      ObjectMove move{.source = 9, .serial = n, .object = n % 50 == 0 ? 7 : kPlatform};
      move.start_ns = static_cast<std::int64_t>(random() >> (1 + n % 60));
      move.end_ns = static_cast<std::int64_t>(static_cast<std::uint64_t>(move.start_ns) + (random() >> (2 + n % 60)));
      if (move.end_ns < move.start_ns) move.end_ns = move.start_ns;
      move.from_p_m = Vec3(any(random), any(random), any(random));
      move.to_p_m = n % 20 == 0 ? Vec3(any(random), any(random), any(random)) : Vec3(0.03, 0.0, 0.003);
      move.to_q = n % 30 == 0 ? Quat(2.0, 0.0, 0.0, 0.0) : Quat::Identity();
      stage.announce(move);
    }
    const auto felt = stage.step(chain_hand(1e-3 * n));
    if (felt.patch) {
      ASSERT_TRUE(felt.patch->force_n.allFinite()) << n;
      ASSERT_TRUE(felt.patch->visual_offset_m.allFinite()) << n;
      ++steps_with_patch;
      contact_steps += felt.patch->contact ? 1 : 0;
    }
  }
  EXPECT_GT(steps_with_patch, 2000);
  EXPECT_GT(contact_steps, 1000);
  EXPECT_GT(stage.chain().late_moves(), 100U) << "the moves of the platform take effect";
}

// A move that was decided before the patches began has to be known before anything is felt.
TEST(PatchChain, NothingIsFeltBeforeItIsKnownWhereEverythingIs) {
  const TouchScene scene = machine();
  PatchSource source(make_tiles(scene), 0.0, 7, 1, {.bits_per_s = 1e15, .least_reach_m = 1e3});
  const Keyframe rest{0.0, Vec3(0.03, 0.0, 0.003), Quat::Identity()};
  const ObjectMove early_move = platform_move(5, 0.0, 0.1, rest, Vec3(0.03, 0.0, 0.013));
  source.note_move(early_move, -1);
  PatchStore store;
  bool has_move = false;
  for (std::int64_t now_ns = 1'000'000'000; now_ns < 1'100'000'000; now_ns += 1'000'000) {
    while (auto part = source.take(now_ns)) {
      const bool is_part = store.accept_part(*part);
      has_move = has_move || !is_part;
    }
  }
  EXPECT_TRUE(has_move) << "it is sent with the parts";
  PatchChain chain;
  (void)chain.take(store.make_bodies(0));
  std::vector<PatchMaker> makers;
  for (std::uint32_t body = 0; body < 3; ++body) makers.emplace_back(PatchMaker::kFewTriangles, body);
  const TouchInput above{.p_WD = Vec3(0.03, 0.0, 0.02), .dt_s = 1e-3, .time_s = 1.0};
  (void)chain.step(above);
  for (std::size_t b = 0; b < makers.size(); ++b) {
    makers[b].note_hand(chain.hand_of(b, 1));
    auto patch = makers[b].make_if_due(store, 0);
    ASSERT_NE(patch, nullptr) << b;
    (void)chain.offer(b, std::move(patch));
  }
  EXPECT_FALSE(chain.step(above).has_value());
  MoveTable moves;
  (void)moves.take(early_move);
  chain.note_moves(moves);
  ASSERT_TRUE(chain.step(above).has_value());
  TouchInput input = above;
  for (int n = 0; n < 100; ++n) {
    input.p_WD.z() -= 5e-5;
    input.time_s += 1e-3;
    (void)chain.step(input);
  }
  const auto felt = chain.step(input);
  ASSERT_TRUE(felt && felt->contact);
  EXPECT_EQ(felt->object, kPlatform);
  EXPECT_NEAR(felt->force_n.z(), kChainStiffness * (0.016 - 0.015), 0.05) << "10 mm above where it was";
}

// The first patches take over where the haptics node has the proxy, in the frame of the body that moves.
TEST(PatchChain, TakesOverWhereTheProbeWas) {
  const TouchScene scene = machine();
  ChainStage remote(scene);
  std::vector<TouchOutput> whole_outputs;
  std::vector<Vec3> hands;
  constexpr int kAgeSteps = 100;
  for (int n = 0; n < 800; ++n) {
    hands.push_back(chain_hand(remote.time_s()));
    whole_outputs.push_back(remote.step(hands.back()).whole);
  }
  ChainStage stage(scene);
  PatchChain& chain = stage.chain();
  TouchInput input{.dt_s = 1e-3};
  for (int n = 0; n < 800; ++n) {
    input.p_WD = hands[static_cast<std::size_t>(n)];
    input.time_s = 1e-3 * (n + 1);
    if (n == 700) {
      const auto old_step = static_cast<std::size_t>(n - 1 - kAgeSteps);
      ASSERT_TRUE(whole_outputs[old_step].contact);
      chain.start_at(hands[old_step] + whole_outputs[old_step].visual_offset_m, whole_outputs[old_step].visual_offset_m.normalized(),
                     1e-3 * kAgeSteps, 1e-3 * (n - kAgeSteps));
      for (std::uint32_t body = 0; body < 3; ++body) {
        PatchMaker maker(PatchMaker::kFewTriangles, body);
        maker.note_hand(chain.hand_of(body, 1));
        (void)chain.offer(body, maker.make_if_due(stage.store(), 0));
      }
    }
    const auto felt = chain.step(input);
    // The proxy follows the positions of the hand since then, a few in each step.
    if (n < 700 || n >= 700 + kAgeSteps / PatchTouch::kMaxFollowed) {
      ASSERT_EQ(felt.has_value(), n >= 700) << n;
    }
    if (!felt) continue;
    EXPECT_NEAR((felt->force_n - whole_outputs[static_cast<std::size_t>(n)].force_n).norm(), 0.0, 1e-6) << n;
  }
}

// start_at() says where the proxy is before any body is known. The bodies then begin there, and a hand that is pressed in keeps its force.
// The same holds if the bodies come again, after other bodies have held the hand.
TEST(PatchChain, BodiesThatComeLaterBeginWhereTheProbeIs) {
  const TouchScene scene = machine();
  ChainStage remote(scene);
  ChainStage stage(scene);
  PatchChain chain;
  TouchInput input{.dt_s = 1e-3};
  TouchOutput whole;
  const auto next = [&] {
    input.p_WD = chain_hand(remote.time_s());
    whole = remote.step(input.p_WD).whole;
    input.time_s += 1e-3;
    return chain.step(input);
  };
  for (int n = 0; n < 700; ++n) EXPECT_FALSE(next()) << n;
  ASSERT_EQ(whole.object, 1) << "on the piston";
  chain.start_at(input.p_WD + whole.visual_offset_m, whole.visual_offset_m.normalized(), 0.0, input.time_s);
  for (int n = 0; n < 5; ++n) EXPECT_FALSE(next()) << n;
  for (int again = 0; again < 2; ++again) {
    (void)chain.take(stage.store().make_bodies(0));
    for (std::uint32_t body = 0; body < 3; ++body) {
      PatchMaker maker(PatchMaker::kFewTriangles, body);
      maker.note_hand(chain.hand_of(body, 1));
      (void)chain.offer(body, maker.make_if_due(stage.store(), 0));
    }
    for (int n = 0; n < 20; ++n) {
      const auto felt = next();
      ASSERT_TRUE(felt) << n;
      ASSERT_TRUE(felt->contact) << again << " " << n;
      EXPECT_NEAR((felt->force_n - whole.force_n).norm(), 0.0, 1e-6) << again << " " << n;
    }
    for (std::size_t link = 0; link < PatchChain::kLinks; ++link) (void)chain.take_retired(link);
  }
}

TEST(PatchChain, StepsUseNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  ChainStage stage(machine(0.5));
  for (int n = 0; n < 500; ++n) (void)stage.step(chain_hand(stage.time_s()));
  MoveTable moves;
  (void)moves.take(platform_move(3, 0.5, 0.6, {0.0, Vec3(0.03, 0.0, 0.003), Quat::Identity()}, Vec3(0.03, 0.0, 0.013)));
  TouchInput input{.dt_s = 1e-3, .time_s = stage.time_s()};
  const AllocationGuard guard;
  for (int n = 0; n < 1000; ++n) {
    input.time_s += 1e-3;
    input.p_WD = chain_hand(input.time_s);
    (void)stage.chain().step(input);
    if (n == 300) stage.chain().note_moves(moves);
  }
  EXPECT_EQ(guard.count(), 0U);
}

// A material from `hapton set` is used from the next step on. That step sets is_handed_over, so that the difference fades.
TEST(PatchChain, OtherMaterialsAreUsedFromTheNextStepOn) {
  ChainStage stage(machine());
  const Vec3 pressed(-0.03, 0.0, -0.002);
  for (int n = 0; n < 400; ++n) (void)stage.step(Vec3(-0.03, 0.0, 0.002 - 1e-5 * n));
  auto felt = stage.step(pressed);
  EXPECT_NEAR(felt.patch->force_n.z(), 2.0, 1e-6);
  PatchMaterial softer{.epoch = 1, .serial = 1'000'000, .object = 0, .stiffness_n_per_m = 300.0};
  stage.store().accept(softer);
  ASSERT_EQ(stage.store().materials().size(), 1U);
  auto materials = std::make_unique<PatchMaterials>();
  materials->version = stage.store().material_version();
  materials->objects.emplace_back(0, stage.store().materials().at(0));
  (void)stage.chain().take(std::move(materials));
  felt = stage.step(pressed);
  EXPECT_NEAR(felt.patch->force_n.z(), 0.6, 1e-6);
  EXPECT_TRUE(felt.patch->is_handed_over) << "the device loop fades the difference";
  felt = stage.step(pressed);
  EXPECT_FALSE(felt.patch->is_handed_over);
  // An older material that arrives late changes nothing.
  softer.serial = 999'999;
  softer.stiffness_n_per_m = 5.0;
  stage.store().accept(softer);
  EXPECT_EQ(stage.store().materials().at(0).stiffness_n_per_m, 300.0);
  EXPECT_EQ(stage.store().make_piece(pressed, 1.0, 100'000).scene.objects.at(0).material.stiffness_n_per_m, 300.0);
}

TEST(PatchChain, CountsEachMoveThatComesLateOnce) {
  ChainStage stage(machine());
  for (int n = 0; n < 300; ++n) (void)stage.step(chain_hand(stage.time_s()));
  ASSERT_TRUE(stage.chain().has_arrived());
  for (std::uint32_t serial = 1; serial <= 3; ++serial) {
    const double begin_s = stage.time_s() - 0.05;
    const Keyframe at = stage.find_commanded(kPlatform)->keyframe_at(begin_s);
    stage.announce(platform_move(serial, begin_s, begin_s + 0.3, at, Vec3(0.03, 0.0, 0.003 + 0.001 * serial)));
    EXPECT_EQ(stage.chain().late_moves(), serial);
    EXPECT_EQ(stage.chain().counts().late_moves, serial);
  }
}

TEST(PatchChain, HasRoomForAsManyBodiesAsAreAnnounced) {
  const auto chain = std::make_unique<PatchChain>();
  auto bodies = std::make_unique<PatchBodies>();
  bodies->extent_m = 0.1;
  bodies->bodies.resize(PatchChain::kLinks);
  for (std::size_t b = 1; b < PatchChain::kLinks; ++b) {
    bodies->bodies[b] = {.is_commanded = true, .object = static_cast<std::int32_t>(b), .radius_m = 0.01};
  }
  EXPECT_EQ(chain->take(std::move(bodies)), nullptr);
  chain->start_at(Vec3(0, 0, 0.01), Vec3::UnitZ(), 0.0, 0.0);
  EXPECT_EQ(chain->body_count(), PatchChain::kLinks);
  EXPECT_FALSE(chain->step({.p_WD = Vec3(0, 0, 0.01), .dt_s = 1e-3, .time_s = 1e-3})) << "no patch has come";
  EXPECT_EQ(chain->hand_of(PatchChain::kLinks - 1, 0).p_SD, Vec3(0, 0, 0.01));
  EXPECT_EQ(chain->take(std::make_unique<PatchBodies>(PatchBodies{.bodies = {{}}}))->bodies.size(), PatchChain::kLinks);
}

// A scene that stands still is replaced by one in which something moves. Its bodies begin where the hand is now, not where the hand was
// when the first patches began.
TEST(PatchChain, BodiesOfANewSceneBeginWhereTheHandIs) {
  TouchScene still;
  still.objects.push_back(chain_object(made::sheet(0.05, 0.0, 30)));
  ChainStage first(on_patch_grid(still));
  PatchChain& chain = first.chain();
  TouchInput input{.p_WD = Vec3(0, 0, 0.02), .dt_s = 1e-3};
  chain.start_at(input.p_WD, Vec3::Zero(), 0.0, 0.0);
  const auto step = [&] {
    input.time_s += 1e-3;
    return chain.step(input);
  };
  PatchMaker maker;
  maker.note_hand(chain.hand_of(0, 1));
  (void)chain.offer(0, maker.make_if_due(first.store(), 0));
  for (int n = 0; n < 100; ++n) {
    input.p_WD = Vec3(0.0004 * n, 0, 0.02);
    ASSERT_TRUE(step()) << n;
  }
  // A wall between the first and the present position of the hand, from below the hand's height to above it.
  TouchScene moving = still;
  TouchObject wall = chain_object(made::box(Vec3(0.018, -0.02, 0.001), Vec3(0.022, 0.02, 0.04)));
  wall.command_pivot = Vec3(0.02, 0, 0);
  moving.objects.push_back(wall);
  ChainStage second(on_patch_grid(moving));
  chain.set_generation(1);
  (void)step();
  auto bodies = second.store().make_bodies(1);
  (void)chain.take(std::move(bodies));
  for (std::uint32_t body = 0; body < 2; ++body) {
    PatchMaker next(PatchMaker::kFewTriangles, body);
    next.note_hand(chain.hand_of(body, 1));
    (void)chain.take_retired(body);
    (void)chain.offer(body, next.make_if_due(second.store(), 1));
  }
  int felt_steps = 0;
  for (int n = 0; n < 20; ++n) {
    const auto felt = step();
    if (!felt) continue;
    ++felt_steps;
    EXPECT_FALSE(felt->contact) << n;
  }
  EXPECT_GT(felt_steps, 0);
}

}  // namespace
}  // namespace hapton
