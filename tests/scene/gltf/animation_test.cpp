#include "scene/gltf/animation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "scene/mesh_file.h"
#include "scene/scene_file.h"
#include "tests/scene/sample_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

// A triangle of 0.1 m ("hand") at the end of an arm of 0.1 m, a child of a base; a second triangle ("post") stands beside them.
struct GltfAnimation : testing::Test {
  GltfAnimation() {
    for (const float x : {0.0F, 0.0F, 0.0F, 0.1F, 0.0F, 0.0F, 0.0F, 0.1F, 0.0F}) sample::append(bytes, x);
    document["asset"]["version"] = "2.0";
    document["accessors"] = Json::array();
    document["bufferViews"] = Json::array();
    add_accessor("VEC3", 3, 0);
    document["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", 0}}}}}}}};
    document["nodes"] = {{{"name", "base"}, {"children", {1}}, {"translation", {1, 0, 0}}},
                         {{"name", "arm"}, {"children", {2}}, {"rotation", {0, 0, 0, 1}}},
                         {{"name", "hand"}, {"mesh", 0}, {"translation", {0.1, 0, 0}}},
                         {{"name", "post"}, {"mesh", 0}}};
    document["scenes"] = {{{"nodes", {0, 3}}}};
  }

  std::size_t add_accessor(const char* type, std::size_t count, std::size_t first) {
    const std::size_t number = document["accessors"].size();
    document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", first}, {"byteLength", bytes.size() - first}});
    document["accessors"].push_back({{"bufferView", number}, {"componentType", 5126}, {"count", count}, {"type", type}});
    return number;
  }
  std::size_t add_numbers(const char* type, std::size_t components, const std::vector<float>& numbers) {
    const std::size_t first = bytes.size();
    for (const float number : numbers) sample::append(bytes, number);
    return add_accessor(type, numbers.size() / components, first);
  }
  // Adds a channel to the animation with that index.
  void add_channel(std::size_t animation, std::size_t node, const char* path, const std::vector<float>& times,
                   const std::vector<float>& values, const char* interpolation = "LINEAR") {
    Json& target_animation = document["animations"][animation];
    const std::size_t sampler = target_animation["samplers"].size();
    const bool is_rotation = std::string(path) == "rotation";
    const std::size_t input = add_numbers("SCALAR", 1, times);
    const std::size_t output = add_numbers(is_rotation ? "VEC4" : "VEC3", is_rotation ? 4 : 3, values);
    target_animation["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
    target_animation["channels"].push_back({{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}});
  }
  static std::vector<float> rotations_about_z(const std::vector<double>& degrees) {
    std::vector<float> values;
    for (const double each : degrees) {
      const double half = each * std::numbers::pi / 360.0;
      for (const double number : {0.0, 0.0, std::sin(half), std::cos(half)}) values.push_back(static_cast<float>(number));
    }
    return values;
  }

  std::filesystem::path write() {
    document["buffers"] = {{{"uri", "a.bin"}, {"byteLength", bytes.size()}}};
    folder.write("a.bin", bytes);
    return folder.write("a.gltf", document.dump());
  }
  MeshFile load() {
    auto file = load_mesh_file(write());
    EXPECT_TRUE(file) << (file ? "" : file.error().what);
    return file ? *file : MeshFile();
  }
  std::string scene_error(const std::string& keys) {
    write();
    const auto scene = load_scene(folder.write("a.toml", "[[object]]\nmesh = 'a.gltf'\n" + keys));
    return scene ? "it was read" : scene.error().what;
  }

  ScratchFolder folder;
  std::string bytes;
  Json document;
};

