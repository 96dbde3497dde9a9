#include "scene/commanded_object.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "scene/scene_file.h"
#include "scene/scene_hash.h"
#include "scene/scene_report.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

constexpr const char* kFlapMesh = "v 0 0 0\nv 100 0 0\nv 0 100 0\nf 1 2 3\n";  // mm

struct CommandedObjectTest : testing::Test {
  ScratchFolder folder;
  CommandedObjectTest() { folder.write("flap.obj", kFlapMesh); }

  Result<Scene> load(const std::string& keys, const std::string& before = "", const std::string& after = "") {
    folder.write("scene.toml", before + "[[object]]\nname = \"flap\"\nmesh = \"flap.obj\"\nunit = \"mm\"\n" + keys + after);
    return load_scene(folder.path() / "scene.toml");
  }
  std::string error_of(const std::string& keys, const std::string& after = "") {
    const auto scene = load(keys, "", after);
    return scene ? "none" : scene.error().what;
  }
};

TEST_F(CommandedObjectTest, AnObjectIsMovedByProgramsWhereTheSceneFileSaysSo) {
  const auto scene = load("moved_by = \"program\"\nposition_m = [0.1, 0.2, 0.3]\npivot_m = [0.01, 0, 0]\n");
  ASSERT_TRUE(scene) << scene.error().what;
  const SceneObject& flap = scene->objects[0];
  ASSERT_TRUE(flap.commanded);
  EXPECT_TRUE(flap.moves());
  EXPECT_FALSE(flap.is_movable);
  EXPECT_LT((flap.commanded->pivot() - Vec3(0.11, 0.2, 0.3)).norm(), 1e-15);
  EXPECT_NEAR(flap.commanded->radius_m(), std::hypot(0.01, 0.1), 1e-15) << "the corner farthest from the pivot";
  EXPECT_EQ(scene->touch_scene().objects[0].command_pivot, flap.commanded->pivot());
  EXPECT_TRUE(scene->touch_scene().has_motion());
  EXPECT_FALSE(load("")->touch_scene().has_motion());
}

// A commanded pose means the same as position_m and rotation in the scene file: the object goes where the file would have put it.
TEST_F(CommandedObjectTest, APoseIsThatOfTheSceneFile) {
  const std::string fit = "fit_m = [0.05, 0.05, 0.05]\n";
  const std::string rest = "scale = 2.0\nposition_m = [0.1, 0.2, 0.3]\nrotation_deg = [10, 20, 30]\npivot_m = [0.02, 0.01, 0]\n";
  for (const std::string& before : {std::string(), fit}) {
    const auto scene = load("moved_by = \"program\"\n" + rest, before);
    ASSERT_TRUE(scene) << scene.error().what;
    const CommandedObject& flap = *scene->objects[0].commanded;
    const Quat commanded_rotation(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
    const Vec3 commanded_position(-0.3, 0.1, 0.05);
    const Keyframe now{0.0, flap.pivot(), Quat::Identity()};
    const Keyframe placed = flap.place(commanded_position, commanded_rotation, now);
    const Pose X_SO = pose_of(placed, flap.pivot());
    const double fit_scale = scene->fit_scale;
    const SceneObject& at_rest = scene->objects[0];
    const Quat q_rest(Eigen::AngleAxisd(std::numbers::pi / 6, Vec3::UnitZ()) * Eigen::AngleAxisd(std::numbers::pi / 9, Vec3::UnitY()) *
                      Eigen::AngleAxisd(std::numbers::pi / 18, Vec3::UnitX()));
    for (std::size_t v = 0; v < 3; ++v) {
      const Vec3 in_mesh(v == 1 ? 0.1 : 0.0, v == 2 ? 0.1 : 0.0, 0.0);
      // Compared with the pose at rest, because fit_m also shifts the scene.
      const Vec3 displacement =
          fit_scale * ((commanded_position + commanded_rotation * (2.0 * in_mesh)) - (Vec3(0.1, 0.2, 0.3) + q_rest * (2.0 * in_mesh)));
      EXPECT_LT((X_SO * at_rest.mesh->vertices[v] - (at_rest.mesh->vertices[v] + displacement)).norm(), 1e-12) << v << before;
    }
  }
}

TEST_F(CommandedObjectTest, FindPlaceIsTheInverseOfPlace) {
  for (const std::string& before : {std::string(), std::string("fit_m = [0.05, 0.05, 0.05]\n")}) {
    const auto scene =
        load("moved_by = \"program\"\nscale = 2.0\nposition_m = [0.1, 0.2, 0.3]\nrotation_deg = [10, 20, 30]\npivot_m = [0.02, 0.01, 0]\n",
             before);
    ASSERT_TRUE(scene) << scene.error().what;
    const CommandedObject& flap = *scene->objects[0].commanded;
    const ObjectPlace at_rest = flap.find_place({.p_S = flap.pivot()});
    EXPECT_LT((at_rest.p_FM - Vec3(0.1, 0.2, 0.3)).norm(), 1e-14) << "as the file has it";
    const Keyframe there{.p_S = {0.4, -0.1, 0.2}, .turn = Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()))};
    const ObjectPlace found = flap.find_place(there);
    const Keyframe placed = flap.place(found.p_FM, found.q_FM, {});
    EXPECT_LT((placed.p_S - there.p_S).norm(), 1e-14);
    EXPECT_LT(placed.turn.angularDistance(there.turn), 1e-7);
  }
}

