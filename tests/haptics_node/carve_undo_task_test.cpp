#include "haptics_node/carve_undo_task.h"

#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/log_of.h"

namespace hapton {
namespace {

TouchScene undo_scene() {
  return {.objects = {{.mesh = std::make_shared<const TriangleMesh>(make_icosphere(0.03, 3)),
                       .material = {.stiffness_n_per_m = 500.0},
                       .sculpt = SculptSettings{.voxel_m = 0.001, .tool_radius_m = 0.004, .button = 1}}}};
}

std::unique_ptr<TouchStep> undo_touch() {
  const TouchScene scene = undo_scene();
  return std::make_unique<TouchStep>(std::shared_ptr<ForceMethod>(*make_method({}, scene)), scene);
}

struct CarveUndoTaskTest : testing::Test {
  HapticsStep step{undo_touch(), 1e-5};
  const Sculpture uncarved = *step.touch().method().sculpture();
  CarveList list;  // the carves as a program receives them
  CarveUndoTask task{uncarved};
  std::uint64_t sample = 0;

  void note(const MadeCarve& made) {
    EXPECT_TRUE(list.add(made));
    task.note(made);
  }
  // Takes a step and does the work after its reply. Returns whether an undo was applied.
  bool cycle(bool is_down) {
    take_step(is_down);
    const auto undone = task.work(step);
    if (undone) note(*undone);
    return undone.has_value();
  }
  // Takes a step without the work after the reply. Returns whether the step carved.
  bool take_step(bool is_down) {
    ++sample;
    const double angle = 3e-3 * static_cast<double>(sample);
    const Vec3 p = (0.0315 + 0.004 * std::cos(5.0 * angle)) * Vec3(std::cos(angle), std::sin(angle), 0.1);
    step.offer(
        {.sample = sample, .sample_time_ns = 1'000'000 * static_cast<std::int64_t>(sample), .p_WD = p, .buttons = is_down ? 1U : 0U});
    step.reply();
    const MadeCarve* made = step.made_carve();
    if (made != nullptr) note(*made);
    return made != nullptr;
  }
  void carve(int presses) {
    for (int n = 0; n < 400 * presses; ++n) cycle(n % 400 < 250);
  }
  bool undo(std::uint32_t serial, bool is_down = false) {
    task.request(serial);
    for (int n = 0; n < 20'000; ++n) {
      if (cycle(is_down)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }
  // The felt shape is that of the list of carves, to the last bit.
  void expect_same_shape() {
    CarvedField twin = uncarved.bodies()[0].field;
    list.for_each_active({}, [&](const MadeCarve& made) { twin.carve(made.carve); });
    const CarvedField& felt = step.touch().method().sculpture()->bodies()[0].field;
    EXPECT_TRUE(std::equal(felt.values().begin(), felt.values().end(), twin.values().begin()));
    EXPECT_EQ(step.touch().newest_carve_serial(), list.newest());
  }
};

TEST_F(CarveUndoTaskTest, UndoesPressAfterPress) {
  carve(4);
  std::uint32_t before = list.count_active();
  ASSERT_GT(before, 60U);
  for (int n = 0; n < 3; ++n) {
    ASSERT_TRUE(undo(list.newest_active()));
    EXPECT_LT(list.count_active(), before);
    before = list.count_active();
    expect_same_shape();
  }
  // From here on, both copies get the same carves.
  carve(2);
  expect_same_shape();
  ASSERT_TRUE(undo(list.newest_active()));
  expect_same_shape();
  while (list.count_active() > 0) ASSERT_TRUE(undo(list.newest_active()));
  expect_same_shape();
}

TEST_F(CarveUndoTaskTest, AnUndoOfAnEarlierPressLeavesTheLaterOnes) {
  carve(3);
  const CarveRange first = list.find_press(1);
  ASSERT_LT(first.last, list.newest());
  ASSERT_TRUE(undo(1));
  EXPECT_FALSE(list.is_active(first.last));
  EXPECT_TRUE(list.is_active(first.last + 1));
  expect_same_shape();
}

TEST_F(CarveUndoTaskTest, UndoesWhileTheStylusCarves) {
  for (int round = 0; round < 5; ++round) {
    // The stylus leaves the body once in each wave of its path, and then begins to cut again.
    for (int n = 0; n < 500; ++n) cycle(true);
    ASSERT_GT(list.newest_active(), 0U);
    expect_same_shape();
    ASSERT_TRUE(undo(list.newest_active(), true));
    expect_same_shape();
  }
}

// When the bodies are exchanged, a few missing carves are added; if more are missing, the task first makes them in its own copy.
TEST_F(CarveUndoTaskTest, CarvesThatAreMadeWhileAnUndoWaitsAreKept) {
  for (const int carves_meanwhile : {1, 3, 4, 5, 20}) {
    SCOPED_TRACE(carves_meanwhile);
    carve(2);
    task.request(list.newest_active());
    std::this_thread::sleep_for(std::chrono::milliseconds(50));  // the undo is ready by now, unless the machine stalled
    for (int carves = 0, n = 0; carves < carves_meanwhile && n < 20'000; ++n) carves += take_step(true) ? 1 : 0;
    std::optional<MadeCarve> undone;
    for (int n = 0; n < 20'000 && !undone; ++n) {
      undone = task.work(step);
      if (undone) note(*undone);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_TRUE(undone);
    expect_same_shape();
  }
}

// The task's copy lacks carves that the task did not receive. If that copy were used, material would come back under the stylus.
TEST_F(CarveUndoTaskTest, NothingIsUndoneOnceThereWereTooManyCarvesAtOnce) {
  constexpr int kSide = 20;  // points of a cube within the ball, 1.5 mm apart
  int next = 0;
  const auto make_small_carve = [&] {
    const Vec3 at = 0.0015 * Vec3(next % kSide - kSide / 2, next / kSide % kSide - kSide / 2, next / (kSide * kSide) - kSide / 2);
    ++next;
    const Carve small{.from_m = at, .to_m = at, .radius_m = 0.001};
    EXPECT_TRUE(step.repeat_carve(0, small));
    return MadeCarve{.object = 0, .serial = step.touch().newest_carve_serial(), .carve = rounded(small), .begins = true};
  };
  std::vector<MadeCarve> all;
  for (int n = 0; n < 7'900; ++n) all.push_back(make_small_carve());
  for (const MadeCarve& made : all) task.note(made);
  const auto carve_and_wait = [&] {
    task.note(make_small_carve());
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_FALSE(task.work(step));
  };
  for (int n = 0; n < 10; ++n) carve_and_wait();
  const std::string log = log_of([&] {
    task.request(1);
    for (int n = 0; n < 10; ++n) carve_and_wait();
  });
  EXPECT_THAT(log, testing::HasSubstr("carves can no longer be undone"));
}

TEST_F(CarveUndoTaskTest, WhatIsUnknownOrUndoneChangesNothing) {
  carve(1);
  const std::uint32_t newest = list.newest();
  for (const std::uint32_t serial : {0U, newest + 1, 0xFFFFFFFFU}) {
    task.request(serial);
    for (int n = 0; n < 40; ++n) {
      EXPECT_FALSE(cycle(false)) << serial;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  ASSERT_TRUE(undo(newest));
  task.request(newest);
  for (int n = 0; n < 40; ++n) {
    EXPECT_FALSE(cycle(false));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  expect_same_shape();
}

TEST_F(CarveUndoTaskTest, TheLoopUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP();
  carve(1);
  task.request(list.newest_active());
  std::optional<MadeCarve> undone;
  for (int n = 0; n < 20'000 && !undone; ++n) {
    {
      const AllocationGuard guard;
      undone = task.work(step);
      if (undone) task.note(*undone);
      EXPECT_EQ(guard.count(), 0U);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(undone);
}

// Each carve that was read from a file counts as one press.
TEST(CarveUndoTaskOfAFile, UndoesWhatWasThereAtTheStart) {
  HapticsStep step(undo_touch(), 1e-5);
  const Sculpture uncarved = *step.touch().method().sculpture();
  std::vector<MadeCarve> made;
  for (const double x : {0.03, -0.03}) {
    const Carve carve{.from_m = {x, 0, 0}, .to_m = {x, 0.01, 0}, .radius_m = 0.004};
    ASSERT_TRUE(step.repeat_carve(0, carve));
    made.push_back({.object = 0, .serial = step.touch().newest_carve_serial(), .carve = rounded(carve), .begins = true});
  }
  CarveUndoTask task(uncarved, made);
  task.request(1);
  std::optional<MadeCarve> undone;
  for (int n = 0; n < 20'000 && !undone; ++n) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    undone = task.work(step);
  }
  ASSERT_TRUE(undone);
  EXPECT_EQ(undone->serial, 3U);
  EXPECT_EQ(undone->undone, (CarveRange{1, 1}));
  CarvedField twin = uncarved.bodies()[0].field;
  twin.carve(made[1].carve);
  const CarvedField& felt = step.touch().method().sculpture()->bodies()[0].field;
  EXPECT_TRUE(std::equal(felt.values().begin(), felt.values().end(), twin.values().begin()));
}

}  // namespace
}  // namespace hapton
