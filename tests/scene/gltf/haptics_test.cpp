#include "scene/gltf/haptics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/force/touch_step.h"
#include "scene/mesh_report.h"
#include "scene/raw_mesh.h"
#include "scene/scene_file.h"
#include "tests/scene/gltf/gltf_samples.h"
#include "tests/scene/made_pictures.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr double kSideM = 0.1;

// A square at z = 0 with texture coordinates along x and y, and three images: a ramp along u, a ramp along v, and uniform grey.
struct HapticSheet {
  std::string materials;  // the materials of the extension, as JSON
  // Members of mesh 0, before its primitives.
  std::string mesh = R"("extensions":{"MPEG_haptic_material":{"hapticMaterialIndex":0}},)";
  std::string attributes = R"("TEXCOORD_0":2)";
  std::string more_nodes = {};
  std::string more_meshes = {};
  std::string node = {};      // members of node 0
  std::string samplers = {};  // members of samplers[0], which textures[2] uses
  std::string extensions_used = R"("extensionsUsed":["MPEG_haptic_material"],)";
  std::string textures = R"({"source":0},{"source":1},{"source":2,"sampler":0},{"source":0})";

  std::string images = R"({"bufferView":3},{"bufferView":4},{"bufferView":5})";

  std::string glb() const {
    const TriangleMesh square = {.vertices = {{0, 0, 0}, {kSideM, 0, 0}, {kSideM, kSideM, 0}, {0, kSideM, 0}},
                                 .triangles = {{0, 1, 2}, {0, 2, 3}}};
    std::string texcoords;
    for (const float scale : {1.0F, 2.0F}) {
      for (const auto& [u, v] : {std::pair(0.0F, 0.0F), {1.0F, 0.0F}, {1.0F, 1.0F}, {0.0F, 1.0F}}) {
        sample::append(texcoords, scale * u);
        sample::append(texcoords, scale * v);
      }
    }
    sample::Pieces pieces;
    pieces.add(sample::positions_of(square));
    pieces.add(sample::indices_of(square));
    pieces.add(texcoords);
    pieces.add(picture::png_of(64, 64, picture::grey_rows(64, 64, [](int x, int) { return 4 * x; })));
    pieces.add(picture::png_of(64, 64, picture::grey_rows(64, 64, [](int, int y) { return 4 * y; })));
    pieces.add(picture::png_of(4, 4, picture::grey_rows(4, 4, [](int, int) { return 51; })));
    const std::string accessors = sample::accessors_of(square) +
                                  R"(,{"bufferView":2,"componentType":5126,"count":4,"type":"VEC2"})"
                                  R"(,{"bufferView":2,"byteOffset":32,"componentType":5126,"count":4,"type":"VEC2"})"
                                  R"(,{"bufferView":2,"componentType":5126,"count":3,"type":"VEC2"})";
    return pieces.glb(accessors,
                      fmt::format(R"({}"extensions":{{"MPEG_haptic_material":{{"materials":[{}]}}}},"textures":[{}],"samplers":[{{{}}}],)"
                                  R"("images":[{}],"nodes":[{{{}"mesh":0,"name":"sheet"}}{}],)"
                                  R"("meshes":[{{{}"primitives":[{{"attributes":{{"POSITION":0,{}}},"indices":1}}]}}{}])",
                                  extensions_used, materials, textures, samplers, images, node, more_nodes, mesh, attributes, more_meshes));
  }
};

std::string texture(int index, const std::string& more = "") {
  return fmt::format(R"([{{"texture":{{"index":{}{}}},"type":"High_Resolution"}}])", index, more);
}

// The value, 0 to 1, of the ramp (64 columns, 4 grey levels each) at x, away from the edges of the sheet, where the texture repeats.
double ramp_value_at(double x_m) { return 4.0 * (64.0 * x_m / kSideM - 0.5) / 255.0; }
constexpr double kRampSlope = 4.0 * 64.0 / 255.0 / kSideM;  // of this value, per metre

