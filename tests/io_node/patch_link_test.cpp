#include "io_node/patch_link.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/io_node/servo_fixture.h"

namespace hapton {
namespace {

// A servo that may work with patches, and what it tells the haptics node of them.
struct PatchLinks : Servos {
  LocalPatch local;
  PatchBuilder builder{local};
  std::unique_ptr<PatchLink> link;

  void start(TouchChoice choice) {
    link = std::make_unique<PatchLink>(peers, local, builder, choice);
    make();
    servo->set_patch_link(link.get());
    join(kHaptics, NodeRole::haptics);
    run(100);
  }
};

TEST_F(PatchLinks, RemoteForceWantsNoParts) {
  start(TouchChoice::remote);
  run(500);
  EXPECT_TRUE(patch_statuses.empty());
  EXPECT_FALSE(link->is_wanted());
}

// Sooner where the builder has news: at first that it has nothing.
TEST_F(PatchLinks, PatchesAreRequestedEvery100Ms) {
  start(TouchChoice::patch);
  patch_statuses.clear();
  run(1000);
  EXPECT_TRUE(link->is_wanted());
  ASSERT_GE(patch_statuses.size(), 9U);
  EXPECT_LE(patch_statuses.size(), 12U);
  for (const auto& [time_ns, status] : patch_statuses) EXPECT_TRUE(status.is_wanted);
  for (std::size_t i = 1; i < patch_statuses.size(); ++i) {
    const std::int64_t between_ns = patch_statuses[i].first - patch_statuses[i - 1].first;
    EXPECT_GE(between_ns, PatchLink::kSoonNs - 2 * kMs);
    EXPECT_LE(between_ns, PatchLink::kStatusNs + 2 * kMs);
  }
}

TEST_F(PatchLinks, AutomaticGoesByTheRoundTrip) {
  start(TouchChoice::automatic);
  run(2000);
  EXPECT_FALSE(link->is_wanted()) << "100 us";
  answer_delay_ns = static_cast<std::int64_t>(2e9 * TouchChooser::kSlowS);
  run(2000);
  EXPECT_TRUE(link->is_wanted());
  ASSERT_FALSE(patch_statuses.empty());
  EXPECT_NEAR(patch_statuses.back().second.round_trip_s, 2.0 * TouchChooser::kSlowS, 0.2 * TouchChooser::kSlowS);
  // Fast again: it goes on until it has been so for a while, then tells haptics.
  answer_delay_ns = 100 * kUs;
  run(2000);
  EXPECT_TRUE(link->is_wanted());
  run(4000);
  EXPECT_FALSE(link->is_wanted());
  EXPECT_FALSE(patch_statuses.back().second.is_wanted);
}

TEST_F(PatchLinks, WithoutAHapticsNodeNothingIsWanted) {
  start(TouchChoice::patch);
  EXPECT_TRUE(link->is_wanted());
  say(kHaptics, Bye{});
  sequences.erase(kHaptics);
  run(300);
  EXPECT_FALSE(link->is_wanted());
}

TEST_F(PatchLinks, PartsThatWereNotRequestedAreDropped) {
  start(TouchChoice::remote);
  PatchTile tile;
  tile.epoch = tile.serial = 1;
  for (int n = 0; n < 50; ++n) say(kHaptics, tile);
  run(100);
  EXPECT_EQ(link->builder_counts().store.parts, 0U);
  EXPECT_EQ(link->builder_counts().store.rejected, 0U);
}

}  // namespace
}  // namespace hapton
