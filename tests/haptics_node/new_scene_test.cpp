#include "haptics_node/new_scene.h"

#include <gtest/gtest.h>

#include "haptic_step/scene_facts.h"
#include "scene/scene_hash.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kCouplingOfNewScenes = 1000.0;  // N/m

Scene scene_of_two() {
  Scene scene;
  for (const double stiffness_n_per_m : {500.0, 1000.0}) {
    SceneObject object;
    object.mesh = made::shared(made::sheet(0.1, 0.0, 2));
    object.material.stiffness_n_per_m = stiffness_n_per_m;
    scene.objects.push_back(object);
  }
  return scene;
}

TEST(NewSceneOf, AFileHasItsHashAndFactsAndNothingPutDown) {
  const Scene scene = scene_of_two();
  const auto made = make_new_scene(scene, kCouplingOfNewScenes, 7, true);
  EXPECT_EQ(made->revision, 7U);
  EXPECT_EQ(made->put_down_serial, 0U);
  EXPECT_TRUE(made->keeps_shape);
  EXPECT_EQ(made->hash, hash_scene(scene.touch_scene()));
  EXPECT_EQ(made->facts.given_hash, make_scene_facts(scene).given_hash);
}

TEST(NewSceneOf, AnObjectPutDownHasItsSerial) {
  const auto made = make_placed_scene(scene_of_two(), kCouplingOfNewScenes, 7, 3);
  EXPECT_EQ(made->revision, 7U);
  EXPECT_EQ(made->put_down_serial, 3U);
}

// Material and coupling are two springs in series.
TEST(NewSceneOf, MaterialsAreCoupled) {
  const auto made = make_placed_scene(scene_of_two(), kCouplingOfNewScenes, 1, 0);
  ASSERT_EQ(made->materials.size(), 2U);
  EXPECT_NEAR(made->materials[0].stiffness_n_per_m, 1000.0 / 3.0, 1e-9);
  EXPECT_NEAR(made->materials[1].stiffness_n_per_m, 500.0, 1e-9);
}

}  // namespace
}  // namespace hapton
