#include "io_node/patch_builder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <thread>

#include "patch/tile_partition.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_scene.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

constexpr std::uint32_t kEpoch = 3;

// A sheet in parts, and the device side that gets patches of it.
struct BuilderStage {
  BuilderStage() : tiled(make_tiles(scene_of(made::sheet(0.05, 0.0, 20)))) {
    local.publish({.is_wanted = true, .until_ns = 1'000'000 * kMs});
  }

  void send(Message part, std::uint32_t epoch = kEpoch) {
    std::visit(
        [&](auto& message) {
          if constexpr (requires {
                          message.epoch;
                          message.serial;
                        }) {
            message.epoch = epoch;
            message.serial = ++serial;
          }
        },
        part);
    builder.push(part);
  }
  void send_all(std::uint32_t epoch = kEpoch) {
    serial = 0;
    send(PatchBegin{0, 0, tiled.grid.origin_m, tiled.grid.step_m, 0.0, 7}, epoch);
    for (const TileCell& cell : tiled.cells) send(to_message(cell, 0, 0), epoch);
    for (const PatchTile& tile : tiled.tiles) send(tile, epoch);
  }
  // Steps the device 1 mm below the sheet until that holds; false: not within 30 s.
  bool step_until(const std::function<bool(const std::optional<LocalForce>&)>& holds) {
    for (int n = 0; n < 15000; ++n) {
      time_ns += kMs;
      if (holds(local.step({time_ns, Vec3(0, 0, -0.001), Quat::Identity(), 0, true}))) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }

  TiledScene tiled;
  LocalPatch local;
  PatchBuilder builder{local};
  std::uint32_t serial = 0;
  std::int64_t time_ns = 0;
};

bool is_felt(const std::optional<LocalForce>& force) { return force.has_value(); }

TEST(PatchBuilder, MakesAPatchOfWhatCameAndConfirmsIt) {
  BuilderStage stage;
  stage.send_all();
  // The first patch may be of a part of what came.
  ASSERT_TRUE(stage.step_until([&](const std::optional<LocalForce>& force) {
    const PatchBuilderCounts now = stage.builder.counts();
    stage.builder.take_status();
    return force && now.triangles == 2U * 20U * 20U && stage.builder.status().newest_serial == stage.serial;
  }));
  EXPECT_EQ(stage.builder.status().epoch, kEpoch);
  EXPECT_EQ(stage.builder.status().newest_serial, stage.serial);
  const PatchBuilderCounts counts = stage.builder.counts();
  EXPECT_EQ(counts.store.parts, stage.serial);
  EXPECT_GE(counts.built, 1U);
  EXPECT_EQ(counts.triangles, 2U * 20U * 20U);
}

TEST(PatchBuilder, MakesNoneOfAPart) {
  BuilderStage stage;
  stage.send(PatchBegin{0, 0, stage.tiled.grid.origin_m, stage.tiled.grid.step_m, 0.0, 7});
  stage.send(stage.tiled.tiles.front());
  for (int n = 0; n < 50; ++n) {
    EXPECT_FALSE(stage.step_until([](const std::optional<LocalForce>&) { return true; }) && stage.builder.counts().built > 0);
  }
}

TEST(PatchBuilder, AfterAClearNothingOfBeforeIsUsed) {
  BuilderStage stage;
  stage.send_all();
  ASSERT_TRUE(stage.step_until(is_felt));
  // Asked for, but not done: at once.
  stage.local.publish({.is_wanted = true, .until_ns = 1'000'000 * kMs, .clears = 1});
  stage.time_ns += kMs;
  EXPECT_FALSE(stage.local.step({stage.time_ns, Vec3(0, 0, -0.001), Quat::Identity(), 0, true}));
  EXPECT_TRUE(stage.step_until([&](const auto&) {
    (void)stage.builder.take_status();
    return stage.builder.status().epoch == kEpoch;
  }));
  ASSERT_TRUE(stage.builder.clear());
  EXPECT_EQ(stage.builder.status().epoch, 0U) << "at once: the next haptics node may have an epoch of that number";
  EXPECT_TRUE(stage.step_until([&](const auto&) {
    const bool is_new = stage.builder.take_status();
    EXPECT_EQ(stage.builder.status().epoch, 0U);
    return is_new;
  }));
  // Another haptics node, whose epochs start again.
  stage.send_all(1);
  EXPECT_TRUE(stage.step_until(is_felt));
}

TEST(PatchBuilder, ANewEpochReplacesTheOneBefore) {
  BuilderStage stage;
  stage.send_all();
  ASSERT_TRUE(stage.step_until(is_felt));
  stage.send_all(kEpoch + 1);
  EXPECT_TRUE(stage.step_until([&](const auto& force) {
    (void)stage.builder.take_status();
    return stage.builder.status().epoch == kEpoch + 1 && force.has_value();
  }));
}

TEST(PatchBuilder, TakesPartsWithoutHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  BuilderStage stage;
  const Message part = stage.tiled.tiles.front();
  const AllocationGuard guard;
  // More than there is room for: the rest is dropped, and comes again as it is never confirmed.
  for (int n = 0; n < 1000; ++n) stage.builder.push(part);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
