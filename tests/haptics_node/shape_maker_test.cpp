#include "haptics_node/shape_maker.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "core/force/streamed_method.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

class ShapeMakerTest : public testing::Test {
 protected:
  void publish_shape(std::uint32_t shape, float height_m) {
    WantedShape& draft = maker_.draft();
    draft.stream = 7;
    draft.shape = shape;
    draft.over_s = 0.02;
    for (auto& one : draft.displacements_m) one = {0.0F, 0.0F, height_m};
    maker_.publish();
  }
  static double start_height(const MadeShape& made) { return made.stage->begin.front().z(); }
  static double end_height(const MadeShape& made) { return made.stage->to.front().z(); }

  std::unique_ptr<StreamedMethod> method_ = *StreamedMethod::make({}, made::shared(made::sheet(0.03, 0.0, 8)), {}, 0.02);
  ShapeMaker maker_{*method_, ProgramShape{.reach_m = 0.02}};
};

TEST_F(ShapeMakerTest, MakesOneStageAfterTheOther) {
  EXPECT_FALSE(maker_.work());
  EXPECT_EQ(maker_.take(), nullptr);
  publish_shape(1, 0.001F);
  EXPECT_TRUE(maker_.work());
  EXPECT_FALSE(maker_.work());
  auto first = maker_.take();
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->wanted.shape, 1U);
  EXPECT_EQ(first->wanted.over_s, 0.02);
  EXPECT_EQ(start_height(*first), 0.0);
  EXPECT_FLOAT_EQ(static_cast<float>(end_height(*first)), 0.001F);
  publish_shape(2, 0.003F);
  EXPECT_TRUE(maker_.work());
  auto second = maker_.take();
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(start_height(*second), end_height(*first)) << "to the last bit";
}

// A finished shape that was not taken yet is replaced by a newer one, which begins where the replaced one would have begun.
TEST_F(ShapeMakerTest, ANewerShapeReplacesOneThatWasNotTaken) {
  publish_shape(1, 0.001F);
  maker_.work();
  publish_shape(2, 0.002F);
  maker_.work();
  const auto made = maker_.take();
  ASSERT_NE(made, nullptr);
  EXPECT_EQ(made->wanted.shape, 2U);
  EXPECT_EQ(start_height(*made), 0.0);
  EXPECT_EQ(maker_.take(), nullptr);
}

TEST_F(ShapeMakerTest, WhatIsGivenBackIsDestroyedElsewhere) {
  publish_shape(1, 0.001F);
  maker_.work();
  auto first = maker_.take();
  publish_shape(2, 0.002F);
  maker_.work();
  maker_.give_back(std::move(first));
  EXPECT_EQ(maker_.take(), nullptr) << "there is one place for it";
  maker_.work();
  EXPECT_NE(maker_.take(), nullptr);
}

TEST_F(ShapeMakerTest, WhatTheSurfaceCannotTakeIsRejected) {
  publish_shape(1, 0.5F);
  EXPECT_TRUE(maker_.work());
  EXPECT_EQ(maker_.take(), nullptr);
  const RejectedShape* rejected = maker_.take_rejection();
  ASSERT_NE(rejected, nullptr);
  EXPECT_EQ(rejected->stream, 7U);
  EXPECT_EQ(rejected->shape, 1U);
  EXPECT_NE(std::string(rejected->why.data()).find("reach"), std::string::npos);
  EXPECT_EQ(maker_.take_rejection(), nullptr);
  publish_shape(2, 0.002F);
  EXPECT_TRUE(maker_.work());
  EXPECT_NE(maker_.take(), nullptr);
}

// Both threads run at once: each shape that is taken begins where the shape taken before it ends.
TEST_F(ShapeMakerTest, StagesFollowOnFromEachOtherWithAThread) {
  std::atomic<bool> stop = false;
  std::thread task([&] {
    while (!stop.load()) {
      if (!maker_.work()) std::this_thread::yield();
    }
  });
  double last_height = 0.0;
  std::uint32_t shape = 0;
  for (int taken_shapes = 0; taken_shapes < 60;) {
    ++shape;
    publish_shape(shape, 1e-4F * static_cast<float>(shape % 100));
    std::unique_ptr<MadeShape> made;
    // The test waits for every third shape.
    for (int attempt = 0; made == nullptr && attempt < 200'000; ++attempt) {
      made = maker_.take();
      if (made == nullptr && shape % 3 != 0) break;
      std::this_thread::yield();
    }
    if (made == nullptr) continue;
    EXPECT_EQ(start_height(*made), last_height) << "shape " << shape;
    last_height = end_height(*made);
    maker_.give_back(std::move(made));
    ++taken_shapes;
  }
  stop = true;
  task.join();
}

}  // namespace
}  // namespace hapton
