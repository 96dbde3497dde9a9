// Compares touch by patches with touch of the whole scene, while parts arrive late, in another order, or not at all.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/patch/patch_stage.h"

namespace hapton {
namespace {

constexpr double kHalfSide = 0.05;
constexpr double kStiffness = 1000.0;
constexpr double kDepth = 0.003;

// Slides in circles with a radius of 30 mm, pressed in by kDepth; at first the hand is free above the sheet.
Vec3 hand_at(double t_s, double speed, double settle_s) {
  constexpr double kRadius = 0.03;
  const double press = std::clamp((t_s - settle_s) / 0.3, 0.0, 1.0);
  const double angle = std::max(t_s - settle_s - 0.5, 0.0) * speed / kRadius;
  const double x = kRadius * std::cos(angle);
  const double y = kRadius * std::sin(angle);
  return {x, y, wavy_height(x, y) + 0.01 * (1.0 - press) - kDepth * press};
}

// The rounding of vertices to the grid, as a force. Where the surface is curved, the contact moves by a multiple of it (measured: up to 6).
double force_bound_n() { return 20.0 * kStiffness * PatchGrid::kLargestRounding * 2.0 * kHalfSide; }

struct SlideResult {
  double worst_n = 0.0;       // largest |patch - whole| within patches
  double worst_jump_n = 0.0;  // largest change of the patch's force in a step, less that of the whole scene's
  std::uint64_t within = 0;   // contact steps within patches
  std::uint64_t beyond = 0;   // contact steps past the edge of a patch
  std::uint64_t without = 0;  // steps with contact in the whole scene and no force of a patch
  std::uint64_t jumps = 0;    // steps at which the whole scene jumps to another local minimum, and the patch maybe a step earlier or later
};

SlideResult slide(PatchStage& stage, double speed, double seconds, double settle_s) {
  SlideResult result;
  struct StepForces {
    Vec3 patch;
    Vec3 whole;
    bool is_compared = false;
  };
  std::vector<StepForces> steps;
  for (int n = 1; n < static_cast<int>(1000.0 * seconds); ++n) {
    const auto [patch, whole] = stage.step(hand_at(1e-3 * n, speed, settle_s));
    if (!whole.contact) continue;
    const bool is_felt = patch && patch->contact;
    const bool is_within = is_felt && !patch->is_beyond;
    result.without += is_felt ? 0 : 1;
    result.beyond += is_felt && !is_within ? 1 : 0;
    result.within += is_within ? 1 : 0;
    steps.push_back({is_felt ? patch->force_n : Vec3(Vec3::Zero()), whole.force_n, is_within});
  }
  for (std::size_t n = 1; n + 1 < steps.size(); ++n) {
    if (!steps[n].is_compared || !steps[n - 1].is_compared) continue;
    const double whole_jump_n = std::max((steps[n].whole - steps[n - 1].whole).norm(), (steps[n + 1].whole - steps[n].whole).norm());
    const double error_n = (steps[n].patch - steps[n].whole).norm();
    if (error_n > force_bound_n() && error_n <= 2.0 * whole_jump_n && whole_jump_n > 0.05) {
      ++result.jumps;
      continue;
    }
    result.worst_n = std::max(result.worst_n, error_n);
    const double jump_n = (steps[n].patch - steps[n - 1].patch).norm() - whole_jump_n;
    result.worst_jump_n = std::max(result.worst_jump_n, jump_n);
  }
  return result;
}

struct Case {
  double speed;
  double round_trip_s;
  double loss;
};

class PatchTransfer : public testing::TestWithParam<Case> {};

TEST_P(PatchTransfer, GivesTheForceOfTheWholeScene) {
  const Case c = GetParam();
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    PatchStage stage(scene_of(wavy_sheet(kHalfSide, 60)),
                     {.delay_s = 0.5 * c.round_trip_s, .jitter_s = 0.02, .loss = c.loss, .seed = seed});
    const double settle_s = 1.0 + 3.0 * c.round_trip_s;
    const SlideResult result = slide(stage, c.speed, settle_s + 4.0, settle_s);
    EXPECT_GT(result.within, 3000U);
    EXPECT_EQ(result.without, 0U) << "contact of the whole scene that is not felt: a fall-through";
    EXPECT_EQ(result.beyond, 0U) << "parts are sent ahead of the hand";
    EXPECT_LT(result.worst_n, force_bound_n());
    EXPECT_LT(result.worst_jump_n, 2.0 * force_bound_n());
    EXPECT_LE(result.jumps, result.within / 1000);
  }
}

INSTANTIATE_TEST_SUITE_P(Networks, PatchTransfer,
                         testing::Values(Case{0.1, 0.0, 0.0}, Case{0.1, 0.1, 0.0}, Case{0.1, 0.3, 0.1}, Case{0.1, 1.0, 0.1},
                                         Case{0.1, 1.0, 0.3}, Case{0.3, 0.1, 0.1}, Case{0.3, 1.0, 0.1}, Case{0.3, 1.0, 0.3}));

// Too many triangles for one patch: patches follow the hand, and each takes over from the one before.
TEST(PatchStreamTest, AFineMeshIsFeltByPatchesThatFollowTheHand) {
  PatchStage stage(scene_of(wavy_sheet(kHalfSide, 200)), {.delay_s = 0.05, .loss = 0.05, .bits_per_s = 1e7});
  const SlideResult result = slide(stage, 0.1, 6.0, 2.0);
  EXPECT_GT(stage.touch().counts().handed_over, 5U);
  EXPECT_GT(result.within, 3000U);
  EXPECT_EQ(result.without, 0U);
  EXPECT_LT(result.worst_n, force_bound_n());
  EXPECT_LT(result.worst_jump_n, 2.0 * force_bound_n());
  EXPECT_LE(result.jumps, result.within / 1000);
}

// If the hand outruns its tiles, the plane of the last contact holds it: no fall-through, and no force far above the last one. Once the
// tiles are there, the hand feels the surface again.
TEST(PatchStreamTest, AHandThatOutrunsItsTilesFeelsThePlaneOfTheLastContact) {
  PatchStage::Network network{.delay_s = 0.05};
  PatchStage stage(scene_of(wavy_sheet(kHalfSide, 200)), network);
  constexpr double kSettleS = 1.5;
  int n = 1;
  for (; n < 2000; ++n) (void)stage.step(hand_at(1e-3 * n, 0.3, kSettleS));
  network.loss = 1.0;
  stage.set_network(network);
  const std::uint64_t beyond_before = stage.touch().counts().beyond_steps;
  double last_within_n = 0.0;
  std::uint64_t beyond = 0;
  for (; n < 4000; ++n) {
    const auto [patch, whole] = stage.step(hand_at(1e-3 * n, 0.05, kSettleS));
    ASSERT_TRUE(patch.has_value()) << n;
    EXPECT_TRUE(patch->force_n.allFinite());
    if (!patch->is_beyond) last_within_n = patch->force_n.norm();
    EXPECT_LE(patch->force_n.norm(), PatchTouch::kMaxBeyondForceRatio * last_within_n * (1.0 + 1e-12));
    beyond += patch->is_beyond ? 1 : 0;
  }
  EXPECT_GT(beyond, 100U);
  EXPECT_GE(stage.touch().counts().beyond, 1U);
  EXPECT_EQ(stage.touch().counts().beyond_steps - beyond_before, beyond) << "each is counted";
  network.loss = 0.0;
  stage.set_network(network);
  const Vec3 rest = hand_at(1e-3 * n, 0.05, kSettleS);
  PatchStage::Outputs felt;
  for (int m = 0; m < 8000; ++m) felt = stage.step(rest);
  ASSERT_TRUE(felt.patch && felt.patch->contact && !felt.patch->is_beyond);
  // Which of the nearby local minima holds the proxy depends on its path: it has come from the plane.
  const Vec3 proxy = rest + felt.patch->visual_offset_m;
  EXPECT_NEAR(proxy.z(), wavy_height(proxy.x(), proxy.y()), 5e-5) << "on the surface, but for the height of a facet";
}

// The hand leaves the patch, goes through the surface and comes back while the next patch is made. A straight line is not its path.
TEST(PatchStreamTest, AnExcursionPastThePatchIsNotCutShort) {
  PatchStage::Network network{.delay_s = 0.02, .bits_per_s = 1e7};
  PatchStage stage(scene_of(wavy_sheet(kHalfSide, 200)), network);
  const Vec3 above(0.0, 0.0, 0.004);
  for (int n = 0; n < 3000; ++n) (void)stage.step(above);
  network.make_s = 0.3;
  stage.set_network(network);
  PatchStage::Outputs felt;
  for (int n = 0; n <= 200; ++n) {
    // Down through the sheet 40 mm aside.
    const double sideways_m = 0.04 * std::min(n, 200 - n) / 100.0;
    felt = stage.step(above + Vec3(sideways_m, 0.0, n > 100 ? -0.008 : 0.0));
  }
  const Vec3 below = above - Vec3(0.0, 0.0, 0.008);
  for (int n = 0; n < 1500; ++n) felt = stage.step(below);
  ASSERT_TRUE(felt.patch && felt.whole.contact);
  EXPECT_FALSE(felt.patch->is_beyond);
  EXPECT_LT((felt.patch->force_n - felt.whole.force_n).norm(), force_bound_n());
}

// A hand at rest is soon within a patch of the whole scene.
TEST(PatchStreamTest, PatchesGrowUpToTheWholeScene) {
  PatchStage stage(scene_of(wavy_sheet(kHalfSide, 200)), {.delay_s = 0.05, .bits_per_s = 1e7});
  for (int n = 0; n < 6000; ++n) (void)stage.step(Vec3(0.0, 0.0, 0.01));
  EXPECT_EQ(stage.maker().triangles(), 2U * 200U * 200U);
  EXPECT_EQ(stage.maker().radius_m(), std::numeric_limits<double>::infinity());
}

TEST(PatchStreamTest, WhatTheHubHasIsNotSentAgain) {
  PatchStage stage(scene_of(wavy_sheet(kHalfSide, 40)), {.delay_s = 0.05, .loss = 0.1});
  (void)slide(stage, 0.1, 6.0, 2.0);
  const auto sent = stage.source().counts().sent;
  EXPECT_EQ(stage.source().counts().held, 1 + stage.source().scene().cells.size() + stage.source().scene().tiles.size());
  for (int n = 0; n < 2000; ++n) (void)stage.step(hand_at(6.0 + 1e-3 * n, 0.1, 2.0));
  EXPECT_EQ(stage.source().counts().sent, sent);
}

TEST(PatchStreamTest, NoMoreIsSentThanTheBandwidthAllows) {
  constexpr double kBitsPerS = 2e5;
  PatchStage stage(scene_of(wavy_sheet(kHalfSide, 100)), {.delay_s = 0.1, .loss = 0.3, .bits_per_s = kBitsPerS});
  for (int n = 0; n < 5000; ++n) (void)stage.step(hand_at(1e-3 * n, 0.1, 1.0));
  EXPECT_LE(static_cast<double>(stage.source().counts().bytes), kBitsPerS / 8.0 * 5.0 + 5000.0);
  EXPECT_GT(static_cast<double>(stage.source().counts().bytes), kBitsPerS / 8.0 * 4.0);
}

// The scene turns under a hand that rests on it.
TEST(PatchStreamTest, ThePatchMovesWithTheScene) {
  PatchStage stage(scene_of(wavy_sheet(kHalfSide, 60)), {.delay_s = 0.05});
  for (int n = 0; n < 3000; ++n) (void)stage.step(hand_at(1e-3 * n, 0.0, 2.0));
  const Vec3 hand = hand_at(3.0, 0.0, 2.0);
  for (int n = 0; n < 500; ++n) {
    Pose X_WS = Pose::Identity();
    X_WS.linear() = Eigen::AngleAxisd(1e-4 * n, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    X_WS.translation() = Vec3(0, 0, 2e-6 * n);
    const auto [patch, whole] = stage.step(hand, X_WS);
    ASSERT_TRUE(patch.has_value());
    ASSERT_LT((patch->force_n - whole.force_n).norm(), force_bound_n()) << n;
  }
}

// The hub drops a node that was silent for too long, with all that the node has sent. Then the node is back.
TEST(PatchTransfer, AHubThatHasForgottenGetsAllAgain) {
  PatchSource source(make_tiles(scene_of(wavy_sheet(0.05, 20))), 0.0, 7, 1, {.bits_per_s = 1e9, .least_reach_m = 1.0});
  PatchStore store;
  std::int64_t now_ns = 1'000'000'000;
  for (int life = 0; life < 2; ++life) {
    for (int n = 0; n < 500; ++n, now_ns += 20'000'000) {
      while (const auto part = source.take(now_ns)) {
        if (const auto* tile = std::get_if<PatchTile>(&*part)) store.accept(*tile);
        if (const auto* cell = std::get_if<PatchCell>(&*part)) store.accept(*cell);
        if (const auto* begin = std::get_if<PatchBegin>(&*part)) store.accept(*begin);
      }
      source.accept(store.status());
    }
    EXPECT_TRUE(std::isinf(store.known_radius(Vec3::Zero()))) << "life " << life;
    EXPECT_FALSE(source.take(now_ns).has_value());
    store.clear();
    source.accept(store.status());
  }
}

}  // namespace
}  // namespace hapton
