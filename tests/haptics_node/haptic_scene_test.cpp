#include "haptics_node/haptic_scene.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <variant>

#include "runtime/clock.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kTunedNPerM = 321.0;

TouchScene two_boxes_felt(double stiffness_n_per_m) {
  TouchScene scene;
  for (const double x : {0.0, 0.05}) {
    scene.objects.push_back({made::shared(made::box(Vec3(x, 0.0, 0.0), Vec3(x + 0.02, 0.02, 0.02))), {}});
    scene.objects.back().material.stiffness_n_per_m = stiffness_n_per_m;
  }
  return scene;
}

std::vector<Material> tuned_materials() {
  std::vector<Material> materials(2);
  for (Material& material : materials) material.stiffness_n_per_m = kTunedNPerM;
  return materials;
}

// The gains follow the scene that is felt; the hub gets the parts of that scene.
struct FeltSceneTest : testing::Test {
  // The stiffness in the parts and the messages about materials that the hub gets from now on; 0: none came.
  float sent_stiffness() {
    const SteadyClock clock;
    float stiffness = 0.0F;
    ++request;
    for (int n = 0; n < 1000; ++n) {
      patches.accept({.is_wanted = true, .request = request}, clock.now_ns());
      for (const Message* part = patches.front(); part != nullptr; part = patches.front()) {
        if (const auto* tile = std::get_if<PatchTile>(part)) stiffness = static_cast<float>(tile->stiffness_n_per_m);
        if (const auto* material = std::get_if<PatchMaterial>(part)) stiffness = static_cast<float>(material->stiffness_n_per_m);
        patches.pop();
      }
      if (stiffness != 0.0F && n > 50) return stiffness;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return stiffness;
  }

  PatchSender patches{two_boxes_felt(1000.0), 0.0, 7, true, {.bits_per_s = 1e8, .least_reach_m = 1.0}};
  StiffnessAdviser adviser{{}};
  InsideBodyWarning warning{two_boxes_felt(1000.0)};
  double gain_n_per_m = 0.0;
  std::uint32_t request = 1;
  HapticScene haptic_scene{two_boxes_felt(1000.0),
                           [this](const TouchScene& scene) {
                             gain_n_per_m = scene.objects[1].material.stiffness_n_per_m;
                             return find_largest_gains(scene);
                           },
                           adviser, warning, patches};
};

// The scene with an object put down is built meanwhile, and does not contain a change of materials that comes during this time.
TEST_F(FeltSceneTest, WhatWasTunedMeanwhileIsFeltWhereAnObjectWasPutDown) {
  haptic_scene.tune(tuned_materials());
  EXPECT_EQ(gain_n_per_m, kTunedNPerM);
  haptic_scene.place(two_boxes_felt(1000.0), 3);
  EXPECT_EQ(gain_n_per_m, kTunedNPerM);
  EXPECT_EQ(patches.revision(), 3U);
  EXPECT_EQ(sent_stiffness(), static_cast<float>(kTunedNPerM));
}

TEST_F(FeltSceneTest, AnotherSceneHasMaterialsOfItsOwn) {
  haptic_scene.tune(tuned_materials());
  haptic_scene.follow(two_boxes_felt(700.0));
  EXPECT_EQ(gain_n_per_m, 700.0);
  EXPECT_EQ(sent_stiffness(), 700.0F);
  haptic_scene.place(two_boxes_felt(700.0), 4);
  EXPECT_EQ(gain_n_per_m, 700.0) << "the materials set before belonged to the former scene";
  EXPECT_EQ(sent_stiffness(), 700.0F);
}

}  // namespace
}  // namespace hapton