// Touches a scene with a force method.
class TouchingHand {
 public:
  explicit TouchingHand(const Scene& scene, const Vec3& start = {0.05, 0.05, 0.01}, const std::string& method = "proxy")
      : step_(*make_method({.name = method}, scene.touch_scene()), scene.touch_scene()) {
    step_.reset({.p_WD = start});
    at_ = start;
  }
  TouchOutput move_to(const Vec3& to, int steps = 200) {
    TouchOutput output;
    const Vec3 from = at_;
    for (int n = 1; n <= steps; ++n) {
      at_ = from + (to - from) * n / steps;
      output = step_.step({.p_WD = at_});
    }
    return output;
  }

 private:
  TouchStep step_;
  Vec3 at_;
};

class GltfHaptics : public ::testing::Test {
 protected:
  Scene load(const HapticSheet& sheet, const std::string& toml = {}) {
    folder_.write("sheet.glb", sheet.glb());
    auto scene = toml.empty() ? load_scene(folder_.path() / "sheet.glb") : load_scene(folder_.write("a.toml", toml));
    EXPECT_TRUE(scene) << scene.error().what;
    if (scene) return std::move(*scene);
    Scene none;
    none.objects.emplace_back();
    return none;
  }
  std::string error_of(const HapticSheet& sheet, const std::string& toml = {}) {
    folder_.write("sheet.glb", sheet.glb());
    const auto scene = toml.empty() ? load_scene(folder_.path() / "sheet.glb") : load_scene(folder_.write("a.toml", toml));
    if (scene) return "it was read";
    EXPECT_EQ(scene.error().what.find('\n'), std::string::npos) << scene.error().what;
    EXPECT_THAT(scene.error().what, HasSubstr(toml.empty() ? "sheet.glb: " : "a.toml: "));
    return scene.error().what;
  }
  // The error for a material with these JSON members.
  std::string error_of_material(const std::string& members) { return error_of({.materials = "{" + members + "}"}); }

  ScratchFolder folder_;
};

TEST_F(GltfHaptics, StiffnessIsFeltAsMapped) {
  for (const char* method : {"proxy", "reference"}) {
    const Scene scene =
        load({.materials = R"({"stiffness":)" + texture(0) + R"(,"extras":{"hapton":{"stiffness_map_n_per_m":[200,1000]}}})"});
    ASSERT_EQ(scene.objects.size(), 1U);
    EXPECT_EQ(scene.objects[0].material.stiffness_n_per_m, 1000.0);
    for (const double x : {0.02, 0.05, 0.08}) {
      TouchingHand hand(scene, {x, 0.05, 0.005}, method);
      const TouchOutput felt = hand.move_to({x, 0.05, -0.002});
      const double depth = felt.visual_offset_m.z();
      EXPECT_NEAR(depth, 0.002, 1e-5);
      const double k = 200.0 + 800.0 * ramp_value_at(x);
      EXPECT_NEAR(felt.force_n.z(), k * depth, 1e-5 * k * depth) << method << " " << x;
      // The gradient of k d^2 / 2 along x.
      EXPECT_NEAR(felt.force_n.x(), -0.5 * 800.0 * kRampSlope * depth * depth, 1e-5) << method << " " << x;
      EXPECT_NEAR(felt.force_n.y(), 0.0, 1e-9);
    }
  }
}

TEST_F(GltfHaptics, FrictionIsFeltAsMapped) {
  const Scene scene = load(
      {.materials = R"({"friction":)" + texture(0) + R"(,"extras":{"hapton":{"friction_map_range":[0.1,0.9],"stiffness_n_per_m":500}}})"});
  TouchingHand hand(scene, {0.01, 0.05, 0.005});
  hand.move_to({0.01, 0.05, -0.002});
  for (const double x : {0.03, 0.05, 0.07}) {
    const TouchOutput felt = hand.move_to({x, 0.05, -0.002}, 2000);
    const double normal_n = 500.0 * felt.visual_offset_m.z();
    EXPECT_NEAR(felt.force_n.z(), normal_n, 1e-6);
    EXPECT_NEAR(felt.force_n.x(), -(0.1 + 0.8 * ramp_value_at(x)) * normal_n, 1e-4 * normal_n) << x;
  }
}