// A commanded pose means a pose of the scene file also if [workspace] turns the scene: the pose in the file gives the pose at rest.
TEST_F(CommandedObjectTest, APoseIsThatOfTheSceneFileInATurnedWorkspaceToo) {
  const std::string workspace = "[workspace]\ncenter_m = [0.1, 0.2, 0.0]\nrotation_deg = [0, 0, 90]\nscale = 2.0\n";
  const std::string keys = "moved_by = \"program\"\nrotation_deg = [0, 0, 30]\npivot_m = [0.02, 0.01, 0]\n";
  const auto scene = load(keys + "position_m = [0.1, 0.2, 0.3]\n", "", workspace);
  ASSERT_TRUE(scene) << scene.error().what;
  const auto moved = load(keys + "position_m = [0.3, 0.1, 0.0]\n", "", workspace);
  ASSERT_TRUE(moved) << moved.error().what;
  const CommandedObject& flap = *scene->objects[0].commanded;
  const Keyframe now{0.0, flap.pivot(), Quat::Identity()};
  const Quat in_file(Eigen::AngleAxisd(std::numbers::pi / 6, Vec3::UnitZ()));
  const Keyframe same = flap.place(Vec3(0.1, 0.2, 0.3), in_file, now);
  EXPECT_LT((same.p_S - flap.pivot()).norm(), 1e-14);
  EXPECT_LT(same.turn.angularDistance(Quat::Identity()), 1e-7);
  const Pose X_SO = pose_of(flap.place(Vec3(0.3, 0.1, 0.0), in_file, now), flap.pivot());
  for (std::size_t v = 0; v < 3; ++v) {
    EXPECT_LT((X_SO * scene->objects[0].mesh->vertices[v] - moved->objects[0].mesh->vertices[v]).norm(), 1e-12) << v;
  }
  EXPECT_LT((flap.find_place(now).p_FM - Vec3(0.1, 0.2, 0.3)).norm(), 1e-14);
  EXPECT_LT(flap.find_place(now).q_FM.angularDistance(in_file), 1e-7);
}

TEST_F(CommandedObjectTest, AMassIsReadAndReported) {
  const auto scene = load("moved_by = \"program\"\nmass_kg = 0.25\n");
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->objects[0].mass_kg, 0.25);
  EXPECT_EQ(load("moved_by = \"program\"\n")->objects[0].mass_kg, 0.0);
  ASSERT_TRUE(load("moved_by = \"program\"\nmass_kg = 0.25\n"));
  const auto report = make_scene_report(folder.path() / "scene.toml");
  ASSERT_TRUE(report);
  EXPECT_THAT(to_text(*report), HasSubstr(", moved by programs, mass 0.25 kg"));
  EXPECT_THAT(to_json(*report), HasSubstr("\"mass_kg\": 0.25"));
  EXPECT_THAT(error_of("mass_kg = 0.25\n"), HasSubstr("line 5: 'mass_kg' in [[object]] 1 goes with 'moved_by = \"program\"'"));
  EXPECT_THAT(error_of("moved_by = \"program\"\nmass_kg = 0\n"), HasSubstr("line 6: 'mass_kg'"));
  EXPECT_THAT(error_of("moved_by = \"program\"\nmass_kg = 250\n"), HasSubstr("line 6: 'mass_kg'"));
}

TEST_F(CommandedObjectTest, WhatIsNotGivenStaysAsItIs) {
  const auto scene = load("moved_by = \"program\"\npivot_m = [0.02, 0, 0]\nrotation_deg = [0, 0, 90]\n");
  ASSERT_TRUE(scene) << scene.error().what;
  const CommandedObject& flap = *scene->objects[0].commanded;
  const Quat tilted(Eigen::AngleAxisd(0.3, Vec3::UnitX()));
  const Keyframe now{7.0, Vec3(0.5, 0.6, 0.7), tilted};
  const Quat level = Quat::Identity();
  const Keyframe turned = flap.place(std::nullopt, level, now);
  EXPECT_EQ(turned.p_S, now.p_S) << "the pivot stays";
  EXPECT_LT(turned.turn.angularDistance(Quat(Eigen::AngleAxisd(-std::numbers::pi / 2, Vec3::UnitZ()))), 1e-9);
  const Keyframe shifted = flap.place(Vec3(1, 2, 3), std::nullopt, now);
  EXPECT_EQ(shifted.turn.coeffs(), tilted.coeffs());
  const Quat q_now = tilted * Quat(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitZ()));
  EXPECT_LT((shifted.p_S - (Vec3(1, 2, 3) + q_now * Vec3(0.02, 0, 0))).norm(), 1e-12);
  const Quat slightly_too_long(2.0 * 0.0005 + 1.0, 0, 0, 0);
  EXPECT_NEAR(flap.place(std::nullopt, slightly_too_long, now).turn.norm(), 1.0, 1e-15) << "rounded numbers";
}

