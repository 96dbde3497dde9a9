#include "haptic_step/material_tuning.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/force/virtual_coupling.h"
#include "scene/scene_file.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

using testing::HasSubstr;

Scene scene_of(const std::vector<std::string>& names) {
  Scene scene;
  for (const std::string& name : names)
    scene.objects.push_back({.name = name, .mesh = made::shared(made::sheet(0.1, 0.0, 2)), .material = {}});
  return scene;
}

MaterialRequest request(const std::string& object, const MaterialChange& change) {
  MaterialRequest made{.request = 1, .change = change};
  std::copy(object.begin(), object.end(), made.object.begin());
  return made;
}

MaterialChange stiffness(double n_per_m) { return {.fields = MaterialChange::kStiffness, .stiffness_n_per_m = n_per_m}; }
MaterialChange friction(double both) {
  return {.fields = MaterialChange::kFrictionStatic | MaterialChange::kFrictionDynamic, .friction_static = both, .friction_dynamic = both};
}

struct TunedScene : testing::Test {
  const Scene scene = scene_of({"hull", "deck", "mast", "deck"});
  MaterialTuning tuning{scene};

  std::string change(const std::string& object, const MaterialChange& change) {
    const auto done = tuning.change(request(object, change));
    return done ? std::string() : done.error().what;
  }
  std::vector<double> stiffnesses() {
    std::vector<double> all;
    for (const Material& m : tuned_materials(scene.touch_scene(), tuning.state(), 0.0)) all.push_back(m.stiffness_n_per_m);
    return all;
  }
};

TEST_F(TunedScene, OneObjectOrAllOfANameOrAllChange) {
  EXPECT_EQ(change("hull", stiffness(800.0)), "");
  EXPECT_EQ(stiffnesses(), (std::vector{800.0, 1000.0, 1000.0, 1000.0}));
  EXPECT_EQ(tuning.describe_last(), "object 'hull': stiffness 800 N/m, damping 0 Ns/m, friction 0 / 0 (static / dynamic)");
  EXPECT_EQ(change("deck", stiffness(600.0)), "");
  EXPECT_EQ(stiffnesses(), (std::vector{800.0, 600.0, 1000.0, 600.0}));
  EXPECT_EQ(tuning.describe_last(), "2 objects, the first: stiffness 600 N/m, damping 0 Ns/m, friction 0 / 0 (static / dynamic)");
  EXPECT_EQ(change("", stiffness(500.0)), "");
  EXPECT_EQ(stiffnesses(), (std::vector{500.0, 500.0, 500.0, 500.0})) << "this replaces the earlier changes of single objects";
  EXPECT_EQ(tuning.state().object_count, 1U);
  EXPECT_EQ(change("mast", stiffness(900.0)), "");
  EXPECT_EQ(stiffnesses(), (std::vector{500.0, 500.0, 900.0, 500.0}));
  EXPECT_EQ(tuning.describe_last(), "object 'mast': stiffness 900 N/m, damping 0 Ns/m, friction 0 / 0 (static / dynamic)");
}

TEST_F(TunedScene, WhatTheSceneFileSaysNowIsNoChangeOfTheLastRequest) {
  const std::string nothing = tuning.describe_last();
  EXPECT_EQ(change("hull", stiffness(800.0)), "");
  EXPECT_NE(tuning.describe_last(), nothing);
  tuning.reset_to(MaterialState());
  EXPECT_EQ(tuning.describe_last(), nothing);
}

TEST_F(TunedScene, NumbersThatAreNotGivenStay) {
  EXPECT_EQ(change("hull", stiffness(800.0)), "");
  EXPECT_EQ(change("", friction(0.4)), "");
  EXPECT_EQ(change("hull", {.fields = MaterialChange::kDamping, .damping_ns_per_m = 1.5}), "");
  const Material hull = tuned_materials(scene.touch_scene(), tuning.state(), 0.0)[0];
  EXPECT_EQ(hull.stiffness_n_per_m, 800.0);
  EXPECT_EQ(hull.damping_ns_per_m, 1.5);
  EXPECT_EQ(hull.friction_static, 0.4);
  EXPECT_EQ(hull.friction_dynamic, 0.4);
  EXPECT_TRUE(hull.two_sided);
}

