// Objects that programs move (TouchObject::command_pivot), as TouchStep and MovingMethod handle them.
#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "core/force/moving_method.h"
#include "core/force/touch_step.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

const Vec3 kPlatePivot(-0.05, 0.0, 0.0);

// A floor that stands still, and a plate above it: object 1.
TouchScene floor_and_plate() {
  TouchScene scene;
  scene.objects.push_back({.mesh = made::shared(made::box({-0.1, -0.1, -0.05}, {0.1, 0.1, -0.04})), .material = {}});
  scene.objects.push_back({.mesh = made::shared(made::box({-0.05, -0.05, 0.0}, {0.05, 0.05, 0.004})), .material = {}});
  return scene;
}

TouchScene commanded_scene() {
  TouchScene scene = floor_and_plate();
  scene.objects[1].command_pivot = kPlatePivot;
  return scene;
}

std::unique_ptr<TouchStep> touch_with(const TouchScene& scene, const char* method = "proxy") {
  auto made = make_method({.name = method}, scene);
  EXPECT_TRUE(made) << (made ? "" : made.error().what);
  return std::make_unique<TouchStep>(std::move(*made), scene);
}

// A motion that begins at the rest pose of the object, and lifts and turns it.
std::vector<Keyframe> lift_keyframes() {
  return {{0.1, kPlatePivot, Quat::Identity()}, {0.5, kPlatePivot + Vec3(0.0, 0.0, 0.02), Quat(Eigen::AngleAxisd(0.4, -Vec3::UnitY()))}};
}

bool has_same_bits(const TouchOutput& a, const TouchOutput& b) {
  return a.contact == b.contact && a.object == b.object && std::memcmp(a.force_n.data(), b.force_n.data(), 3 * sizeof(double)) == 0 &&
         std::memcmp(a.visual_offset_m.data(), b.visual_offset_m.data(), 3 * sizeof(double)) == 0;
}

class CommandedObjects : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Methods, CommandedObjects, testing::Values("proxy", "reference"), [](const auto& given) { return given.param; });

// The forces are the same to the last bit as those of an object that has these keyframes in the scene.
TEST_P(CommandedObjects, AreFeltAsThoseWithKeyframes) {
  const std::vector<Keyframe> keys = lift_keyframes();
  TouchScene by_keyframes = floor_and_plate();
  by_keyframes.objects[1].motion = std::make_shared<const KeyframeMotion>(kPlatePivot, keys, false);
  const auto keyframed = touch_with(by_keyframes, GetParam());
  const auto commanded = touch_with(commanded_scene(), GetParam());
  const auto method_of = [](const TouchStep& touch) { return dynamic_cast<const MovingMethod*>(&touch.method()); };
  ASSERT_TRUE(method_of(*keyframed) != nullptr && method_of(*commanded) != nullptr);
  int contacts = 0;
  double most_n = 0.0;
  for (int i = 0; i < 700; ++i) {
    const TouchInput input{.p_WD = {0.02, 0.01, 0.012}, .dt_s = 1e-3, .time_s = 1e-3 * i};
    if (i == 100) {
      ASSERT_TRUE(commanded->command(1, {.serial = 1, .from = keys[0], .to = keys[1]}));
    }
    const TouchOutput a = keyframed->step(input);
    const TouchOutput b = commanded->step(input);
    ASSERT_TRUE(has_same_bits(a, b)) << i << ": " << a.force_n.transpose() << " / " << b.force_n.transpose();
    contacts += a.contact ? 1 : 0;
    most_n = std::max(most_n, a.force_n.norm());
  }
  EXPECT_GT(contacts, 300);
  EXPECT_GT(most_n, 5.0);
}

TEST(CommandedObjectsOfAStep, AreFeltWhereTheSceneHasThemUntilTheyMove) {
  const auto touch = touch_with(commanded_scene());
  EXPECT_TRUE(touch->has_motion());
  EXPECT_EQ(touch->commanded_objects(), std::vector<int>{1});
  for (int i = 0; i < 20; ++i) {
    const TouchOutput felt = touch->step({.p_WD = {0.0, 0.0, 0.006 - 0.0005 * i}, .time_s = 1e-3 * i});
    const double depth = std::max(0.0, 0.004 - (0.006 - 0.0005 * i));
    ASSERT_NEAR(felt.force_n.z(), 1000.0 * depth, 1e-4) << i;
    if (depth > 1e-4) {
      ASSERT_EQ(felt.object, 1);
    }
  }
}