TEST_F(GltfHaptics, ACustomTextureWithAScaleIsAViscosity) {
  const Scene scene = load({.materials = R"({"custom":)" + texture(0) + R"(,"extras":{"hapton":{"viscosity_map_ns_per_m":[0,6]}}})"});
  EXPECT_THAT(scene.notes, testing::Each(testing::Not(HasSubstr("is ignored"))));
  TouchingHand hand(scene, {0.01, 0.05, 0.005});
  hand.move_to({0.01, 0.05, -0.002});
  // 0.07 m in 2,000 steps of 1 ms.
  const TouchOutput felt = hand.move_to({0.08, 0.05, -0.002}, 2000);
  EXPECT_NEAR(felt.force_n.x(), -6.0 * ramp_value_at(0.08) * 0.035, 1e-3);
}

TEST_F(GltfHaptics, TheTactileTextureIsAHeight) {
  const Scene scene = load({.materials = R"({"vibrotactileTexture":)" + texture(0) +
                                         R"(,"extras":{"hapton":{"bump_height_m":0.001,"stiffness_n_per_m":800}}})"});
  TouchingHand hand(scene, {0.05, 0.05, 0.005});
  const TouchOutput felt = hand.move_to({0.05, 0.05, -0.002});
  const double depth_m = felt.visual_offset_m.z() - 0.001 * (1.0 - ramp_value_at(0.05));
  EXPECT_NEAR(felt.force_n.z(), 800.0 * depth_m, 1e-5);
  EXPECT_NEAR(felt.force_n.x(), -800.0 * depth_m * 0.001 * kRampSlope, 1e-5);
}

TEST_F(GltfHaptics, TheTextureLiesWhereItsCoordinatesSay) {
  const std::string range = R"(,"extras":{"hapton":{"stiffness_map_n_per_m":[200,1000]}}})";
  const auto stiffness_at = [&](const Scene& scene, double x, double y) {
    TouchingHand hand(scene, {x, y, 0.005});
    const TouchOutput felt = hand.move_to({x, y, -0.001});
    return felt.force_n.z() / felt.visual_offset_m.z();
  };
  // v runs downwards in the image.
  EXPECT_NEAR(stiffness_at(load({.materials = R"({"stiffness":)" + texture(1) + range}), 0.05, 0.02), 200 + 800 * ramp_value_at(0.02),
              0.01);
  // TEXCOORD_1 repeats the texture twice across the sheet.
  const HapticSheet second = {.materials = R"({"stiffness":)" + texture(0, R"(,"texCoord":1)") + range,
                              .attributes = R"("TEXCOORD_0":2,"TEXCOORD_1":3)"};
  EXPECT_NEAR(stiffness_at(load(second), 0.02, 0.05), 200 + 800 * ramp_value_at(0.04), 0.01);
  const std::string transform = R"(,"extensions":{"KHR_texture_transform":{"offset":[0.25,0],"scale":[0.5,0.5]}})";
  EXPECT_NEAR(stiffness_at(load({.materials = R"({"stiffness":)" + texture(0, transform) + range}), 0.02, 0.05),
              200 + 800 * ramp_value_at(0.035), 0.01);
  // A quarter turn: with the matrix of KHR_texture_transform, u of the image is v of the sheet.
  const std::string turned = R"(,"extensions":{"KHR_texture_transform":{"rotation":1.5707963267948966,"texCoord":0}})";
  EXPECT_NEAR(stiffness_at(load({.materials = R"({"stiffness":)" + texture(0, turned) + range}), 0.05, 0.03),
              200 + 800 * ramp_value_at(0.03), 0.01);
  // Both nodes move and mirror the sheet: first with uniform grey (51 of 255) and a texture that does not repeat, then with the ramp.
  const HapticSheet moved = {.materials = R"({"stiffness":)" + texture(2) + range,
                             .node = R"("scale":[-2,1,1],"translation":[0.3,0,0],)",
                             .samplers = R"("wrapS":33071,"wrapT":33648)"};
  EXPECT_NEAR(stiffness_at(load(moved), 0.15, 0.05), 360, 0.01);
  const HapticSheet mirrored = {.materials = R"({"stiffness":)" + texture(0) + range,
                                .node = R"("scale":[-1,1,1],"translation":[0.3,0,0],)"};
  EXPECT_NEAR(stiffness_at(load(mirrored), 0.27, 0.05), 200 + 800 * ramp_value_at(0.03), 0.01);
}