TEST_F(TunedScene, AnUnknownObjectIsRejectedWithTheNearestName) {
  EXPECT_EQ(change("hul", stiffness(800.0)), "the scene has no object 'hul'; did you mean 'hull'?");
  EXPECT_THAT(change("keel of the ship", stiffness(800.0)), HasSubstr("known are hull, deck, mast"));
  EXPECT_EQ(tuning.state().object_count, 0U);
}

TEST_F(TunedScene, AChangeIsOfAllOrOfNone) {
  EXPECT_EQ(change("mast", friction(0.3)), "");
  // The mast alone would have less static than dynamic friction.
  EXPECT_THAT(change("", {.fields = MaterialChange::kFrictionStatic, .friction_static = 0.2}),
              HasSubstr("'friction_dynamic' of object 'mast' is 0.3"));
  EXPECT_EQ(tuned_materials(scene.touch_scene(), tuning.state(), 0.0)[0].friction_static, 0.0);
}

TEST_F(TunedScene, WhatASceneFileCouldNotHaveIsRejectedAndChangesNothing) {
  EXPECT_EQ(change("hull", friction(0.4)), "");
  EXPECT_THAT(change("hull", {.fields = MaterialChange::kFrictionDynamic, .friction_dynamic = 0.5}),
              HasSubstr("more than 'friction_static' 0.4"));
  EXPECT_THAT(change("", stiffness(2e6)), HasSubstr("at most 1000000"));
  EXPECT_EQ(stiffnesses(), (std::vector{1000.0, 1000.0, 1000.0, 1000.0}));
  EXPECT_EQ(tuned_materials(scene.touch_scene(), tuning.state(), 0.0)[0].friction_dynamic, 0.4);
}

// A change of all objects fails if one cannot take it: the error says how to change the others.
TEST(MaterialTuningOfLayers, TheOtherObjectsCanBeNamed) {
  Scene scene = scene_of({"hull", "tissue"});
  scene.objects[1].effects.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 400.0});
  MaterialTuning tuning(scene);
  const auto all = tuning.change(request("", stiffness(700.0)));
  ASSERT_FALSE(all);
  EXPECT_THAT(all.error().what, HasSubstr("object 'tissue' has layers"));
  EXPECT_THAT(all.error().what, HasSubstr("; or change one of the others (--object NAME)"));
  EXPECT_THAT(tuning.change(request("", stiffness(2e6))).error().what, testing::Not(HasSubstr("--object"))) << "no object takes it";
  const auto one = tuning.change(request("tissue", stiffness(700.0)));
  ASSERT_FALSE(one);
  EXPECT_THAT(one.error().what, testing::Not(HasSubstr("--object")));
  EXPECT_TRUE(tuning.change(request("hull", stiffness(700.0))));
}

TEST_F(TunedScene, MaterialsAreCoupledAsMethodsMakeThem) {
  EXPECT_EQ(change("hull", stiffness(3000.0)), "");
  const auto materials = tuned_materials(scene.touch_scene(), tuning.state(), 1500.0);
  EXPECT_EQ(materials[0].stiffness_n_per_m, couple_material({.stiffness_n_per_m = 3000.0}, 1500.0).stiffness_n_per_m);
  EXPECT_EQ(materials[0].stiffness_n_per_m, 1000.0);
}

TEST(MaterialTuningLimit, MoreObjectsThanAMessageHoldsAreRejected) {
  std::vector<std::string> names;
  for (int i = 0; i < 30; ++i) names.push_back("part " + std::to_string(i));
  MaterialTuning tuning(scene_of(names));
  for (std::size_t i = MaterialState::kMaxObjects; i-- > 0;) ASSERT_TRUE(tuning.change(request(names[i], stiffness(500.0 + double(i)))));
  const auto one_more = tuning.change(request(names[25], stiffness(500.0)));
  ASSERT_FALSE(one_more);
  EXPECT_THAT(one_more.error().what, HasSubstr("no more than 20 objects"));
  EXPECT_TRUE(tuning.change(request(names[3], stiffness(700.0)))) << "a known one may change again";
  // The state lists the objects in the order that the codec requires.
  for (std::size_t i = 0; i < MaterialState::kMaxObjects; ++i) EXPECT_EQ(tuning.state().objects[i].object, static_cast<int>(i));
  EXPECT_TRUE(tuning.change(request("", stiffness(400.0))));
  EXPECT_EQ(tuning.state().object_count, 1U);
}

}  // namespace
}  // namespace hapton