// The hashes tell commanded objects apart, so that a haptics node does not work with a vision node or recording of another one.
TEST_F(CommandedObjectTest, IsPartOfTheHashes) {
  const auto still = load("");
  const auto commanded = load("moved_by = \"program\"\n");
  const auto elsewhere = load("moved_by = \"program\"\npivot_m = [0.02, 0, 0]\n");
  ASSERT_TRUE(still && commanded && elsewhere);
  EXPECT_NE(still->given_hash, commanded->given_hash);
  EXPECT_NE(commanded->given_hash, elsewhere->given_hash);
  EXPECT_NE(hash_scene(still->touch_scene()), hash_scene(commanded->touch_scene()));
  EXPECT_NE(hash_scene(commanded->touch_scene()), hash_scene(elsewhere->touch_scene()));
}

TEST_F(CommandedObjectTest, WhatDoesNotGoTogetherIsNamedWithItsLine) {
  EXPECT_THAT(error_of("moved_by = \"hand\"\n"), HasSubstr("line 5: 'moved_by' in [[object]] 1 is 'hand': it may be \"program\""));
  EXPECT_THAT(error_of("moved_by = true\n"), HasSubstr("line 5: 'moved_by' in [[object]] 1 must be a text in quotes"));
  EXPECT_THAT(error_of("moved_by = \"program\"\nmovable = true\n"), HasSubstr("has 'moved_by' and 'movable': keep one"));
  EXPECT_THAT(error_of("moved_by = \"program\"\n", "[[object.keyframe]]\ntime_s = 0\n[[object.keyframe]]\ntime_s = 1\n"),
              HasSubstr("has 'moved_by' and 'keyframe': keep one"));
  EXPECT_THAT(error_of("moved_by = \"program\"\n", "[[object.morph]]\npush_m = [0, 0, 0.001]\nkeys = [[0.0, 0.0], [1.0, 1.0]]\n"),
              HasSubstr("has 'moved_by' and 'morph': keep one"));
  EXPECT_THAT(error_of("pivot_m = [0, 0, 0]\n"), HasSubstr("'pivot_m' in [[object]] 1 goes with keyframes or 'moved_by'"));
}

TEST_F(CommandedObjectTest, HasTheEffectsOfItsMaterial) {
  const auto scene = load("moved_by = \"program\"\nmaterial = \"soft\"\n", "[material.soft]\nviscosity_ns_per_m = 2.0\n");
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_TRUE(scene->touch_scene().objects[0].command_pivot.has_value());
  EXPECT_EQ(scene->touch_scene().objects[0].effects.viscosity.damping_ns_per_m, 2.0);
}

// When a scene is read again, the object stays where it was moved only if requests still lead to the same places.
TEST_F(CommandedObjectTest, IsTheSameWhereNothingThatPlacesItHasChanged) {
  const auto load_commanded = [&](const std::string& keys, const std::string& before = "") {
    return *load("moved_by = \"program\"\nposition_m = [0.1, 0.2, 0.3]\n" + keys, before)->objects[0].commanded;
  };
  const CommandedObject first = load_commanded("");
  EXPECT_TRUE(first == load_commanded(""));
  EXPECT_TRUE(first == load_commanded("material = \"soft\"\n", "[material.soft]\nviscosity_ns_per_m = 2.0\n"));
  EXPECT_FALSE(first == load_commanded("rotation_deg = [0, 0, 30]\n")) << "about its pivot, which stays where it is";
  EXPECT_FALSE(first == load_commanded("pivot_m = [0.01, 0, 0]\n"));
  EXPECT_FALSE(first == load_commanded("scale = 2.0\n"));
  EXPECT_FALSE(first == load_commanded("", "fit_m = [0.05, 0.05, 0.05]\n"));
}

TEST_F(CommandedObjectTest, IsInTheReport) {
  ASSERT_TRUE(load("moved_by = \"program\"\n"));
  const auto report = make_scene_report(folder.path() / "scene.toml");
  ASSERT_TRUE(report);
  EXPECT_THAT(to_text(*report), HasSubstr(", moved by programs"));
  EXPECT_THAT(to_json(*report), HasSubstr("\"moved_by\": \"program\""));
}

}  // namespace
}  // namespace hapton