TEST_F(GltfHaptics, NumbersWithoutATextureAreThoseOfTheWholeMesh) {
  const Scene scene = load({.materials = R"({"name":"felt","extras":{"hapton":{"stiffness_n_per_m":300,"friction_static":0.5,)"
                                         R"("friction_dynamic":0.25,"two_sided":false,"viscosity_ns_per_m":2}}})",
                            .attributes = R"("COLOR_0":0)"});
  EXPECT_EQ(scene.objects[0].name, "sheet");
  EXPECT_EQ(scene.objects[0].material.stiffness_n_per_m, 300.0);
  EXPECT_EQ(scene.objects[0].material.friction_dynamic, 0.25);
  EXPECT_FALSE(scene.objects[0].material.two_sided);
  EXPECT_EQ(scene.objects[0].effects.viscosity.damping_ns_per_m, 2.0);
  EXPECT_THAT(scene.notes, IsEmpty());
  const Scene layers = load({.materials = R"({"extras":{"hapton":{"two_sided":false,"layer":[{"depth_m":0,"stiffness_n_per_m":400,)"
                                          R"("pop_force_n":1.5},{"depth_m":0.01,"stiffness_n_per_m":500}]}}})"});
  ASSERT_EQ(layers.objects[0].effects.layers.count(), 2U);
  EXPECT_EQ(layers.objects[0].effects.layers[0].pop_force_n, 1.5);
}

// The sheet with a child node that has a second mesh beside it. second_extension: JSON members of that mesh.
HapticSheet two_sheets(const std::string& second_extension) {
  return {.materials =
              R"({"name":"soft","stiffness":)" + texture(2) +
              R"(,"extras":{"hapton":{"stiffness_map_n_per_m":[100,600]}}},{"name":"hard","extras":{"hapton":{"stiffness_n_per_m":2000}}})",
          .more_nodes = R"(,{"mesh":1,"name":"other","translation":[0.2,0,0]})",
          .more_meshes = R"(,{)" + second_extension + R"("primitives":[{"attributes":{"POSITION":0},"indices":1}]})",
          .node = R"("children":[1],)"};
}

TEST_F(GltfHaptics, EachHapticMaterialBecomesAnObject) {
  const Scene with_both = load(two_sheets(R"("extensions":{"MPEG_haptic_material":{"hapticMaterialIndex":1}},)"));
  ASSERT_EQ(with_both.objects.size(), 2U);
  EXPECT_EQ(with_both.objects[0].name, "sheet/soft");
  EXPECT_EQ(with_both.objects[1].name, "sheet/hard");
  EXPECT_EQ(with_both.objects[1].material.stiffness_n_per_m, 2000.0);
  EXPECT_EQ(with_both.objects[0].mesh->triangles.size(), 2U);
  EXPECT_EQ(with_both.objects[1].mesh->triangles.size(), 2U);
  EXPECT_EQ(with_both.objects[1].mesh->vertices.size(), 4U);
  TouchingHand left(with_both, {0.05, 0.05, 0.005});
  EXPECT_NEAR(left.move_to({0.05, 0.05, -0.001}).force_n.z(), 0.001 * (100 + 500 * 0.2), 1e-5);
  TouchingHand right(with_both, {0.25, 0.05, 0.005});
  EXPECT_NEAR(right.move_to({0.25, 0.05, -0.001}).force_n.z(), 0.001 * 2000, 1e-5);
  // A mesh without a haptic material keeps the default material, and its object is named after the file.
  const Scene with_one = load(two_sheets(""));
  ASSERT_EQ(with_one.objects.size(), 2U);
  EXPECT_EQ(with_one.objects[1].name, "sheet");
  EXPECT_EQ(with_one.objects[1].material.stiffness_n_per_m, Material().stiffness_n_per_m);
  EXPECT_FALSE(with_one.objects[1].effects.any());
}

