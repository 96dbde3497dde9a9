#include "scene/scene_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "tests/scene/sample_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(SceneReport, DescribesEveryObject) {
  const auto report = make_scene_report(HAPTON_SOURCE_DIR "/scenes/nist_assembly.toml");
  ASSERT_TRUE(report) << report.error().what;
  const std::string text = to_text(*report);
  const auto json = nlohmann::json::parse(to_json(*report));
  ASSERT_EQ(json["objects"].size(), 6U);
  EXPECT_THAT(text, HasSubstr(", 6 objects\n"));
  std::size_t triangles = 0;
  for (const auto& object : json["objects"]) {
    EXPECT_THAT(text, HasSubstr(object["name"].get<std::string>()));
    triangles += object["triangles"].get<std::size_t>();
  }
  EXPECT_EQ(triangles, 7216U);
  EXPECT_THAT(text, HasSubstr(", 6 objects\n"));
  EXPECT_THAT(text, HasSubstr(to_text(report->flaws[2])));
  EXPECT_EQ(json["objects"][2]["needle_triangles"], report->flaws[2].topology.needle_triangles);
  EXPECT_EQ(json["objects"][2]["name"], "pipe_1");
  EXPECT_EQ(json["objects"][2]["stiffness_n_per_m"], 800.0);
}

TEST(SceneReport, SaysWhatIsMovable) {
  const auto report = make_scene_report(HAPTON_SOURCE_DIR "/scenes/workbench.toml");
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report), HasSubstr("friction 0 / 0, movable\n"));
  const auto json = nlohmann::json::parse(to_json(*report));
  EXPECT_EQ(json["objects"][0]["movable"], false);
  EXPECT_EQ(json["objects"][3]["movable"], true);
}

TEST(SceneReport, SaysWhatMovesByItself) {
  const auto report = make_scene_report(HAPTON_SOURCE_DIR "/scenes/machine.toml");
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_NE(to_text(*report).find("moves by 5 keyframes, 4.8 s, repeated"), std::string::npos) << to_text(*report);
  EXPECT_NE(to_json(*report).find("\"motion_s\": 4.8"), std::string::npos);
}

TEST(SceneReport, SaysWhichButtonTurnsWhichEffectOn) {
  const ScratchFolder folder;
  folder.write("a.obj", sample::obj(sample::tetrahedron()));
  const auto file = folder.write("a.toml",
                                 "[[object]]\nmesh = 'a.obj'\n[[effect]]\ntype = 'spring'\nobject = 'a'\n"
                                 "[[effect]]\ntype = 'burst'\ndirection = [0, 0, 1]\nbutton = 2\n");
  const auto report = make_scene_report(file);
  ASSERT_TRUE(report) << report.error().what;
  const auto json = nlohmann::json::parse(to_json(*report));
  ASSERT_EQ(json["effects"].size(), 2U);
  EXPECT_FALSE(json["effects"][0].contains("button"));
  EXPECT_EQ(json["effects"][1]["button"], 2);
}

TEST(SceneReport, SaysWhatCanBeCarved) {
  const auto report = make_scene_report(HAPTON_SOURCE_DIR "/scenes/clay.toml");
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report), HasSubstr("can be carved by button 1: ball of 4 mm radius, voxels of 0.8 mm"));
  const auto json = nlohmann::json::parse(to_json(*report));
  EXPECT_TRUE(json["objects"][0]["carve_button"].is_null());
  EXPECT_EQ(json["objects"][1]["carve_button"], 1);
}

TEST(SceneReport, CountsTheButtonThatCarvesFromOne) {
  const ScratchFolder folder;
  folder.write("a.obj", sample::obj(make_icosphere(0.02, 3)));
  const auto report = make_scene_report(folder.write("a.toml", "[[object]]\nmesh = 'a.obj'\nsculpt = true\ncarve_button = 3\n"));
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report), HasSubstr("can be carved by button 3: "));
  EXPECT_EQ(nlohmann::json::parse(to_json(*report))["objects"][0]["carve_button"], 3);
}

TEST(SceneReport, CountsOneObjectAsOne) {
  const auto report = make_scene_report(HAPTON_SOURCE_DIR "/scenes/car_front.toml");
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report), HasSubstr(", 1 object\n"));
}

TEST(SceneReport, SaysWhatIsWrongWithAMesh) {
  const auto report = make_scene_report(HAPTON_SOURCE_DIR "/scenes/car_front.toml");
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report), HasSubstr(", 1 object\n"));
  EXPECT_THAT(to_text(*report), HasSubstr("not closed: "));
  EXPECT_THAT(to_text(*report), HasSubstr("needles 68"));
}

