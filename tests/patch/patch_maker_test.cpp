#include "patch/patch_maker.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "tests/patch/patch_stage.h"

namespace hapton {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr std::size_t kFewTriangles = 4000;
constexpr std::size_t kAllTriangles = 2 * 120 * 120;
const Vec3 kMiddle(0.011, -0.007, 0.0);  // on no border of cells: there the triangles of all adjacent cells count
constexpr double kSlowestSpeed = 0.05;   // m/s: a hand at rest counts as moving at this speed

const TiledScene& fine_sheet() {
  static const TiledScene made = make_tiles(scene_of(wavy_sheet(0.05, 120)));
  return made;
}

// The store has a sheet of kAllTriangles triangles. The tests say how long a patch for the hand takes to make.
struct PatchMakerTest : testing::Test {
  PatchMakerTest() {
    begin();
    for (std::size_t n = 0; n < tiled.cells.size(); ++n) store.accept(to_message(tiled.cells[n], 1, ++serial));
    for (const PatchTile& each : tiled.tiles) take(each);
  }
  void begin() { store.accept(PatchBegin{1, ++serial, tiled.grid.origin_m, tiled.grid.step_m, 0.0, 7}); }
  void take(PatchTile tile) {
    tile.epoch = 1;
    tile.serial = ++serial;
    store.accept(tile);
  }
  // Puts the hand at kMiddle + by.
  void hold(const Vec3& by, double at_s = 1.0) { maker.note_hand({kMiddle + by, static_cast<std::int64_t>(1e9 * at_s), false, {}}); }
  void hold_beyond(const PathBall& ball, double at_s) {
    maker.note_hand({ball.p_SC + Vec3(ball.radius_m, 0, 0), static_cast<std::int64_t>(1e9 * at_s), true, ball});
  }
  std::unique_ptr<Patch> make() { return maker.make_if_due(store, 3); }
  // From here on patches take so long that a larger one does not pay.
  void make_slowly() { maker.note_made(1.0 * static_cast<double>(maker.triangles())); }

