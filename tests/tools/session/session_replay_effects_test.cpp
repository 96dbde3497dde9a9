// Replays of sessions with surfaces that move or deform and have effects.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "core/force/streamed_method.h"
#include "link/commanded_move.h"
#include "tests/core/effects/made_textures.h"
#include "tests/tools/session/session_replay_fixture.h"

namespace hapton {
namespace {

TouchScene sphere_with_rich_effects(bool has_snap) {
  static const auto models = made::texture(1000.0, 20, 18);
  TouchScene scene = one_sphere();
  scene.objects[0].effects = {.progressive = {.n_per_m2 = 1e5},
                              .layers = {},
                              .bumps = {.height_m = 2e-4, .length_m = 2e-3},
                              .viscosity = {.damping_ns_per_m = 3},
                              .snap = {.range_m = has_snap ? 2e-3 : 0.0},
                              .tap = {.ns_per_m = 5},
                              .texture = {.models = models}};
  return scene;
}

std::unique_ptr<TouchStep> make_turning_rich_touch() {
  TouchScene scene = sphere_with_rich_effects(true);
  scene.objects[0].motion = make_turn_to_and_fro();
  return std::make_unique<TouchStep>(*make_method({.name = "proxy"}, scene), scene);
}

std::unique_ptr<TouchStep> make_commanded_rich_touch() {
  TouchScene scene = sphere_with_rich_effects(true);
  scene.objects[0].command_pivot = Vec3(0.001, 0, 0);
  return std::make_unique<TouchStep>(*make_method({.name = "proxy"}, scene), scene);
}

std::unique_ptr<TouchStep> make_breathing_rich_touch() {
  TouchScene scene = sphere_with_rich_effects(false);
  MorphTarget target;
  for (std::uint32_t v = 0; v < scene.objects[0].mesh->vertices.size(); ++v) {
    target.vertices.push_back(v);
    target.displacements.push_back(0.1 * scene.objects[0].mesh->vertices[v]);
  }
  scene.objects[0].deformation =
      std::make_shared<const MeshDeformation>(std::vector{target}, std::vector<MorphKey>{{0.0, {0.0}}, {0.05, {1.0}}, {0.1, {0.0}}}, true);
  return std::make_unique<TouchStep>(*make_method({.name = "proxy"}, scene), scene);
}

struct TurningReplayTest : SessionReplayTest {
  TurningReplayTest() : SessionReplayTest(make_turning_rich_touch()) {}
};

TEST_F(TurningReplayTest, EffectsOfSurfacesThatMoveGiveTheSameForcesToTheLastBit) {
  slide(300);
  live.replace(make_turning_rich_touch());
  send_setup("proxy");
  slide(200);
  for (std::size_t n = 50; n < 250; n += 3) recorded[n].second.reset();
  SessionReplay replay = replay_with(make_turning_rich_touch);
  feed(replay);
  EXPECT_GT(replay.counts().compared, 400U);
  EXPECT_GT(replay.counts().contact_steps, 300U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
  EXPECT_EQ(replay.counts().not_compared, 0U);
}

struct BreathingReplayTest : SessionReplayTest {
  BreathingReplayTest() : SessionReplayTest(make_breathing_rich_touch()) {}
};

TEST_F(BreathingReplayTest, EffectsOfSurfacesThatDeformGiveTheSameForcesToTheLastBit) {
  slide(500);
  SessionReplay replay = replay_with(make_breathing_rich_touch);
  feed(replay);
  EXPECT_EQ(replay.counts().compared, recorded.size());
  EXPECT_GT(replay.counts().contact_steps, 200U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

struct CommandedReplayTest : SessionReplayTest {
  ObjectMoves moves;

  CommandedReplayTest() : SessionReplayTest(make_commanded_rich_touch()) {
    const ObjectMove at_rest{.source = 1, .from_p_m = Vec3(0.001, 0, 0), .to_p_m = Vec3(0.001, 0, 0)};
    moves[{kSender, 0, 0}] = at_rest;
  }
  void move_to(const Vec3& p) {
    const std::int64_t now_ns = live.scene_time_ns();
    const Keyframe from = live.touch().find_commanded(0)->keyframe_at(1e-9 * static_cast<double>(now_ns));
    const ObjectMove move{.source = 1,
                          .serial = static_cast<std::uint32_t>(live.counts().moves_taken) + 1,
                          .start_ns = now_ns,
                          .end_ns = now_ns + 80'000'000,
                          .from_p_m = from.p_S,
                          .from_q = from.turn,
                          .to_p_m = p,
                          .to_q = Quat(Eigen::AngleAxisd(30.0 * p.x(), Vec3::UnitZ()))};
    ASSERT_TRUE(live.command(0, to_command(move)));
    moves[{kSender, move.serial, move.object}] = move;
  }
};

TEST_F(CommandedReplayTest, EffectsOfObjectsThatProgramsMoveGiveTheSameForcesToTheLastBit) {
  slide(60);
  for (int n = 0; n < 5; ++n) {
    move_to(Vec3(0.001 + (n % 2 == 0 ? 0.004 : -0.002), 0.001 * n, 0.0));
    slide(n < 2 ? 100 : 37);
  }
  for (std::size_t n = 30; n < 200; n += 3) recorded[n].second.reset();
  SessionReplay replay = replay_with(make_commanded_rich_touch);
  replay.use_moves(moves);
  feed(replay);
  EXPECT_GT(replay.counts().compared, 250U);
  EXPECT_GT(replay.counts().contact_steps, 200U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

}  // namespace
}  // namespace hapton