TEST_F(GltfHaptics, ASceneFileTakesThemOrGivesItsOwn) {
  const HapticSheet sheets = two_sheets("");
  const std::string object = "[[object]]\nmesh = 'sheet.glb'\n";
  EXPECT_EQ(load(sheets, object).objects.size(), 2U);
  const Scene part = load(sheets, object + "part = 'sheet'\nposition_m = [0, 0, 0.5]\n");
  ASSERT_EQ(part.objects.size(), 1U);
  EXPECT_EQ(part.objects[0].name, "sheet");
  TouchingHand hand(part, {0.05, 0.05, 0.505});
  EXPECT_NEAR(hand.move_to({0.05, 0.05, 0.499}).force_n.z(), 0.001 * 200, 1e-5);
  EXPECT_FALSE(load(sheets, object + "part = 'other'\n").objects[0].effects.any());
  const Scene own = load(sheets, object + "material = 'm'\n[material.m]\nstiffness_n_per_m = 700\n");
  ASSERT_EQ(own.objects.size(), 1U);
  EXPECT_EQ(own.objects[0].material.stiffness_n_per_m, 700.0);
  EXPECT_FALSE(own.objects[0].effects.any());
  EXPECT_EQ(load(sheets, object + "part = 'sheet'\nmovable = true\n").objects.size(), 1U);
  EXPECT_THAT(error_of(sheets, object + "movable = true\n"),
              AllOf(HasSubstr("line 2: object 'sheet' is movable"), HasSubstr("2 haptic materials"), HasSubstr("name a part")));
}

TEST_F(GltfHaptics, FitsAMeshWithMapsAsOneWithoutMaps) {
  const HapticSheet sheet = {.materials = R"({"stiffness":)" + texture(2) + R"(,"extras":{"hapton":{"stiffness_map_n_per_m":[100,600]}}})"};
  HapticSheet plain = sheet;
  plain.mesh = "";
  folder_.write("sheet.glb", sheet.glb());
  folder_.write("plain.glb", plain.glb());
  const auto with_maps = load_scene(folder_.path() / "sheet.glb", {.fit = MeshFit::workspace});
  const auto without_maps = load_scene(folder_.path() / "plain.glb", {.fit = MeshFit::workspace});
  ASSERT_TRUE(with_maps && without_maps);
  EXPECT_EQ(with_maps->fit_scale, without_maps->fit_scale);
  EXPECT_EQ(with_maps->objects[0].mesh->vertices, without_maps->objects[0].mesh->vertices);
  EXPECT_THAT(with_maps->notes, Contains(HasSubstr("--no-fit leaves it as it is")));
  EXPECT_FALSE(without_maps->objects[0].effects.any());
}

TEST_F(GltfHaptics, TheReportNamesThem) {
  folder_.write("sheet.glb", two_sheets(R"("extensions":{"MPEG_haptic_material":{"hapticMaterialIndex":1}},)").glb());
  const auto report = make_mesh_report(folder_.path() / "sheet.glb", std::nullopt);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report),
              AllOf(HasSubstr("haptic material       soft: stiffness from an image\n"), HasSubstr("haptic material       hard\n")));
  EXPECT_THAT(to_json(*report), HasSubstr("\"hard\""));
}