TEST(CommandedObjectsOfAStep, OthersCannotBeMoved) {
  const auto touch = touch_with(commanded_scene());
  const CommandedMove move{.serial = 1, .from = lift_keyframes()[0], .to = lift_keyframes()[1]};
  for (const int object : {-1, 0, 2, 1000}) {
    EXPECT_FALSE(touch->command(object, move)) << object;
    EXPECT_EQ(touch->find_commanded(object), nullptr) << object;
  }
  EXPECT_TRUE(touch->command(1, move));
  EXPECT_FALSE(touch->command(1, move)) << "the same again";
  EXPECT_EQ(touch->find_commanded(1)->newest().serial, 1U);
  EXPECT_FALSE(touch_with(floor_and_plate())->has_motion());
}

// Each has its own frame: the method and the step use the same index for it (MethodInput::commanded).
TEST(CommandedObjectsOfAStep, EachMovesByItself) {
  TouchScene scene = commanded_scene();
  scene.objects.push_back({.mesh = made::shared(made::box({0.2, -0.05, 0.0}, {0.3, 0.05, 0.004})), .material = {}});
  scene.objects[2].command_pivot = Vec3::Zero();
  const auto touch = touch_with(scene);
  const Keyframe up{1.0, Vec3(0, 0, 0.05), Quat::Identity()};
  touch->command(2, {.serial = 1, .from = {0.0, Vec3::Zero(), Quat::Identity()}, .to = up});
  const auto press = [&](const Vec3& hand) {
    touch->reset({.p_WD = hand + Vec3(0, 0, 0.01), .time_s = 2.0});
    touch->step({.p_WD = hand + Vec3(0, 0, 0.01), .time_s = 2.0});
    return touch->step({.p_WD = hand, .time_s = 2.0});
  };
  EXPECT_NEAR(press({0.25, 0.0, 0.053}).force_n.z(), 1.0, 1e-3) << "moved up";
  EXPECT_EQ(press({0.25, 0.0, 0.053}).object, 2);
  EXPECT_NEAR(press({0.0, 0.0, 0.003}).force_n.z(), 1.0, 1e-3) << "the other stays";
}

// All samples after the end of a move have its final pose, also if the move takes no time.
TEST(CommandedObjectsOfAStep, AMoveWithoutTimeIsFelt) {
  const auto touch = touch_with(commanded_scene());
  const Vec3 hand(0.0, 0.0, 0.007);
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(touch->step({.p_WD = hand, .time_s = 1.0}).contact);
  const Keyframe here{1.0, kPlatePivot, Quat::Identity()};
  touch->command(1, {.serial = 1, .from = here, .to = {1.0, kPlatePivot + Vec3(0, 0, 0.005), Quat::Identity()}});
  EXPECT_FALSE(touch->step({.p_WD = hand, .time_s = 1.0}).contact) << "not at its start";
  EXPECT_TRUE(touch->step({.p_WD = hand, .time_s = 1.001}).contact);
  EXPECT_NEAR(touch->step({.p_WD = hand, .time_s = 1.002}).force_n.z(), 2.0, 1e-3);
}

TEST(CommandedObjectsOfAStep, AnotherMethodHasThemWhereTheyAre) {
  const auto before = touch_with(commanded_scene());
  before->command(1, {.serial = 3, .from = lift_keyframes()[0], .to = lift_keyframes()[1]});
  const auto after = touch_with(commanded_scene());
  after->copy_commands(*before);
  bool is_touched = false;
  for (int i = 0; i < 300; ++i) {
    const TouchInput input{.p_WD = {0.02, 0.01, 0.012}, .time_s = 0.1 + 1e-3 * i};
    const TouchOutput felt = before->step(input);
    ASSERT_TRUE(has_same_bits(felt, after->step(input))) << i;
    is_touched = felt.contact;
  }
  EXPECT_TRUE(is_touched);
  const auto other = touch_with(floor_and_plate());
  other->copy_commands(*before);
  EXPECT_TRUE(other->commanded_objects().empty());
}

TEST(CommandedObjectsOfAStep, TakeNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  const auto touch = touch_with(commanded_scene());
  touch->step({.p_WD = {0.02, 0.01, 0.012}});
  double most_n = 0.0;
  const AllocationGuard guard;
  for (int i = 0; i < 400; ++i) {
    const Keyframe to{0.0, kPlatePivot + Vec3(0, 0, i % 2 == 0 ? 0.02 : 0.01), Quat::Identity()};
    const auto serial = static_cast<std::uint32_t>(i + 1);
    touch->command(1, make_move(*touch->find_commanded(1), serial, 1e-3 * i, to, 0.0, 0.1, 0.25));
    most_n = std::max(most_n, touch->step({.p_WD = {0.02, 0.01, 0.012}, .time_s = 1e-3 * (i + 1)}).force_n.norm());
  }
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(most_n, 1.0);
}

}  // namespace
}  // namespace hapton
