#include "haptics_node/placed_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/force/mapped_surface.h"
#include "core/geometry/mesh_shapes.h"
#include "scene/annotations_file.h"
#include "tests/support/log_of.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using testing::HasSubstr;
using testing::Not;

// Two boxes, of which the second can be picked up.
Scene two_boxes() {
  Scene scene;
  scene.given_hash = 77;
  for (const char* name : {"table", "cube"}) {
    SceneObject object;
    object.name = name;
    object.mesh = std::make_shared<const TriangleMesh>(make_box(Vec3(0.1, 0.2, 0.3)));
    object.is_movable = object.name == "cube";
    scene.objects.push_back(std::move(object));
  }
  return scene;
}

const Quat kTurned(Eigen::AngleAxisd(0.5, Vec3(1, 2, 2) / 3.0));

struct PlacedSceneTest : testing::Test {
  ScratchFolder folder;
  Scene scene = two_boxes();

  std::filesystem::path write(const Annotations& annotations, std::uint64_t hash = 77) {
    return folder.write("marks.json", write_annotations(annotations, hash));
  }
};

TEST_F(PlacedSceneTest, TheImagesOfASurfaceMoveWithIt) {
  SceneObject& cube = scene.objects[1];
  auto mapped = std::make_shared<std::vector<MappedTriangle>>();
  for (std::size_t t = 0; t < cube.mesh->triangles.size(); ++t) {
    MappedTriangle made;
    for (std::size_t k = 0; k < 3; ++k) {
      made.corner[k] = cube.mesh->corner(t, static_cast<int>(k));
      made.texcoord[k] = Eigen::Vector2d(made.corner[k].x() + 2.0 * made.corner[k].z(), 3.0 * made.corner[k].y());
    }
    mapped->push_back(made);
  }
  std::vector<float> texels(64 * 64);
  for (std::size_t n = 0; n < texels.size(); ++n) texels[n] = static_cast<float>(n % 61) / 60.0F;
  const auto image = std::make_shared<const SurfaceImage>(64, 64, std::move(texels));
  cube.effects.maps = {.triangles = mapped, .friction = {.image = image, .at_black = 0.0, .at_white = 1.0}};
  const PutDown put_down{1, Vec3(0.3, 0.0, -0.1), kTurned};
  const Scene placed = place_objects(scene, {put_down});
  EXPECT_EQ(*scene.objects[1].effects.maps.triangles->front().corner.data(), cube.mesh->corner(0, 0)) << "as it was loaded";
  MapFinder before(scene.objects[1].effects.maps);
  MapFinder after(placed.objects[1].effects.maps);
  std::set<double> frictions;
  for (const auto& [x, y] : {std::pair(0.01, 0.02), std::pair(-0.03, 0.05), std::pair(0.02, -0.07)}) {
    const Vec3 on(x, y, 0.15);
    EXPECT_NEAR(after.find(put_down.pose() * on).friction, before.find(on).friction, 1e-9);
    frictions.insert(before.find(on).friction);
  }
  EXPECT_EQ(frictions.size(), 3U);
  Scene moved_back = placed;
  move_object(Pose::Identity(), scene.objects[1], moved_back.objects[1]);
  EXPECT_EQ(moved_back.objects[1].effects.maps.triangles->back().corner, mapped->back().corner) << "from where it was loaded";
}

TEST_F(PlacedSceneTest, WhatAFileHasPutDownLiesThere) {
  const auto file = write({.objects = {"table", "cube"}, .entries = {}, .put_down = {{1, Vec3(0.3, 0.0, -0.1), kTurned}}});
  std::vector<PutDown> put_down;
  const std::string log = log_of([&] {
    const auto read = read_saved_poses(file, scene);
    ASSERT_TRUE(read) << read.error().what;
    put_down = *read;
  });
  EXPECT_THAT(log, HasSubstr("cube is placed as " + file.string() + " says"));
  ASSERT_EQ(put_down.size(), 1U);
  EXPECT_EQ(put_down[0].object, 1);
  EXPECT_LT((put_down[0].p_m - Vec3(0.3, 0.0, -0.1)).norm(), 1e-12);
  const Scene placed = place_objects(scene, put_down);
  EXPECT_EQ(placed.objects[0].mesh, scene.objects[0].mesh);
  for (std::size_t v = 0; v < scene.objects[1].mesh->vertices.size(); ++v) {
    const Vec3 there = kTurned * scene.objects[1].mesh->vertices[v] + Vec3(0.3, 0.0, -0.1);
    EXPECT_LT((placed.objects[1].mesh->vertices[v] - there).norm(), 1e-12);
  }
}