// `hapton info` also reports what would make a scene with this file fail.
TEST_F(GltfHaptics, TheReportNamesAKeyThatIsUnknown) {
  folder_.write("sheet.glb", HapticSheet{.materials = R"({"name":"soft","extras":{"hapton":{"stifness_n_per_m":300}}})"}.glb());
  const auto report = make_mesh_report(folder_.path() / "sheet.glb", std::nullopt);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report), AllOf(HasSubstr("note                  cannot be touched before this is corrected: "),
                                      HasSubstr("unknown key 'stifness_n_per_m' in extras.hapton")));
  folder_.write("sheet.glb", HapticSheet{.materials = R"({"name":"soft","extras":{"hapton":{"stiffness_n_per_m":300}}})"}.glb());
  EXPECT_THAT(to_text(*make_mesh_report(folder_.path() / "sheet.glb", std::nullopt)), testing::Not(HasSubstr("cannot be touched")));
}

TEST_F(GltfHaptics, WhatIsNotFeltIsNoted) {
  const auto notes_of = [&](const std::string& material) {
    const Scene scene = load({.materials = material});
    EXPECT_FALSE(scene.objects[0].effects.any());
    return scene.notes;
  };
  EXPECT_THAT(notes_of(R"({"stiffness":)" + texture(0) + "}"),
              Contains(AllOf(HasSubstr("materials[0].stiffness is ignored"), HasSubstr("no units"), HasSubstr("stiffness_map_n_per_m"))));
  EXPECT_THAT(notes_of(R"({"friction":)" + texture(0) + "}"), Contains(HasSubstr("friction_map_range")));
  EXPECT_THAT(notes_of(R"({"vibrotactileTexture":)" + texture(0) + "}"), Contains(HasSubstr("bump_height_m")));
  EXPECT_THAT(notes_of(R"({"temperature":)" + texture(0) + "}"), Contains(HasSubstr("materials[0].temperature is ignored")));
  EXPECT_THAT(notes_of(R"({"custom":[{"texture":{"index":0}}]})"),
              Contains(AllOf(HasSubstr("materials[0].custom is ignored"), HasSubstr("viscosity_map_ns_per_m"))));
  EXPECT_THAT(notes_of(R"({"custom":{"anything":1}})"), Contains(HasSubstr("materials[0].custom is ignored"))) << "not a list";
  EXPECT_THAT(notes_of(R"({"vibration":{"texture":0}})"), Contains(HasSubstr("materials[0].vibration is ignored"))) << "not a list";
  EXPECT_THAT(notes_of(R"({"stifness":)" + texture(0) + "}"),
              Contains(HasSubstr("materials[0].stifness is ignored: the extension has no such property; did you mean 'stiffness'?")));
  EXPECT_THAT(notes_of(R"({"custom":[],"name":"a","extras":{"other":1},"extensions":{}})"),
              testing::Each(testing::Not(HasSubstr("is ignored"))));
  EXPECT_THAT(notes_of(R"({"friction":[{"texture":{"index":0},"type":"Reference"}]})"), Contains(HasSubstr("only refers to haptic data")));
  const Scene draft = load({.materials = "{}", .extensions_used = R"("extensionsUsed":["MPEG_material_haptic"],)"});
  EXPECT_THAT(draft.notes, Contains(HasSubstr("export it as MPEG_haptic_material")));
}

TEST_F(GltfHaptics, TakesTheBestTexture) {
  const Scene scene =
      load({.materials = R"({"stiffness":[{"texture":{"index":1},"type":"Low_Resolution"},{"texture":{"index":2}},)"
                         R"({"texture":{"index":0},"type":"Reference"}],"extras":{"hapton":{"stiffness_map_n_per_m":[100,600]}}})"});
  EXPECT_EQ(scene.objects[0].effects.maps.stiffness.image->width(), 4);
}