// The arm turns about the base, and the hand goes with it.
TEST_F(GltfAnimation, ANodeMovesWithTheOneAboveIt) {
  document["animations"] = {{{"name", "swing"}}};
  add_channel(0, 1, "rotation", {0.0F, 1.0F, 2.0F}, rotations_about_z({0, 90, 0}));
  const MeshFile file = load();
  ASSERT_EQ(file.animations.size(), 1U);
  const MeshAnimation& swing = file.animations[0];
  EXPECT_EQ(swing.name, "swing");
  EXPECT_EQ(swing.duration_s, 2.0);
  ASSERT_EQ(swing.motions.size(), 1U) << "the post stands still";
  const KeyframeMotion& hand = swing.motions.at(2);
  EXPECT_LT((hand.pivot() - Vec3(1, 0, 0)).norm(), 1e-7);
  const Vec3 at_rest(1.1, 0, 0);
  for (const double degrees : {0.0, 30.0, 90.0}) {
    const double angle = degrees * std::numbers::pi / 180.0;
    EXPECT_LT((hand.pose_at(degrees / 90.0) * at_rest - Vec3(1 + 0.1 * std::cos(angle), 0.1 * std::sin(angle), 0)).norm(), 1e-6);
  }
  EXPECT_THAT(file.notes, Contains(HasSubstr("has the animation 'swing', 2 s")));
}

TEST_F(GltfAnimation, TwoNodesOfAPathMoveTogether) {
  add_channel(0, 0, "translation", {0.0F, 2.0F}, {1, 0, 0, 1, 0.2F, 0});
  add_channel(0, 1, "rotation", {1.0F, 2.0F}, rotations_about_z({0, 90}));
  const MeshFile file = load();
  ASSERT_EQ(file.animations.size(), 1U);
  EXPECT_EQ(file.animations[0].name, "animation 0");
  const KeyframeMotion& hand = file.animations[0].motions.at(2);
  EXPECT_EQ(hand.keyframes().size(), 3U) << "the times of both";
  EXPECT_LT((hand.pose_at(1.0) * Vec3(1.1, 0, 0) - Vec3(1.1, 0.1, 0)).norm(), 1e-6);
  EXPECT_LT((hand.pose_at(2.0) * Vec3(1.1, 0, 0) - Vec3(1.0, 0.3, 0)).norm(), 1e-6);
}

// An animation replaces the node's own transform for its whole duration, also before its first keyframe.
TEST_F(GltfAnimation, MayBeginElsewhereThanTheFileRests) {
  add_channel(0, 3, "translation", {0.5F, 1.0F}, {0, 0, 0.3F, 0, 0, 0.4F});
  const KeyframeMotion post = load().animations.at(0).motions.at(3);
  EXPECT_LT((post.pose_at(0.0) * Vec3::Zero() - Vec3(0, 0, 0.3)).norm(), 1e-7);
  EXPECT_LT((post.pose_at(0.75) * Vec3::Zero() - Vec3(0, 0, 0.35)).norm(), 1e-7);
}

// Exporters mirror by a negative scale. The combined transform alone does not tell which axis was mirrored.
TEST_F(GltfAnimation, AMirroredNodeBeginsWhereItRests) {
  document["nodes"][3]["rotation"] = rotations_about_z({30});
  add_channel(0, 3, "rotation", {0.0F, 1.0F}, rotations_about_z({30, 120}));
  const Vec3 p(0.3, 0.2, 0.1);
  for (const std::array<double, 3>& scale : {std::array{-1.0, 1.0, 1.0}, {1.0, -1.0, 1.0}, {-2.0, -2.0, -2.0}, {-1.0, 2.0, 1.0}}) {
    document["nodes"][3]["scale"] = scale;
    const KeyframeMotion post = load().animations.at(0).motions.at(3);
    EXPECT_LT((post.pose_at(0.0) * p - p).norm(), 1e-6) << scale[0] << ' ' << scale[1];
    EXPECT_LT((post.pose_at(1.0) * p - Vec3(-0.2, 0.3, 0.1)).norm(), 1e-6) << scale[0] << ' ' << scale[1];
  }
}

