// The time of objects that move by keyframes, as HapticsStep keeps it.
#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "haptic_step/haptics_step.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kSceneTimeOffsetM = 1e-5;  // at which a new method starts off the surface

// A plate whose top rises from 0 by 100 mm a second, for a second.
TouchScene rising_plate(bool moves = true) {
  TouchScene scene;
  scene.objects.push_back({.mesh = made::shared(made::box({-0.05, -0.05, -0.02}, {0.05, 0.05, 0.0})), .material = {}});
  if (moves) {
    scene.objects[0].motion = std::make_shared<const KeyframeMotion>(
        Vec3::Zero(), std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()}, {1.0, Vec3(0, 0, 0.1), Quat::Identity()}}, false);
  }
  return scene;
}

std::unique_ptr<TouchStep> touch_of(const TouchScene& scene) { return std::make_unique<TouchStep>(*make_method({}, scene), scene); }

struct SceneTime : testing::Test {
  HapticsStep step{touch_of(rising_plate()), kSceneTimeOffsetM};
  std::uint64_t sample = 100;
  std::int64_t time_ns = 7'000'000'000;

  ForceCommand reply_to(std::int64_t after_ns, const Vec3& p_WD = {0, 0, 0.03}) {
    time_ns += after_ns;
    step.offer({.sample = ++sample, .sample_time_ns = time_ns, .p_WD = p_WD});
    return step.reply();
  }
};

TEST_F(SceneTime, BeginsWithTheFirstReplyAndRunsWithTheSamples) {
  EXPECT_EQ(reply_to(0).scene_time_ns, 0);
  EXPECT_EQ(reply_to(1'000'000).scene_time_ns, 1'000'000);
  EXPECT_EQ(reply_to(4'000'000).scene_time_ns, 5'000'000);
}

// The force is that of the plate at its pose at the scene time in the reply.
TEST_F(SceneTime, TheForceIsThatOfTheTimeInTheReply) {
  const Vec3 hand(0.01, 0.0, 0.005);
  reply_to(0, hand);
  for (int i = 0; i < 200; ++i) {
    const ForceCommand reply = reply_to(1'000'000, hand);
    const double top = 0.1 * 1e-9 * static_cast<double>(reply.scene_time_ns);
    ASSERT_NEAR(reply.force_n.z(), 1000.0 * std::max(0.0, top - hand.z()), 1e-3) << i;
  }
}

TEST_F(SceneTime, AdvancesByAtMost50MsInAGapAndNotBetweenSessions) {
  reply_to(0);
  reply_to(10'000'000);
  EXPECT_EQ(reply_to(3'000'000'000).scene_time_ns, 10'000'000 + HapticsStep::kMaxSceneStepNs);
  step.resume();
  EXPECT_EQ(reply_to(5'000'000'000).scene_time_ns, 60'000'000);
  EXPECT_EQ(reply_to(1'000'000).scene_time_ns, 61'000'000);
  EXPECT_EQ(reply_to(-500'000'000).scene_time_ns, 61'000'000) << "another hub's clock";
}

// The hand rests on the surface while the hub restarts: the same force before and after.
TEST_F(SceneTime, ContactGoesOnInTheNextSession) {
  const Vec3 hand(0.01, 0.0, 0.001);
  reply_to(0, {0.01, 0.0, 0.002});
  ForceCommand before;
  for (int i = 0; i < 30; ++i) before = reply_to(1'000'000, hand);
  EXPECT_NEAR(before.force_n.z(), 2.0, 1e-2);
  step.resume();
  const ForceCommand after = reply_to(10'000'000'000, hand);
  EXPECT_NEAR(after.force_n.z(), before.force_n.z(), 1e-2);
}

TEST_F(SceneTime, CanBeSet) {
  reply_to(0);
  step.set_scene_time(400'000'000);
  EXPECT_EQ(reply_to(1'000'000).scene_time_ns, 400'000'000);
  EXPECT_EQ(reply_to(1'000'000).scene_time_ns, 401'000'000);
}

// A scene is read again: the moving object continues from where it is, and the force fades.
TEST_F(SceneTime, GoesOnWithAnotherMethod) {
  const Vec3 hand(0.01, 0.0, 0.001);
  reply_to(0, {0.01, 0.0, 0.002});
  ForceCommand before;
  for (int i = 0; i < 30; ++i) before = reply_to(1'000'000, hand);
  (void)step.replace(touch_of(rising_plate()));
  const ForceCommand after = reply_to(1'000'000, hand);
  EXPECT_EQ(after.scene_time_ns, before.scene_time_ns + 1'000'000);
  EXPECT_NEAR(after.force_n.z(), before.force_n.z(), 2e-2);
  ForceCommand later;
  for (int i = 0; i < 300; ++i) later = reply_to(1'000'000, hand);
  EXPECT_NEAR(later.force_n.z(), 1000.0 * (0.1 * 1e-9 * static_cast<double>(later.scene_time_ns) - hand.z()), 0.1);
}

// Vision nodes get only changes that can be seen, so the time of a still scene stays 0.
TEST(SceneTimeOfStillScenes, Is0) {
  HapticsStep step(touch_of(rising_plate(false)), kSceneTimeOffsetM);
  for (std::uint64_t i = 1; i < 5; ++i) {
    step.offer({.sample = i, .sample_time_ns = 1'000'000 * static_cast<std::int64_t>(i)});
    EXPECT_EQ(step.reply().scene_time_ns, 0);
  }
}

TEST_F(SceneTime, TakesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  reply_to(0, {0, 0, 0.002});
  const AllocationGuard guard;
  double largest_force_n = 0.0;
  for (int i = 0; i < 200; ++i) largest_force_n = std::max(largest_force_n, reply_to(1'000'000, {0, 0, 0.002}).force_n.z());
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(largest_force_n, 10.0);
}

// While the hub computes the force, it sets the scene time, also across a gap; afterwards the time continues from that value.
TEST_F(SceneTime, IsThatOfAHubThatComputesTheForce) {
  reply_to(0);
  time_ns += 300'000'000;
  step.offer({.sample = ++sample, .sample_time_ns = time_ns, .p_WD = {0, 0, 0.03}, .scene_time_ns = 300'000'000});
  EXPECT_EQ(step.reply().scene_time_ns, 300'000'000);
  EXPECT_EQ(reply_to(1'000'000).scene_time_ns, 301'000'000);
  step.offer({.sample = ++sample, .sample_time_ns = time_ns, .p_WD = {0, 0, 0.03}, .scene_time_ns = 295'000'000});
  EXPECT_EQ(step.reply().scene_time_ns, 295'000'000) << "the hub waited";
}

}  // namespace
}  // namespace hapton