TEST_F(GltfHaptics, SaysWhatIsWrongAndWhere) {
  const std::string range = R"(,"extras":{"hapton":{"stiffness_map_n_per_m":[200,1000]}})";
  const std::string where = "extensions.MPEG_haptic_material.materials[0]";
  EXPECT_THAT(error_of_material(R"("extras":{"hapton":3})"), HasSubstr(where + ".extras.hapton is not an object"));
  EXPECT_THAT(error_of_material(R"("extras":{"hapton":{"stiffnes_n_per_m":3}})"),
              AllOf(HasSubstr(where + ": unknown key 'stiffnes_n_per_m' in extras.hapton"), HasSubstr("'stiffness_n_per_m'")));
  EXPECT_THAT(error_of_material(R"("extras":{"hapton":{"stiffness_n_per_m":-3}})"), HasSubstr("is -3: it must be above 0"));
  EXPECT_THAT(error_of_material(R"("extras":{"hapton":{"stiffness_n_per_m":null}})"), HasSubstr("must be a number"));
  EXPECT_THAT(error_of_material(R"("extras":{"hapton":{"two_sided":[[[[[1]]]]]}})"), HasSubstr("must be true or false"));
  // So many nested lists would exhaust the stack of a recursive reader.
  const std::size_t nesting_depth = 200'000;
  EXPECT_THAT(
      error_of_material(R"("extras":{"hapton":{"two_sided":)" + std::string(nesting_depth, '[') + std::string(nesting_depth, ']') + "}}"),
      HasSubstr(where + ".extras.hapton has more than 16 lists and objects inside each other"));
  EXPECT_THAT(error_of_material(R"("extras":{"hapton":{"friction_map_range":[0,1]}})"), HasSubstr("without a texture in 'friction'"));
  EXPECT_THAT(error_of_material(R"("extras":{"hapton":{"bump_map":"a.png"}})"), HasSubstr("the texture of 'vibrotactileTexture'"));
  EXPECT_THAT(error_of_material(R"("extras":{"hapton":{"map_repeat":[2,2]}})"), HasSubstr("KHR_texture_transform"));
  EXPECT_THAT(error_of_material(R"("extras":{"hapton":{"recorded_texture":"a.xml"}})"), HasSubstr("use a material of a scene file"));
  EXPECT_THAT(error_of_material(R"("extras":{"hapton":{"two_sided":true,"layer":[{"depth_m":0,"stiffness_n_per_m":400}]}})"),
              AllOf(HasSubstr(where), HasSubstr("two_sided = false")));
  EXPECT_THAT(error_of_material(R"("stiffness":)" + texture(0) + R"(,"extras":{"hapton":{"stiffness_map_n_per_m":[0,1]}})"),
              HasSubstr("number 1 of 'stiffness_map_n_per_m' in extras.hapton is 0"));
  EXPECT_THAT(error_of_material(R"("stiffness":)" + texture(9) + range), HasSubstr(where + ".stiffness.texture.index"));
  EXPECT_THAT(error_of_material(R"("stiffness":[{"texture":{"index":0},"type":"Huge"}])" + range),
              HasSubstr(where + ".stiffness[0].type is 'Huge': it must be High_Resolution"));
  EXPECT_THAT(error_of_material(R"("stiffness":{"texture":{"index":0}})" + range), HasSubstr(where + ".stiffness is not a list"));
  EXPECT_THAT(error_of_material(R"("stiffness":)" + texture(0, R"(,"texCoord":1)") + range), HasSubstr("no TEXCOORD_1: unwrap it"));
  EXPECT_THAT(error_of_material(R"("stiffness":)" + texture(0, R"(,"extensions":{"KHR_texture_transform":{"scale":[1]}})") + range),
              HasSubstr("KHR_texture_transform.scale does not have 2 numbers"));
  EXPECT_THAT(error_of_material(R"("stiffness":)" + texture(0) + R"(,"friction":)" + texture(0, R"(,"texCoord":1)") +
                                R"(,"extras":{"hapton":{"stiffness_map_n_per_m":[200,1000],"friction_map_range":[0,1]}})"),
              HasSubstr(where + ".friction: its texture uses other texture coordinates"));
  EXPECT_THAT(error_of({.materials = R"({"stiffness":)" + texture(0) + range + "}", .attributes = R"("TEXCOORD_0":4)"}),
              HasSubstr("3 values for 4 vertices"));
  EXPECT_THAT(
      error_of(
          {.materials = R"({"stiffness":)" + texture(2) + range + "}", .attributes = R"("TEXCOORD_0":3)", .samplers = R"("wrapT":33071)"}),
      AllOf(HasSubstr("is 2, and the sampler"), HasSubstr("keep the coordinates within 0 to 1")));
  EXPECT_THAT(error_of({.materials = R"({"stiffness":)" + texture(2) + range + "}", .samplers = R"("wrapS":1)"}),
              HasSubstr("samplers[0].wrapS must be"));
  EXPECT_THAT(error_of({.materials = R"({"stiffness":)" + texture(0) + range + "}", .textures = "{}"}),
              HasSubstr("textures[0] has no PNG or JPEG image"));
  EXPECT_THAT(error_of({.materials = ""}), HasSubstr("is not a list with at least one material"));
  EXPECT_THAT(error_of({.materials = "3"}), HasSubstr(where + " is not an object"));
  EXPECT_THAT(error_of({.materials = "{}", .mesh = R"("extensions":{"MPEG_haptic_material":{"hapticMaterialIndex":1}},)"}),
              HasSubstr("meshes[0].extensions.MPEG_haptic_material.hapticMaterialIndex"));
  EXPECT_THAT(error_of({.materials = "{}", .mesh = R"("extensions":{"MPEG_haptic_material":{}},)"}), HasSubstr("hapticMaterialIndex"));
}