TEST(SceneReport, SaysHowTheFileIsLaidOut) {
  const ScratchFolder folder;
  folder.write("a.obj", sample::obj(sample::tetrahedron()));
  const auto file = folder.write("s.toml",
                                 "[workspace]\ncenter_m = [0, 1, 0]\nrotation_deg = [0, 90, 0]\nscale = 10\n"
                                 "[[group]]\nname = 'car'\n[[group]]\nname = 'axle'\ngroup = 'car'\n"
                                 "[[object]]\nname = 'wheel'\nmesh = 'a.obj'\ngroup = 'axle'\n"
                                 "[[instance]]\nname = 'rear'\nof = 'axle'\nposition_m = [0, 0, 2]\n"
                                 "[camera]\nposition_m = [0.1, 0.2, 0.6]\nview_angle_deg = 40\n"
                                 "[[light]]\ndirection = [0, -2, 0]\nintensity = 0.5\n[[light]]\nposition_m = [1, 2, 3]\n");
  const auto report = make_scene_report(file);
  ASSERT_TRUE(report) << report.error().what;
  const std::string text = to_text(*report);
  EXPECT_THAT(text, HasSubstr("\nworkspace: its middle is (0, 1, 0) m in the scene, turned by 90 degrees about (0, 1, 0); a metre of the "
                              "hand is 10 m of the scene\n"));
  EXPECT_THAT(text, HasSubstr("\ngroup car\ngroup axle, in group car\ninstance rear: of axle\n"));
  EXPECT_THAT(text, HasSubstr("\ncamera: from (0.1, 0.2, 0.6) m to (0, 0, 0) m, up (0, 1, 0), 40 degrees\n"));
  EXPECT_THAT(text, HasSubstr("\nlight: shines along (0, -1, 0), colour times intensity (0.5, 0.5, 0.5)\n"));
  EXPECT_THAT(text, HasSubstr("\nlight: at (1, 2, 3) m, colour times intensity (1, 1, 1)\n"));
  const auto json = nlohmann::json::parse(to_json(*report));
  EXPECT_EQ(json["workspace"]["scale"], 10.0);
  EXPECT_EQ(json["workspace"]["center_m"], nlohmann::json({0.0, 1.0, 0.0}));
  EXPECT_EQ(json["fit_scale"], 0.1);
  EXPECT_TRUE(json["fit_m"].is_null());
  EXPECT_EQ(json["groups"].size(), 2U);
  EXPECT_EQ(json["groups"][1]["group"], "car");
  EXPECT_EQ(json["instances"][0]["of"], "axle");
  EXPECT_EQ(json["camera"]["view_angle_deg"], 40.0);
  EXPECT_EQ(json["lights"][0]["direction"], nlohmann::json({0.0, -1.0, 0.0}));
  EXPECT_EQ(json["lights"][1]["position_m"], nlohmann::json({1.0, 2.0, 3.0}));
}

TEST(SceneReport, SaysNothingOfTablesThatAreNotThere) {
  const auto report = make_scene_report(HAPTON_SOURCE_DIR "/scenes/pegs.toml");
  ASSERT_TRUE(report) << report.error().what;
  for (const char* word : {"camera", "light:", "group", "instance", "workspace"}) EXPECT_THAT(to_text(*report), Not(HasSubstr(word)));
  EXPECT_THAT(to_text(*report), HasSubstr("tool peg: "));
  const auto json = nlohmann::json::parse(to_json(*report));
  EXPECT_TRUE(json["camera"].is_null());
  EXPECT_TRUE(json["workspace"].is_null());
  EXPECT_TRUE(json["lights"].empty());
  EXPECT_EQ(json["tool"], "peg");
}

TEST(SceneReport, NamesTheEffectsOfASurface) {
  const ScratchFolder folder;
  folder.write("a.obj", sample::obj(sample::tetrahedron()));
  auto report = make_scene_report(folder.write("a.toml", "[[object]]\nmesh = 'a.obj'\n"));
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report), Not(HasSubstr("effects: ")));
  SurfaceEffects& effects = report->scene.objects[0].effects;
  const auto image = std::make_shared<const SurfaceImage>(1, 1, std::vector<float>{0.5F});
  effects.progressive.n_per_m2 = 1.0;
  effects.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 1.0, .pop_force_n = 1.0, .drag_ns_per_m = 0.0});
  EXPECT_THAT(to_text(*report), HasSubstr(" effects: progressive stiffness, 1 layer\n"));
  effects.layers.add({.depth_m = 0.1, .stiffness_n_per_m = 1.0, .pop_force_n = 1.0, .drag_ns_per_m = 0.0});
  effects.bumps.height_m = 1e-4;
  effects.maps.triangles = std::make_shared<const std::vector<MappedTriangle>>();
  for (ImageMap SurfaceMaps::*map : {&SurfaceMaps::height, &SurfaceMaps::stiffness, &SurfaceMaps::friction, &SurfaceMaps::viscosity}) {
    effects.maps.*map = {.image = image, .at_black = 0.1, .at_white = 0.2};
  }
  effects.viscosity.damping_ns_per_m = 1.0;
  effects.snap = {.stiffness_n_per_m = 1.0, .range_m = 0.001};
  effects.tap.ns_per_m = 1.0;
  EXPECT_THAT(to_text(*report),
              HasSubstr(" effects: progressive stiffness, 2 layers, bumps, bumps from an image (slope at most 0), stiffness "
                        "from an image, friction from an image, viscosity from an image, viscosity, snap, vibration on "
                        "tap\n"));
}

TEST(SceneReport, NamesTheObjectsThatAreInsideOut) {
  TriangleMesh flipped = sample::tetrahedron();
  for (Triangle& t : flipped.triangles) std::swap(t[1], t[2]);
  const ScratchFolder folder;
  folder.write("a.obj", sample::obj(sample::tetrahedron()));
  folder.write("b.obj", sample::obj(flipped));
  const auto scene = load_scene(folder.write("a.toml", "[[object]]\nmesh = 'a.obj'\n[[object]]\nmesh = 'b.obj'\n"));
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_THAT(
      find_inside_out(*scene),
      ElementsAre("b: 1 of 1 closed body is inside out: with two_sided = false only the inner side can be touched; flip the normals "
                  "(\"recalculate outside\") and export again"));
}

TEST(SceneReport, PassesErrorsOn) {
  const auto report = make_scene_report(HAPTON_SOURCE_DIR "/scenes/none.toml");
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().what, HasSubstr("no such file"));
}

}  // namespace
}  // namespace hapton