TEST_F(GltfAnimation, WhatIsNotRigidIsLeftOutWithANote) {
  add_channel(0, 3, "scale", {0.0F, 1.0F}, {1, 1, 1, 2, 2, 2});
  add_channel(0, 2, "translation", {0.0F, 1.0F}, {0.1F, 0, 0, 0.2F, 0, 0}, "STEP");
  const MeshFile file = load();
  EXPECT_TRUE(file.animations.at(0).motions.empty());
  EXPECT_THAT(file.notes, Contains(HasSubstr("1 channels of scales or pointers are left out")));
  EXPECT_THAT(file.notes, Contains(HasSubstr("1 channels that jump (STEP) are left out")));
  EXPECT_THAT(file.notes, Not(Contains(HasSubstr("has the animation"))));
}

struct GltfMorphs : GltfAnimation {
  GltfMorphs() {
    // Post and hand use the same mesh, which has two morph targets.
    const std::size_t up = add_numbers("VEC3", 3, {0, 0, 0, 0, 0, 0.02F, 0, 0, 0});
    const std::size_t aside = add_numbers("VEC3", 3, {0.01F, 0, 0, 0.01F, 0, 0, 0.01F, 0, 0});
    document["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", up}}, {{"POSITION", aside}}};
  }
  void add_weights(std::size_t node, const std::vector<float>& times, const std::vector<float>& weights,
                   const char* interpolation = "LINEAR") {
    add_channel(0, node, "weights", times, {0, 0, 0}, interpolation);
    document["animations"][0]["samplers"].back()["output"] = add_numbers("SCALAR", 1, weights);
  }
  Result<Scene> load_playing(const std::string& more) {
    write();
    return load_scene(folder.write("a.toml", "[[object]]\nname = 'a'\nmesh = 'a.gltf'\nanimation = 'animation 0'\n" + more));
  }
};

TEST_F(GltfMorphs, ReadsTargetsInTheFilesFrame) {
  document["nodes"][3]["rotation"] = {0, 0, std::sqrt(0.5), std::sqrt(0.5)};
  document["nodes"][3]["scale"] = {2, 2, 2};
  const MeshFile file = load();
  ASSERT_TRUE(file.morphs.contains(3));
  const MeshMorphs& post = file.morphs.at(3);
  ASSERT_EQ(post.displacements.size(), 2U);
  ASSERT_EQ(post.at_rest.size(), 3U);
  EXPECT_LT((post.at_rest[1] - Vec3(0, 0.2, 0)).norm(), 1e-7);
  EXPECT_LT((post.displacements[0][1] - Vec3(0, 0, 0.04)).norm(), 1e-7);
  EXPECT_LT((post.displacements[1][2] - Vec3(0, 0.02, 0)).norm(), 1e-7);
}

TEST_F(GltfMorphs, AnimationsOfWeightsDeformTheirNode) {
  add_weights(3, {0.5F, 1.0F}, {0, 0, 1, 0.5F});
  const auto scene = load_playing("animation_speed = 0.5");
  ASSERT_TRUE(scene) << scene.error().what;
  ASSERT_EQ(scene->objects.size(), 2U);
  EXPECT_EQ(scene->objects[0].name, "a") << "the hand stands still";
  EXPECT_FALSE(scene->objects[0].moves());
  const SceneObject& post = scene->objects[1];
  EXPECT_EQ(post.name, "a/post");
  EXPECT_FALSE(post.motion);
  ASSERT_TRUE(post.deformation);
  EXPECT_EQ(post.deformation->duration_s(), 2.0);
  const auto vertices = post.deformation->vertices_at(post.mesh->vertices, post.deformation->weights_at(1.5));
  for (std::size_t v = 0; v < 3; ++v) {
    const Vec3 expected = post.mesh->vertices[v] + Vec3(0.0025, 0, post.mesh->vertices[v].x() > 0.05 ? 0.01 : 0.0);
    EXPECT_LT((vertices[v] - expected).norm(), 1e-7) << v;
  }
}

