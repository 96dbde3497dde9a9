#include "haptics_node/scene_describer.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
#include <thread>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "haptic_step/scene_facts.h"
#include "scene/scene_hash.h"

namespace hapton {
namespace {

Scene scene_of_a_box(double side) {
  Scene scene;
  SceneObject object;
  object.name = "box";
  object.mesh = std::make_shared<const TriangleMesh>(make_box(Vec3::Constant(side)));
  scene.objects.push_back(object);
  return scene;
}

bool wait_for(Mailbox<PlacedScene>& placed) {
  for (int i = 0; i < 30'000; ++i) {
    if (placed.take()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

TEST(SceneDescriber, FindsHashAndFactsOfAScene) {
  const Scene scene = scene_of_a_box(0.02);
  Mailbox<PlacedScene> placed;
  SceneDescriber describer(placed);
  describer.describe(scene, 3);
  ASSERT_TRUE(wait_for(placed));
  EXPECT_EQ(placed.value().revision, 3U);
  EXPECT_EQ(placed.value().hash, hash_scene(scene.touch_scene()));
  EXPECT_EQ(placed.value().facts.highest_m, make_scene_facts(scene).highest_m);
  EXPECT_FALSE(placed.take());
}

// The test delays the end of the first description; describe() returns meanwhile without waiting for it.
TEST(SceneDescriber, NobodyWaitsForADescriptionAndOnlyTheNewestIsMade) {
  std::promise<void> begun;
  std::promise<void> may_end;
  std::vector<std::uint32_t> described;
  Mailbox<PlacedScene> placed;
  SceneDescriber describer(placed, [&](const Scene&, std::uint32_t revision) {
    described.push_back(revision);
    if (revision == 1) {
      begun.set_value();
      may_end.get_future().wait();
    }
    PlacedScene made;
    made.revision = revision;
    return made;
  });
  describer.describe(scene_of_a_box(0.01), 1);
  begun.get_future().wait();
  for (std::uint32_t revision = 2; revision <= 4; ++revision) describer.describe(scene_of_a_box(0.01), revision);
  EXPECT_FALSE(placed.take());
  may_end.set_value();
  for (int i = 0; i < 10 && placed.value().revision != 4; ++i) ASSERT_TRUE(wait_for(placed));
  EXPECT_EQ(placed.value().revision, 4U);
  EXPECT_EQ(described, (std::vector<std::uint32_t>{1, 4}));
}

}  // namespace
}  // namespace hapton
