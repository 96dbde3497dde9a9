#include "core/force/smooth/smooth_scene.h"

#include <gtest/gtest.h>

#include <array>

#include <memory>
#include <random>
#include <set>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"
#include "tests/support/obj_mesh.h"

namespace hapton {
namespace {

using Id = std::pair<std::uint32_t, std::uint32_t>;

TouchScene two_objects() {
  TouchScene scene;
  scene.objects.push_back({made::shared(made::sphere(0.05, 16, 0.05)), {}});
  scene.objects.push_back(
      {made::shared(scaled_and_moved(make_box(Vec3(0.05, 0.05, 0.05)), 1.0, Vec3(0.08, 0, 0))), {.stiffness_n_per_m = 500.0}});
  return scene;
}

TEST(SmoothScene, SelectsTheNearestAndKnowsHowFarTheyAreComplete) {
  const std::uint64_t seed = 71;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-0.12, 0.12);
  for (const int directions : {6, 14, 18, 26}) {
    const auto scene = SmoothScene::build(two_objects(), {.surface = {}, .directions = directions});
    ASSERT_TRUE(scene) << scene.error().what;
    const auto set = std::make_unique<LocalSet>();
    for (int i = 0; i < 40; ++i) {
      const Vec3 p(unit(random), unit(random), unit(random));
      const Vec3 q = i % 2 == 0 ? p : Vec3(p + 0.03 * Vec3(unit(random), unit(random), unit(random)));
      const std::uint32_t count = std::array{16U, 64U, 256U}[i % 3];
      scene->select({p, q}, count, *set);
      EXPECT_EQ(set->count, count);
      EXPECT_EQ(set->version, scene->version());
      std::set<Id> ids;
      for (std::uint32_t t = 0; t < set->count; ++t) ids.insert({set->triangles[t].object, set->triangles[t].triangle});
      double least = 1e9;
      scene->for_each([&](const SetTriangle& t) {
        const double d =
            std::sqrt(segment_triangle_distance_squared<double>(of3(p), of3(q), of3(t.corner[0]), of3(t.corner[1]), of3(t.corner[2])));
        least = std::min(least, d);
        if (d < set->radius) {
          EXPECT_TRUE(ids.count({t.object, t.triangle}));
        }
      });
      EXPECT_LE(set->nearest, least);
      EXPECT_NEAR(set->nearest, least, 2.0 * scene->tolerance() + 1e-12);
    }
  }
}

// The bound that an earlier set gives is invalid in another scene of the same version.
TEST(SmoothScene, ASetOfAnotherSceneHidesNothing) {
  TouchScene small = two_objects();
  for (TouchObject& object : small.objects)
    object.mesh = std::make_shared<TriangleMesh>(scaled_and_moved(*object.mesh, 0.01, Vec3::Zero()));
  const auto other = SmoothScene::build(small, {});
  const auto scene = SmoothScene::build(two_objects(), {});
  ASSERT_TRUE(other && scene);
  ASSERT_EQ(other->version(), scene->version());
  const Vec3 p(0.0, 0.0, 0.0);
  const auto used = std::make_unique<LocalSet>();
  const auto fresh = std::make_unique<LocalSet>();
  other->select({p, p}, 64, *used);
  const double other_radius = used->radius;
  scene->select({p, p}, 64, *used);
  scene->select({p, p}, 64, *fresh);
  EXPECT_LT(other_radius, fresh->radius);
  EXPECT_EQ(used->count, 64U);
  EXPECT_EQ(used->radius, fresh->radius);
  EXPECT_EQ(used->nearest, fresh->nearest);
}

TEST(SmoothScene, GivesEachTriangleItsObjectsMaterialAndNormals) {
  const TouchScene touch = two_objects();
  const auto scene = SmoothScene::build(touch, {});
  ASSERT_TRUE(scene);
  std::array<std::size_t, 2> faces = {};
  scene->for_each([&](const SetTriangle& t) {
    ASSERT_LT(t.object, faces.size());
    EXPECT_EQ(t.two_sided, touch.objects[t.object].material.two_sided);
    for (const Vec3& n : t.normal) EXPECT_NEAR(n.norm(), 1.0, 1e-9);
    if (t.kind == SurfaceKind::face) {
      ++faces[t.object];
      EXPECT_NEAR(t.face_normal.norm(), 1.0, 1e-12);
      for (const Vec3& n : t.normal) EXPECT_GT(n.dot(t.face_normal), 0.0);
    } else {
      EXPECT_TRUE(t.face_normal.isZero(0.0));
    }
  });
  EXPECT_EQ(faces[0], scene->surface(0).face_count);
  EXPECT_EQ(faces[1], scene->surface(1).face_count);
}

TEST(SmoothScene, FollowsMovedVerticesAsIfBuiltAgain) {
  TouchScene touch = two_objects();
  auto moved = SmoothScene::build(touch, {});
  ASSERT_TRUE(moved);
  auto mesh = std::make_shared<TriangleMesh>(*touch.objects[1].mesh);
  for (Vec3& v : mesh->vertices) v = Vec3(v.y(), v.z(), v.x()) + Vec3(0.01, 0.0, 0.02);
  const std::uint64_t version = moved->version();
  ASSERT_TRUE(moved->move_vertices(1, mesh->vertices));
  EXPECT_GT(moved->version(), version);
  touch.objects[1].mesh = mesh;
  const auto anew = SmoothScene::build(touch, {});
  ASSERT_TRUE(anew);
  EXPECT_EQ(moved->diagonal(), anew->diagonal());
  EXPECT_EQ(moved->centre(), anew->centre());
  const auto one = std::make_unique<LocalSet>();
  const auto other = std::make_unique<LocalSet>();
  for (const Vec3& p : {Vec3(0.0, 0.0, 0.09), Vec3(0.03, 0.02, 0.0), Vec3(0.2, 0.1, 0.0)}) {
    moved->select({p, p}, 64, *one);
    anew->select({p, p}, 64, *other);
    EXPECT_NEAR(one->radius, other->radius, 1e-12);
    EXPECT_NEAR(one->nearest, other->nearest, 1e-12);
  }
  EXPECT_FALSE(moved->move_vertices(7, mesh->vertices));
  EXPECT_FALSE(moved->move_vertices(0, mesh->vertices));
  mesh->vertices[3].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(moved->move_vertices(1, mesh->vertices));
}

TEST(SmoothScene, RejectsDirectionsItDoesNotHave) {
  const auto scene = SmoothScene::build(two_objects(), {.surface = {}, .directions = 10});
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().what.find("14"), std::string::npos);
}

TEST(SmoothScene, DescribesEveryPassAndTheTree) {
  const auto scene = SmoothScene::build(two_objects(), {});
  const std::string text = scene->describe();
  for (const char* word : {"object 1: repair:", "split:", "fans:", "tree: hulls of 14 directions"})
    EXPECT_NE(text.find(word), std::string::npos) << word;
}

// On a plane the typical radius grows with the square root of the count: doubling the count widens it by sqrt 2.
TEST(SmoothScene, TypicalRadiusGrowsWithTheCount) {
  TouchScene touch;
  touch.objects.push_back({made::shared(make_plane_grid(0.1, 60)), {}});
  const auto scene = SmoothScene::build(touch, {});
  const double radius_of_32 = scene->compute_typical_radius(32);
  EXPECT_GT(radius_of_32, 0.1 / 60.0);
  EXPECT_NEAR(scene->compute_typical_radius(128) / radius_of_32, 2.0, 0.6);
}

}  // namespace
}  // namespace hapton