// A node may move and deform at the same time; weights follow their splines too.
TEST_F(GltfMorphs, MotionAndWeightsGoTogether) {
  add_channel(0, 3, "translation", {0.0F, 1.0F}, {0, 0, 0, 0, 0, 0.1F});
  add_weights(3, {0.0F, 1.0F}, {9, 9, 0, 0, 0, 0, 0, 0, 0, 1, 9, 9}, "CUBICSPLINE");
  const auto scene = load_playing("");
  ASSERT_TRUE(scene) << scene.error().what;
  const SceneObject& post = scene->objects.back();
  ASSERT_TRUE(post.motion && post.deformation);
  EXPECT_EQ(post.deformation->targets().size(), 1U) << "the other one is not used";
  EXPECT_NEAR(post.deformation->weights_at(0.5)[0], 0.5, 1.0 / 256);
  EXPECT_NEAR(post.deformation->weights_at(0.25)[0], 0.15625, 1.0 / 256);
}

TEST_F(GltfMorphs, SaysWhatCannotBeDeformed) {
  const auto error_of = [&] {
    const auto scene = load_playing("");
    return scene ? "it was read" : scene.error().what;
  };
  add_weights(3, {0.0F, 0.05F}, {0, 0, 1, 0});
  EXPECT_THAT(error_of(), HasSubstr("line 4: from 0 to 0.05 s 'a/post' deforms at up to 0.4 m/s"));
  document["animations"] = Json::array();
  add_weights(3, {0.0F, 1.0F}, {0, 0, 0, 0});
  EXPECT_THAT(error_of(), HasSubstr("animation 'animation 0' does not deform 'a/post'"));
  document["animations"] = Json::array();
  add_weights(3, {0.0F, 1.0F}, {0, 0, 1});
  const MeshFile file = load();
  EXPECT_THAT(file.notes, Contains(HasSubstr("has 2 times, 2 morph targets and 3 weights")));
}