  const TiledScene& tiled = fine_sheet();
  PatchStore store;
  PatchMaker maker{kFewTriangles};
  std::uint32_t serial = 0;
};

TEST_F(PatchMakerTest, MakesNothingBeforeThereIsAHandAndAScene) {
  EXPECT_EQ(make(), nullptr) << "no hand";
  hold(Vec3(std::nan(""), 0, 0));
  EXPECT_EQ(make(), nullptr) << "a hand that is nowhere";
  maker.note_hand({Vec3::Zero(), 1, false, {Vec3(0, kInfinite, 0), 0.0}});
  EXPECT_EQ(make(), nullptr) << "a path that leads nowhere";
  hold(Vec3::Zero());
  EXPECT_EQ(maker.make_if_due(PatchStore(), 3), nullptr) << "no scene";
  EXPECT_NE(make(), nullptr);
}

TEST_F(PatchMakerTest, TheFirstIsSmallAndAroundTheHand) {
  hold(Vec3(0, 0, 0.004));
  const auto patch = make();
  ASSERT_NE(patch, nullptr);
  EXPECT_NE(patch->step, nullptr);
  EXPECT_EQ(patch->p_SC, kMiddle + Vec3(0, 0, 0.004));
  EXPECT_EQ(patch->objects, std::vector<int>{0});
  EXPECT_EQ(patch->generation, 3U);
  EXPECT_EQ(patch->radius_m, maker.radius_m());
  EXPECT_EQ(patch->lift_m, 4.0 * tiled.grid.step_m);
  EXPECT_FALSE(patch->is_path_incomplete);
  EXPECT_LE(maker.triangles(), kFewTriangles);
  EXPECT_GT(maker.triangles(), kFewTriangles / 4);
  make_slowly();
  EXPECT_EQ(make(), nullptr) << "the newest will do";
}

// The middle ends at 0.35 of the radius.
TEST_F(PatchMakerTest, AnotherIsDueWhereTheHandLeavesTheMiddleOfTheNewest) {
  hold(Vec3::Zero());
  ASSERT_NE(make(), nullptr);
  make_slowly();
  const double radius_m = maker.radius_m();
  hold(Vec3(0.34 * radius_m, 0, 0), 100.0);
  EXPECT_EQ(make(), nullptr);
  hold(Vec3(0.36 * radius_m, 0, 0), 200.0);
  const auto patch = make();
  ASSERT_NE(patch, nullptr);
  EXPECT_LT((patch->p_SC - kMiddle - Vec3(0.36 * radius_m, 0, 0)).norm(), 0.01 * radius_m);
  EXPECT_EQ(make(), nullptr);
}

// A step of 30 mm within 0.1 s counts fully in the mean of the velocity, one of 1 mm within 5 ms counts as a quarter.
TEST_F(PatchMakerTest, IsAheadOfTheHand) {
  hold(Vec3(-0.03, 0, 0), 1.0);
  hold(Vec3::Zero(), 1.1);
  EXPECT_NEAR((make()->p_SC - kMiddle).x(), 0.01 * 0.3, 1e-9) << "where it is 10 ms later";
  make_slowly();
  maker.forget();
  hold(Vec3(0, 0.001, 0), 1.105);
  const auto patch = make();
  ASSERT_NE(patch, nullptr);
  EXPECT_NEAR((patch->p_SC - kMiddle).x(), 0.01 * (0.3 - 0.25 * 0.3), 1e-9);
  EXPECT_NEAR((patch->p_SC - kMiddle).y(), 0.001 + 0.01 * 0.25 * 0.2, 1e-9);
  maker.forget();
  hold(Vec3(0.01, 0.001, 0), 1.105);
  EXPECT_NEAR((make()->p_SC - kMiddle).x(), 0.01 + 0.01 * 0.225, 1e-9) << "no time has passed: no velocity follows from that";
}

TEST_F(PatchMakerTest, WhatIsForgottenIsMadeAgain) {
  hold(Vec3::Zero());
  ASSERT_NE(make(), nullptr);
  make_slowly();
  EXPECT_EQ(make(), nullptr);
  maker.forget();
  EXPECT_NE(make(), nullptr);
}

TEST_F(PatchMakerTest, PatchesOfAHandAtRestGrowUntilTheyAreAllThereIs) {
  hold(Vec3::Zero());
  std::size_t last = 0;
  int made = 0;
  while (const auto patch = make()) {
    EXPECT_GT(maker.triangles(), last);
    last = maker.triangles();
    ASSERT_LT(++made, 10);
  }
  EXPECT_GT(made, 1);
  EXPECT_EQ(last, kAllTriangles);
  EXPECT_EQ(maker.radius_m(), kInfinite);
  hold(Vec3(0.04, 0.04, 0), 2.0);
  EXPECT_EQ(make(), nullptr) << "no hand can leave that";
}

// A larger patch pays if twice as many triangles take at most half of the time in which the hand, at its speed, would leave the patch. The
// time of the newest patch has a weight of 0.3 in the mean.
TEST_F(PatchMakerTest, GrowsOnlyAsMuchAsCanBeMadeWhileTheHandIsWithin) {
  for (const double speed : {0.0, 0.2}) {
    for (const double share : {0.95, 1.05}) {
      SCOPED_TRACE(testing::Message() << speed << " m/s, " << share);
      maker = PatchMaker(kFewTriangles);
      hold(Vec3(-0.1 * speed, 0, 0), 1.0);
      hold(Vec3::Zero(), 1.1);
      ASSERT_NE(make(), nullptr);
      const double room_m = maker.radius_m() - 0.01 * speed;
      const double affordable_s = 0.5 * room_m / std::max(speed, kSlowestSpeed);
      const auto triangles = static_cast<double>(maker.triangles());
      const double s_per_triangle = share * affordable_s / (2.0 * triangles);
      maker.note_made((s_per_triangle - 0.7 * PatchMaker::kFirstMakeS) / 0.3 * triangles);
      EXPECT_EQ(make() != nullptr, share < 1.0);
    }
  }
}

TEST_F(PatchMakerTest, ATimeThatCannotBeOrThatSaysLittleCountsForNothing) {
  for (const double seconds : {0.0, -1e6, std::nan("")}) {
    SCOPED_TRACE(testing::Message() << seconds << " s");
    maker = PatchMaker(kFewTriangles);
    hold(Vec3::Zero());
    ASSERT_NE(make(), nullptr);
    maker.note_made(seconds);
    EXPECT_NE(make(), nullptr) << "it grows as before";
  }
  maker = PatchMaker(2 * kAllTriangles + 2);
  maker.note_made(1e6);  // for no triangle at all
  hold(Vec3::Zero());
  ASSERT_NE(make(), nullptr);
  EXPECT_EQ(maker.triangles(), kAllTriangles);
  maker.note_made(1e6);  // for fewer than half of the triangles that are always made
  maker.forget();
  EXPECT_NE(make(), nullptr);
  EXPECT_EQ(maker.triangles(), kAllTriangles);
}

TEST_F(PatchMakerTest, PastTheEdgeAPatchCoversThePathAndAWiderOneFollowsIfThatWasNotEnough) {
  hold(Vec3::Zero());
  ASSERT_NE(make(), nullptr);
  make_slowly();
  const PathBall ball{kMiddle, 0.008};
  hold_beyond(ball, 2.0);
  auto patch = make();
  ASSERT_NE(patch, nullptr);
  EXPECT_EQ(patch->p_SC, ball.p_SC);
  EXPECT_GE(patch->radius_m, 1.5 * ball.radius_m);
  EXPECT_FALSE(patch->is_path_incomplete);
  const double first_m = patch->radius_m;
  hold_beyond(ball, 2.049);
  EXPECT_EQ(make(), nullptr) << "it has 50 ms to be taken";
  hold_beyond({ball.p_SC, first_m}, 2.049);
  EXPECT_NE(make(), nullptr) << "unless it does not reach";
  hold_beyond({ball.p_SC, 0.005}, 2.2);
  EXPECT_EQ(make() != nullptr, true);
  // Each further patch is twice as wide as the one before.
  hold_beyond({ball.p_SC, 0.005}, 2.3);
  patch = make();
  ASSERT_NE(patch, nullptr);
  EXPECT_GE(patch->radius_m, 4.0 * 1.5 * 0.005);
}

TEST_F(PatchMakerTest, AHandThatIsWithinAgainBeginsWithTheNarrowestPatch) {
  const PathBall ball{kMiddle, 0.004};
  double narrow_m = 0.0;
  for (const bool was_within : {true, false}) {
    if (was_within) hold(Vec3::Zero(), 2.0);
    maker.forget();
    hold_beyond(ball, 3.1);
    ASSERT_NE(make(), nullptr);
    if (was_within) make_slowly();
    if (was_within) narrow_m = maker.radius_m();
    hold_beyond(ball, 3.2);
    ASSERT_NE(make(), nullptr) << "it had its 50 ms";
  }
  const double wide_m = maker.radius_m();
  EXPECT_GE(wide_m, 4.0 * 1.5 * ball.radius_m);
  hold(Vec3::Zero(), 4.0);
  maker.forget();
  hold_beyond(ball, 5.0);
  ASSERT_NE(make(), nullptr);
  EXPECT_LT(maker.radius_m(), wide_m);
  EXPECT_NEAR(maker.radius_m(), narrow_m, 0.3 * narrow_m);
}

// The store lacks the tiles of a strip of the sheet.
struct PartlyKnown : PatchMakerTest {
  PartlyKnown() {
    store.clear();
    begin();
    for (const TileCell& cell : tiled.cells) store.accept(to_message(cell, 1, ++serial));
    for (std::size_t n = 0; n < tiled.tiles.size(); ++n) {
      const Vec3 middle = tiled.grid.origin_m + tiled.grid.step_m * tiled.tile_bounds[n].centre();
      (middle.x() > -0.02 ? known_tiles : unknown_tiles).push_back(n);
    }
    for (const std::size_t n : known_tiles) take(tiled.tiles[n]);
  }
  std::vector<std::size_t> known_tiles;
  std::vector<std::size_t> unknown_tiles;
};

TEST_F(PartlyKnown, APatchIsNoWiderThanWhatIsKnown) {
  maker = PatchMaker(100'000);
  hold(Vec3::Zero());
  ASSERT_NE(make(), nullptr);
  const double radius_m = maker.radius_m();
  EXPECT_EQ(radius_m, store.known_radius(kMiddle));
  ASSERT_GT(radius_m, 0.01);
  EXPECT_EQ(make(), nullptr);
  take(tiled.tiles[known_tiles.front()]);
  EXPECT_EQ(make(), nullptr) << "what came adds nothing";
  for (const std::size_t n : unknown_tiles) take(tiled.tiles[n]);
  ASSERT_NE(make(), nullptr) << "it has grown";
  EXPECT_EQ(maker.radius_m(), kInfinite);
}

TEST_F(PartlyKnown, WhereNothingIsKnownNothingIsMade) {
  const Vec3 unknown_position(-0.045, 0.03, 0.0);
  hold(unknown_position - kMiddle);
  ASSERT_EQ(store.known_radius(unknown_position), 0.0);
  EXPECT_EQ(make(), nullptr);
}

// The hand leaves the known part. Less is known ahead of the hand, so the patch stays at the hand.
TEST_F(PartlyKnown, StaysWhereTheHandIsWhenLessIsKnownAhead) {
  hold(Vec3(0.2, 0.0, 0.0), 1.0);
  hold(Vec3::Zero(), 1.1);
  auto patch = make();
  ASSERT_NE(patch, nullptr);
  EXPECT_EQ(patch->p_SC, kMiddle);
  maker = PatchMaker(100'000);
  hold(Vec3(-0.1, 0.0, 0.0), 1.0);
  hold(Vec3::Zero(), 1.1);
  patch = make();
  ASSERT_NE(patch, nullptr);
  EXPECT_NEAR((patch->p_SC - kMiddle).x(), 0.01, 1e-9) << "more is known there";
}

TEST_F(PartlyKnown, APathWithMissingPartsIsReportedAsIncomplete) {
  maker = PatchMaker(100'000);
  const double known_m = store.known_radius(kMiddle);
  const auto hold_at_the_edge = [&](const PathBall& ball, double at_s) {
    maker.note_hand({kMiddle, static_cast<std::int64_t>(1e9 * at_s), true, ball});
  };
  hold_at_the_edge({Vec3(-0.045, 0.03, 0.0), 0.01}, 2.0);
  auto patch = make();
  ASSERT_NE(patch, nullptr);
  EXPECT_TRUE(patch->is_path_incomplete);
  EXPECT_EQ(patch->p_SC, kMiddle) << "where the hand is";
  EXPECT_EQ(make(), nullptr) << "not again and again";
  hold_at_the_edge({kMiddle, 0.9 * known_m / 1.5}, 2.1);
  patch = make();
  ASSERT_NE(patch, nullptr);
  EXPECT_FALSE(patch->is_path_incomplete);
  hold_at_the_edge({kMiddle, 1.1 * known_m / 1.5}, 2.2);
  patch = make();
  ASSERT_NE(patch, nullptr) << "the one before does not lead there";
  EXPECT_TRUE(patch->is_path_incomplete);
}

// The known part of the scene around the hand has no triangle.
TEST(PatchMaker, WhereNothingIsThereThePatchIsEmpty) {
  PatchStore store;
  TiledScene tiled = make_tiles(scene_of(wavy_sheet(0.05, 120)));
  std::uint32_t serial = 0;
  store.accept(PatchBegin{1, ++serial, tiled.grid.origin_m, tiled.grid.step_m, 0.0, 7});
  for (const TileCell& cell : tiled.cells) store.accept(to_message(cell, 1, ++serial));
  PatchMaker maker;
  const Vec3 above(0.0, 0.0, 0.045);
  ASSERT_GT(store.known_radius(above), 0.0);
  maker.note_hand({above, 1, false, {}});
  const auto patch = maker.make_if_due(store, 0);
  ASSERT_NE(patch, nullptr);
  EXPECT_EQ(patch->step, nullptr);
  EXPECT_GT(patch->radius_m, 0.0);
  EXPECT_TRUE(patch->objects.empty());
}

}  // namespace
}  // namespace hapton