TEST_F(PlacedSceneTest, WhatIsNotMovableStays) {
  const auto file = write({.objects = {"table", "cube"}, .entries = {}, .put_down = {{0, Vec3(0.3, 0.0, 0.0), kTurned}}});
  const std::string log = log_of([&] {
    const auto read = read_saved_poses(file, scene);
    ASSERT_TRUE(read);
    EXPECT_TRUE(read->empty());
  });
  EXPECT_THAT(log, HasSubstr("table is not movable in this scene, and stays where it is"));
}

TEST_F(PlacedSceneTest, AFileOfAnotherSceneSaysSo) {
  const auto file = write({.objects = {"table", "other"}, .entries = {}, .put_down = {{1, Vec3::Zero(), kTurned}}}, 78);
  const std::string log = log_of([&] {
    const auto read = read_saved_poses(file, scene);
    ASSERT_TRUE(read);
    EXPECT_TRUE(read->empty()) << "it is of an object that this scene does not have";
  });
  EXPECT_THAT(log, HasSubstr(file.string() + ": "));
  EXPECT_THAT(log, Not(HasSubstr("is placed as")));
}

TEST_F(PlacedSceneTest, WithoutAFileNothingIsPutDown) {
  for (const std::filesystem::path& none : {std::filesystem::path(), folder.path() / "none.json"}) {
    const auto read = read_saved_poses(none, scene);
    ASSERT_TRUE(read);
    EXPECT_TRUE(read->empty());
  }
  const auto broken = read_saved_poses(folder.write("broken.json", "{"), scene);
  ASSERT_FALSE(broken);
  EXPECT_THAT(broken.error().what, HasSubstr("broken.json"));
}

// The normals that a file gives turn with the mesh, but are not shifted.
TEST_F(PlacedSceneTest, NormalsTurnAlong) {
  TriangleMesh mesh = make_box(Vec3::Ones());
  mesh.authored_normals.resize(mesh.triangles.size());
  for (auto& corners : mesh.authored_normals) corners.fill(Eigen::Vector3f::UnitX());
  const Pose X = Eigen::Translation3d(1.0, 2.0, 3.0) * Pose(kTurned);
  const TriangleMesh moved = move_mesh(X, mesh);
  for (const auto& corners : moved.authored_normals) {
    for (const Eigen::Vector3f& normal : corners) EXPECT_LT((normal.cast<double>() - kTurned * Vec3::UnitX()).norm(), 1e-6);
  }
  EXPECT_LT((moved.vertices[3] - X * mesh.vertices[3]).norm(), 1e-12);
}

// What was carved is carved again before the first force; carves of bodies that cannot be carved are dropped, and the log says so once.
TEST_F(PlacedSceneTest, WhatAFileHasCarvedIsCarvedAgain) {
  scene.objects[1].is_movable = false;
  scene.objects[1].sculpt = SculptSettings{.voxel_m = 0.01, .tool_radius_m = 0.03};
  const auto press = [](std::int32_t object, double x) {
    return CarvedPress{.object = object,
                       .radius_m = rounded_to_float(0.03),
                       .carves = {rounded({Vec3(x, 0, 0.15), Vec3(x, 0, 0.1), 0.03}), rounded({Vec3(x, 0, 0.1), Vec3(x, 0, 0.05), 0.03})}};
  };
  Annotations notes{.objects = {"table", "cube"}, .entries = {}, .put_down = {}, .carved = {press(0, 0), press(1, 0), press(0, 0.01)}};
  notes.carved.push_back(press(1, 0));     // again: it changes nothing
  notes.carved.push_back(press(1, 0.05));  // another one
  const auto file = write(notes);
  std::vector<CarvedPress> carved;
  const std::string log = log_of([&] {
    const auto read = read_saved_carves(file, scene);
    ASSERT_TRUE(read) << read.error().what;
    carved = *read;
  });
  EXPECT_THAT(log, HasSubstr("table cannot be carved in this scene"));
  EXPECT_EQ(log.find("table"), log.rfind("table")) << "once";
  ASSERT_EQ(carved.size(), 3U);
  HapticsStep step(std::make_unique<TouchStep>(*make_method({}, scene.touch_scene()), scene.touch_scene()), 1e-5);
  const std::vector<MadeCarve> made = apply_saved_carves(carved, step);
  ASSERT_EQ(made.size(), 4U);
  for (std::size_t n = 0; n < made.size(); ++n) {
    EXPECT_EQ(made[n].serial, n + 1);
    EXPECT_EQ(made[n].begins, n % 2 == 0) << "each table of the file is a press";
    EXPECT_EQ(made[n].object, 1);
  }
  EXPECT_EQ(made[2].carve, press(1, 0.05).carves[0]);
  EXPECT_EQ(step.touch().newest_carve_serial(), 4U);
  EXPECT_GT(step.touch().method().sculpture()->bodies()[0].field.value({0, 0, 0.1}), 0.0) << "the material is gone";
}

}  // namespace
}  // namespace hapton
