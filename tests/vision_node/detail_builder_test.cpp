#include "vision_node/detail_builder.h"

#include <chrono>
#include <future>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

std::vector<DetailBuilder::MadeLevel> take_all(DetailBuilder& builder) {
  std::vector<DetailBuilder::MadeLevel> all;
  for (int waits = 0; waits < 12'000; ++waits) {
    const bool done = builder.progress() == 1.0;
    for (auto& made : builder.take_levels()) all.push_back(std::move(made));
    if (done) return all;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ADD_FAILURE() << "the levels are not made within a minute";
  return all;
}

std::shared_ptr<const DetailLevel> level_of(const TriangleMesh& mesh) {
  return std::make_shared<const DetailLevel>(make_full_level(mesh, make_detail_frame(mesh)));
}

TEST(DetailBuilder, MakesLevelsFromTheFinestToTheCoarsestAndThenTheMeshInClusters) {
  const auto small = level_of(make_icosphere(0.05, 3));
  const auto large = level_of(make_bumpy_sphere(0.05, 0.25, 70'000, 1));
  DetailBuilder builder({small, large});
  const auto made = take_all(builder);
  ASSERT_GE(made.size(), 4U);
  std::size_t triangles_before = large->triangles();
  for (std::size_t i = 0; i + 1 < made.size(); ++i) {
    EXPECT_EQ(made[i].object, 1U) << "the small one keeps its triangles";
    EXPECT_FALSE(made[i].is_full || made[i].is_rough);
    EXPECT_LT(made[i].level.triangles(), triangles_before);
    EXPECT_GT(made[i].level.error, 0.0);
    triangles_before = made[i].level.triangles();
  }
  EXPECT_GT(triangles_before, 1'500U) << "the coarsest of all: fewer triangles save no time";
  EXPECT_TRUE(made.back().is_full);
  EXPECT_EQ(made.back().level.triangles(), large->triangles());
  EXPECT_EQ(made.back().level.error, 0.0);
}

TEST(DetailBuilder, BeginsByItselfWhenNobodyDraws) {
  const auto mesh = level_of(make_bumpy_sphere(0.05, 0.25, 20'000, 1));
  DetailBuilder builder({mesh});
  EXPECT_FALSE(take_all(builder).empty());
}

// Without begin() this builder would wait for a day.
TEST(DetailBuilder, BeginsAtOnceWhenBeginIsCalled) {
  const auto mesh = level_of(make_bumpy_sphere(0.05, 0.25, 20'000, 1));
  DetailBuilder builder({mesh}, std::chrono::hours(24));
  EXPECT_EQ(builder.progress(), 0.0);
  EXPECT_TRUE(builder.take_levels().empty());
  builder.begin();
  const auto made = take_all(builder);
  ASSERT_FALSE(made.empty());
  EXPECT_TRUE(made.back().is_full);
  EXPECT_TRUE(builder.take_levels().empty()) << "each level is returned once";
}

TEST(DetailBuilder, CanBeEndedBeforeItHasBegun) {
  const auto mesh = level_of(make_bumpy_sphere(0.05, 0.25, 20'000, 1));
  for (int i = 0; i < 20; ++i) {
    DetailBuilder builder({mesh});
    if (i % 2 == 0) builder.begin();
  }
}

TEST(DetailBuilder, OfALargeMeshARoughLevelComesFirst) {
  const auto large = level_of(make_bumpy_sphere(0.05, 0.25, 300'000, 1));
  DetailBuilder builder({large});
  const auto made = take_all(builder);
  ASSERT_GE(made.size(), 3U);
  EXPECT_TRUE(made.front().is_rough);
  EXPECT_GT(made.front().level.error, 0.0);
  for (std::size_t i = 1; i < made.size(); ++i) EXPECT_FALSE(made[i].is_rough);
}

TEST(DetailBuilder, NothingToMakeIsDoneAtOnce) {
  const auto small = level_of(make_icosphere(0.05, 3));
  DetailBuilder builder({small});
  EXPECT_EQ(builder.progress(), 1.0);
  EXPECT_TRUE(builder.take_levels().empty());
}

TEST(DetailBuilder, StopsBeforeItIsDone) {
  const auto large = level_of(make_bumpy_sphere(0.05, 0.25, 70'000, 1));
  DetailBuilder builder({large});
}

// The thread continues until the level in progress is made. Only then does it release the mesh that it reads.
TEST(DetailBuilder, ItsEndDoesNotWaitForTheLevelInProgress) {
  std::promise<std::thread::id> released;
  const auto mesh = make_bumpy_sphere(0.05, 0.25, 300'000, 1);
  std::shared_ptr<const DetailLevel> large(new DetailLevel(make_full_level(mesh, make_detail_frame(mesh))), [&](const DetailLevel* level) {
    delete level;
    released.set_value(std::this_thread::get_id());
  });
  {
    DetailBuilder builder({std::move(large)});
    builder.begin();
    while (builder.take_levels().empty()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_NE(released.get_future().get(), std::this_thread::get_id());
}

}  // namespace
}  // namespace hapton