TEST_F(GltfMorphs, TargetsThatCannotBeReadAreANote) {
  document["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = 99;
  const MeshFile file = load();
  EXPECT_TRUE(file.morphs.empty());
  EXPECT_THAT(file.notes, Contains(HasSubstr("2 primitives have morph targets that cannot be read")));
}

// The height of the corner that the first target lifts, found by its x in the file: 1.2 m for the hand, 0.1 m for the post.
double height_at(const MeshFile& file, double x) {
  for (const Vec3& p : file.mesh.vertices) {
    if (std::fabs(p.x() - x) < 0.02 && std::fabs(p.y()) < 1e-9) return p.z();
  }
  return NAN;
}

// glTF 2.0, 3.7.2.2: the weights of a node replace those of its mesh.
TEST_F(GltfMorphs, AtRestTheyHaveTheWeightsOfTheirNodeOrElseOfTheirMesh) {
  document["meshes"][0]["weights"] = {0.5, 0};
  MeshFile file = load();
  EXPECT_NEAR(height_at(file, 1.2), 0.01, 1e-9);
  EXPECT_NEAR(height_at(file, 0.1), 0.01, 1e-9);
  EXPECT_EQ(file.notes, std::vector<std::string>());
  document["nodes"][3]["weights"] = {-1, 0};
  file = load();
  EXPECT_NEAR(height_at(file, 1.2), 0.01, 1e-9);
  EXPECT_NEAR(height_at(file, 0.1), -0.02, 1e-9);
  document["nodes"][3]["weights"] = {1};
  file = load();
  EXPECT_NEAR(height_at(file, 0.1), 0.02, 1e-9);
  EXPECT_THAT(file.notes, Contains(HasSubstr("1 primitives have another number of morph targets than weights")));
}

TEST_F(GltfMorphs, WeightsThatAreNotNumbersAreRejected) {
  const auto error_of = [&] {
    const auto file = load_mesh_file(write());
    return file ? "it was read" : file.error().what;
  };
  document["meshes"][0]["weights"] = {0.5, "much"};
  EXPECT_THAT(error_of(), HasSubstr("meshes[0].weights holds something that is not a finite number"));
  document["meshes"][0]["weights"] = 0.5;
  EXPECT_THAT(error_of(), HasSubstr("meshes[0].weights is not a list of numbers"));
  document["meshes"][0].erase("weights");
  document["nodes"][3]["weights"] = {0.5, nullptr};
  EXPECT_THAT(error_of(), HasSubstr("nodes[3].weights holds something that is not a finite number"));
}

// The weights at rest also apply to the normals of a target: otherwise the triangle would be shaded as if it were not deformed.
TEST_F(GltfMorphs, AtRestTheNormalsAreThoseOfTheWeights) {
  const std::size_t normals = add_numbers("VEC3", 3, {0, 0, 1, 0, 0, 1, 0, 0, 1});
  const std::size_t normal_displacements = add_numbers("VEC3", 3, {-0.2F, 0, 0, -0.2F, 0, 0, -0.2F, 0, 0});
  Json& primitive = document["meshes"][0]["primitives"][0];
  primitive["attributes"]["NORMAL"] = normals;
  primitive["targets"][0]["NORMAL"] = normal_displacements;
  document["meshes"][0]["weights"] = {1, 0};
  MeshFile file = load();
  ASSERT_FALSE(file.mesh.authored_normals.empty());
  for (const Eigen::Vector3f& normal : file.mesh.authored_normals[0]) {
    EXPECT_LT((normal - Eigen::Vector3f(-0.2F, 0, 1).normalized()).norm(), 1e-6F);
  }
  primitive["targets"][0]["NORMAL"] = 99;
  file = load();
  EXPECT_TRUE(file.mesh.authored_normals.empty());
  EXPECT_THAT(file.notes, Contains(HasSubstr("the normals of 2 primitives cannot be read")));
}

// The vertices of the mesh include the weights at rest; while the animation runs, only the animation's weights count.
TEST_F(GltfMorphs, AnAnimationOverridesTheWeightsAtRest) {
  document["nodes"][3]["weights"] = {0.5, 1};
  add_weights(3, {0.0F, 1.0F}, {0.5F, 1, 1, 0});
  const auto scene = load_playing("");
  ASSERT_TRUE(scene) << scene.error().what;
  const SceneObject& post = scene->objects.back();
  ASSERT_TRUE(post.deformation);
  const auto vertex_at = [&](double time_s, std::size_t v) {
    return post.deformation->vertices_at(post.mesh->vertices, post.deformation->weights_at(time_s))[v];
  };
  std::size_t lifted_vertex = 0;
  while (lifted_vertex < 3 && post.mesh->vertices[lifted_vertex].z() < 0.005) ++lifted_vertex;
  ASSERT_LT(lifted_vertex, 3U) << "the weights at rest lift it by 10 mm";
  EXPECT_LT((vertex_at(0.0, lifted_vertex) - Vec3(0.11, 0, 0.01)).norm(), 1e-7) << "as at rest";
  EXPECT_LT((vertex_at(1.0, lifted_vertex) - Vec3(0.1, 0, 0.02)).norm(), 1e-7) << "the first target alone";
}

// A morph target moves two vertices at the same position in different ways.
TEST_F(GltfMorphs, ASurfaceThatWouldBeTornIsRejected) {
  for (const float x : {0.0F, 0.0F, 0.0F, 0.1F, 0.0F, 0.0F, 0.0F, 0.1F, 0.0F, 0.1F, 0.0F, 0.0F, 0.1F, 0.1F, 0.0F, 0.0F, 0.1F, 0.0F}) {
    sample::append(bytes, x);
  }
  const std::size_t positions = add_accessor("VEC3", 6, bytes.size() - 72);
  const std::size_t tearing_displacements = add_numbers("VEC3", 3, {0, 0, 0, 0, 0, 0.01F, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  document["meshes"][1] = {
      {"primitives", {{{"attributes", {{"POSITION", positions}}}, {"targets", {{{"POSITION", tearing_displacements}}}}}}}};
  document["nodes"][3]["mesh"] = 1;
  add_weights(3, {0.0F, 1.0F}, {0, 1});
  const auto scene = load_playing("");
  ASSERT_FALSE(scene);
  EXPECT_THAT(scene.error().what, HasSubstr("'a/post' would be torn at (0.1, 0, 0) m"));
}

// A node that turns below a node with a non-uniform scale would shear its part.
TEST_F(GltfAnimation, APartThatWouldBeShearedStandsStill) {
  document["nodes"][0]["scale"] = {2, 1, 1};
  add_channel(0, 1, "rotation", {0.0F, 1.0F}, rotations_about_z({0, 45}));
  const MeshFile file = load();
  EXPECT_TRUE(file.animations.at(0).motions.empty());
  EXPECT_THAT(file.notes, Contains(HasSubstr("1 parts would deform, which is not supported; they stay at rest")));
}

TEST_F(GltfAnimation, ScalesAtRestStayAsTheyAre) {
  document["nodes"][2]["scale"] = {1, 2, 3};
  document["nodes"][0]["scale"] = {0.5, 0.5, 0.5};
  add_channel(0, 1, "rotation", {0.0F, 1.0F}, rotations_about_z({0, 90}));
  const KeyframeMotion hand = load().animations.at(0).motions.at(2);
  EXPECT_LT((hand.pose_at(1.0) * Vec3(1.05, 0, 0) - Vec3(1, 0.05, 0)).norm(), 1e-6);
}

// A cubic Hermite spline: x has zero tangents, so it starts and ends slowly; y moves only because of its tangents.
TEST_F(GltfAnimation, SplinesAreFollowed) {
  add_channel(0, 3, "translation", {0.0F, 2.0F}, {9, 9, 9, 0, 0, 0, 0, 0.1F, 0, 0, -0.1F, 0, 0.1F, 0, 0, 9, 9, 9}, "CUBICSPLINE");
  const MeshFile file = load();
  const KeyframeMotion& post = file.animations.at(0).motions.at(3);
  for (double t = 0.0; t <= 2.0; t += 0.01) {
    const double s = 0.5 * t;
    const Vec3 expected(0.1 * s * s * (3 - 2 * s), 0.2 * (s * s * s - 2 * s * s + s) - 0.2 * (s * s * s - s * s), 0);
    ASSERT_LT((post.pose_at(t).translation() - expected).norm(), 0.1 / 200) << t;
  }
  EXPECT_THAT(file.notes, Not(Contains(HasSubstr("spline"))));
}

TEST_F(GltfAnimation, SplinesOfRotationsAreFollowed) {
  const double half = std::numbers::pi / 8.0;  // half of 45 degrees, the angle at the end, as a quaternion needs it
  std::vector<float> values(24, 0.0F);
  values[7] = 1.0F;
  values[18] = static_cast<float>(std::sin(half));
  values[19] = static_cast<float>(std::cos(half));
  add_channel(0, 3, "rotation", {0.0F, 1.0F}, values, "CUBICSPLINE");
  const KeyframeMotion post = load().animations.at(0).motions.at(3);
  for (double s = 0.0; s <= 1.0; s += 0.01) {
    const double share = s * s * (3 - 2 * s);
    const Quat expected = Quat(1 - share + share * std::cos(half), 0, 0, share * std::sin(half)).normalized();
    ASSERT_LT(Quat(post.pose_at(s).rotation()).angularDistance(expected), 0.005) << s;
  }
}

// Exporters also write STEP and scale channels whose values do not change.
TEST_F(GltfAnimation, ConstantStepsAndScalesAreAccepted) {
  document["nodes"][3]["scale"] = {2, 2, 2};
  add_channel(0, 3, "translation", {0.0F, 1.0F}, {0, 0, 0.3F, 0, 0, 0.3F}, "STEP");
  add_channel(0, 3, "rotation", {0.0F, 1.0F}, rotations_about_z({0, 90}));
  add_channel(0, 3, "scale", {0.0F, 1.0F}, {2, 2, 2, 2, 2, 2});
  const MeshFile file = load();
  const KeyframeMotion& post = file.animations.at(0).motions.at(3);
  EXPECT_LT((post.pose_at(1.0) * Vec3(0.2, 0, 0) - Vec3(0, 0.2, 0.3)).norm(), 1e-6);
  EXPECT_THAT(file.notes, Not(Contains(HasSubstr("left out"))));
}

// A file is read even if its animation is broken, because its shape matters more.
TEST_F(GltfAnimation, ABrokenAnimationIsANote) {
  const std::size_t byte_count_before = bytes.size();
  for (const auto& [times, values, what] :
       {std::tuple(std::vector<float>{1, 1}, std::vector<float>{0, 0, 0, 0, 0, 0}, "do not increase"),
        std::tuple(std::vector<float>{0, 1, 2}, std::vector<float>{0, 0, 0, 0, 0, 0}, "3 times and 2 values"),
        std::tuple(std::vector<float>{0, 1}, std::vector<float>{0, 0, 0, 0, 0, NAN}, "not finite")}) {
    const Json document_before = document;
    add_channel(0, 3, "translation", times, values);
    const MeshFile file = load();
    EXPECT_EQ(file.mesh.triangles.size(), 2U);
    EXPECT_THAT(file.notes, Contains(HasSubstr(what)));
    document = document_before;
    bytes.resize(byte_count_before);
  }
}

TEST_F(GltfAnimation, AnObjectThatPlaysItBecomesOneForEachMotion) {
  document["animations"] = {{{"name", "swing"}}};
  add_channel(0, 1, "rotation", {0.0F, 0.5F, 1.0F}, rotations_about_z({0, 45, 0}));
  write();
  const auto scene = load_scene(folder.write(
      "a.toml", "[[object]]\nname = 'crane'\nmesh = 'a.gltf'\nposition_m = [0, 0, 0.5]\nscale = 0.5\nanimation = 'swing'\nloop = true\n"));
  ASSERT_TRUE(scene) << scene.error().what;
  ASSERT_EQ(scene->objects.size(), 2U);
  EXPECT_EQ(scene->objects[0].name, "crane");
  EXPECT_EQ(scene->objects[0].motion, nullptr);
  EXPECT_EQ(scene->objects[0].mesh->triangles.size(), 1U);
  EXPECT_EQ(scene->objects[1].name, "crane/hand");
  ASSERT_NE(scene->objects[1].motion, nullptr);
  EXPECT_TRUE(scene->objects[1].motion->loops());
  const Vec3 half_way = Vec3(0.5, 0, 0.5) + 0.05 * Vec3(1, 1, 0).normalized();
  EXPECT_LT((scene->objects[1].motion->pose_at(0.5) * Vec3(0.55, 0, 0.5) - half_way).norm(), 1e-6);
}

// Exporters leave out the last keyframe if it repeats the first: a wheel that turns by thirds then lacks the third back to its start.
TEST_F(GltfAnimation, ALoopThatEndsElsewhereGoesBackAtItsMeanSpeed) {
  add_channel(0, 1, "rotation", {0.0F, 2.0F, 4.0F}, rotations_about_z({0, 120, 240}));
  write();
  const std::string object = "[[object]]\nname = 'crane'\nmesh = 'a.gltf'\nscale = 0.5\nanimation = 'animation 0'\n";
  const auto scene = load_scene(folder.write("a.toml", object + "loop = true\nanimation_speed = 0.5\n"));
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_THAT(scene->notes, Contains(HasSubstr("line 5: the animation of 'crane/hand' ends with another pose than the first, to which it "
                                               "goes back in 4 s")));
  const KeyframeMotion& hand = *scene->objects[1].motion;
  EXPECT_LT((hand.pose_at(10.0) * Vec3(0.55, 0, 0) - Vec3(0.525, -0.05 * std::sqrt(0.75), 0)).norm(), 1e-6) << "half way back: 300 degrees";
  EXPECT_TRUE(hand.pose_at(12.0).isApprox(hand.pose_at(0.0), 1e-6));
  const auto once = load_scene(folder.write("a.toml", object));
  ASSERT_TRUE(once) << once.error().what;
  EXPECT_EQ(once->objects[1].motion->keyframes().size(), 3U) << "without a loop, none is added";
}

// The parts belong together: all repeat after the same time, although only one of them ends away from its first pose.
TEST_F(GltfAnimation, AllPartsOfALoopBeginAgainTogether) {
  add_channel(0, 1, "rotation", {0.0F, 2.0F, 4.0F}, rotations_about_z({0, 120, 240}));
  add_channel(0, 3, "translation", {0.0F, 2.0F, 4.0F}, {0, 0, 0, 0.1F, 0, 0, 0, 0, 0});
  write();
  const auto scene = load_scene(
      folder.write("a.toml", "[[object]]\nname = 'crane'\nmesh = 'a.gltf'\nscale = 0.1\nanimation = 'animation 0'\nloop = true\n"));
  ASSERT_TRUE(scene) << scene.error().what;
  int moving_objects = 0;
  for (const SceneObject& object : scene->objects) {
    if (object.motion == nullptr) continue;
    ++moving_objects;
    EXPECT_NEAR(object.motion->keyframes().back().time_s, 6.0, 1e-6) << object.name;
    EXPECT_TRUE(object.motion->pose_at(6.0).isApprox(object.motion->pose_at(0.0), 1e-6)) << object.name;
  }
  EXPECT_GE(moving_objects, 2);
}

TEST_F(GltfAnimation, TooFastAnAnimationNamesTheSpeedThatFits) {
  add_channel(0, 1, "rotation", {0.0F, 0.5F}, rotations_about_z({0, 90}));
  EXPECT_THAT(scene_error("animation = 'animation 0'"), HasSubstr("line 3: 'a/hand' moves at up to"));
  EXPECT_THAT(scene_error("animation = 'animation 0'"), HasSubstr("set animation_speed to 0.39 or less")) << "0.2 m at pi rad/s";
  EXPECT_EQ(scene_error("animation = 'animation 0'\nanimation_speed = 0.39"), "it was read");
}

TEST_F(GltfAnimation, NamesTheAnimationsThatTheFileHas) {
  EXPECT_THAT(scene_error("animation = 'swing'"), HasSubstr("line 3: "));
  EXPECT_THAT(scene_error("animation = 'swing'"), HasSubstr("has no animations"));
  document["animations"] = {{{"name", "swing"}}, {{"name", "walk"}}};
  add_channel(0, 1, "rotation", {0.0F, 9.0F}, rotations_about_z({0, 90}));
  add_channel(1, 3, "translation", {0.0F, 9.0F}, {0, 0, 0, 0.1F, 0, 0});
  EXPECT_THAT(scene_error("animation = 'swin'"), HasSubstr("has no animation 'swin': it has 'swing', 'walk'"));
  EXPECT_EQ(scene_error("animation = 'walk'\npart = 'post'"), "it was read");
  EXPECT_THAT(scene_error("animation = 'swing'\npart = 'post'"), HasSubstr("animation 'swing' moves nothing here"));
  EXPECT_THAT(scene_error("animation = 'walk'\nmovable = true"), HasSubstr("movable and moves by itself"));
}

TEST(GltfAnimationOfTheTruck, TurnsItsWheels) {
  const auto file = load_mesh_file(HAPTON_SOURCE_DIR "/meshes/CesiumMilkTruck.gltf");
  ASSERT_TRUE(file) << file.error().what;
  ASSERT_EQ(file->animations.size(), 1U);
  EXPECT_EQ(file->animations[0].motions.size(), 2U);
  EXPECT_EQ(file->animations[0].duration_s, 1.25);
}

}  // namespace
}  // namespace hapton