// A hostile file could have many such images, of a few bytes each.
TEST_F(GltfHaptics, ImagesMayShareABufferViewAFewTimes) {
  for (const int count : {3, 100}) {
    HapticSheet sheet{.materials = {}, .textures = {}, .images = {}};
    for (int n = 0; n < count; ++n) {
      const std::string comma = n == 0 ? "" : ",";
      sheet.images += comma + R"({"bufferView":3})";
      sheet.textures += comma + fmt::format(R"({{"source":{}}})", n);
      sheet.materials += comma + R"({"stiffness":)" + texture(n) + R"(,"extras":{"hapton":{"stiffness_map_n_per_m":[100,600]}}})";
    }
    const auto raw = read_glb(sheet.glb(), ".");
    EXPECT_EQ(raw.has_value(), count == 3);
    if (!raw) {
      EXPECT_THAT(raw.error().what, AllOf(HasSubstr("images["), HasSubstr("which they share")));
    }
  }
}

TEST_F(GltfHaptics, ImagesLieBesideTheFileToo) {
  folder_.write("a b.png", picture::png_of(4, 4, picture::grey_rows(4, 4, [](int, int) { return 255; })));
  folder_.write("bad.png", "no picture");
  const auto with_image = [&](const std::string& uri) {
    HapticSheet sheet{.materials = R"({"stiffness":)" + texture(0) + R"(,"extras":{"hapton":{"stiffness_map_n_per_m":[100,600]}}})"};
    sheet.images = fmt::format(R"({{"uri":"{}"}},{{}},{{}})", uri);
    return load_scene(folder_.write("sheet.glb", sheet.glb()));
  };
  const auto beside = with_image("a%20b.png");
  ASSERT_TRUE(beside) << beside.error().what;
  EXPECT_EQ(beside->objects[0].effects.maps.stiffness.image->width(), 4);
  EXPECT_THAT(with_image("none.png").error().what, AllOf(HasSubstr("images[0]: "), HasSubstr("none.png")));
  EXPECT_THAT(with_image("bad.png").error().what, AllOf(HasSubstr("images[0] is neither PNG nor JPEG"), HasSubstr("'stiffness_map'")));
  EXPECT_THAT(with_image("http://a/b.png").error().what, HasSubstr("on the network"));
  EXPECT_THAT(with_image("data:image/png,xx").error().what, HasSubstr("images[0] is inline but not base64"));
}

}  // namespace
}  // namespace hapton
