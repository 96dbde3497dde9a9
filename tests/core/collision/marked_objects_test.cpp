#include "core/collision/marked_objects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>
#include <vector>

#include "core/collision/touch_geometry.h"
#include "core/geometry/mesh_shapes.h"
#include "core/math/rotation_vector.h"

namespace hapton {
namespace {

using MarkedMeshes = std::vector<std::shared_ptr<const TriangleMesh>>;
using MarkedList = std::vector<std::shared_ptr<const ObjectGeometry>>;

TriangleMesh turned_mesh(TriangleMesh mesh, const Vec3& turn, const Vec3& by) {
  const Mat3 rotation = turn_by(turn).toRotationMatrix();
  for (Vec3& v : mesh.vertices) v = rotation * v + by;
  return mesh;
}

// A table, a cube that stands on it, a ball in the air, a box within the ball, and a cylinder far off. Lengths in units of `size`.
TriangleMesh marked_shape(std::size_t object) {
  switch (object) {
    case 0:
      return make_box({1.0, 1.0, 0.1}, 8);
    case 1:
      return make_box({0.1, 0.1, 0.1}, 4);
    case 2:
      return make_bumpy_sphere(0.1, 0.1, 300, 5);
    case 3:
      return make_box({0.04, 0.04, 0.04}, 2);
    default:
      return make_cylinder(0.05, 0.2, 12, 3);
  }
}

Vec3 marked_place(std::size_t object) {
  switch (object) {
    case 0:
      return {0.0, 0.0, -0.05};
    case 1:
      return {0.2, 0.0, 0.05};
    case 2:
    case 3:
      return {-0.2, 0.1, 0.3};
    default:
      return {0.3, 0.3, 0.4};
  }
}

constexpr std::size_t kObjects = 5;

// The shapes above at any scale. Objects that are moved must stay within the box of the first arrangement, which determines the frame.
struct MarkedScene {
  explicit MarkedScene(double size_m) : size(size_m) {
    Box box;
    for (std::size_t o = 0; o < kObjects; ++o) {
      meshes.push_back(nullptr);
      put(o, Vec3::Zero(), marked_place(o));
      for (const Vec3& v : meshes[o]->vertices) box.grow(v);
    }
    scene_box = box;
    frame = TouchGeometry::frame_of(box);
  }

  void put(std::size_t object, const Vec3& turn, const Vec3& at) {
    meshes[object] =
        std::make_shared<const TriangleMesh>(scaled_and_moved(turned_mesh(marked_shape(object), turn, at), size, Vec3::Zero()));
    unmarked.resize(meshes.size());
    bounds.resize(meshes.size());
    if (frame) build(object);
  }
  void build(std::size_t object) {
    Box box;
    for (const Vec3& v : meshes[object]->vertices) box.grow(v);
    bounds[object] = TouchGeometry::local_bounds(*frame, box);
    unmarked[object] =
        std::make_shared<const ObjectGeometry>(ObjectGeometry::make(*meshes[object], *frame, TouchGeometry::most_triangles(meshes)));
  }
  MarkedList mark() {
    for (std::size_t o = 0; o < kObjects; ++o) {
      if (unmarked[o] == nullptr) build(o);
    }
    return marked.update(unmarked, bounds);
  }
  // Expects the same objects as when the whole scene is built at once.
  void expect_as_built_anew(const MarkedList& objects) const {
    Box box = scene_box;
    for (const auto& mesh : meshes) {
      for (const Vec3& v : mesh->vertices) box.grow(v);
    }
    ASSERT_EQ(TouchGeometry::frame_of(box).origin, frame->origin) << "the test's objects lie within its scene";
    const TouchGeometry anew(meshes, BuildPolicy::at_once, std::nullopt, scene_box);
    for (std::uint32_t o = 0; o < kObjects; ++o) {
      const ObjectGeometry& expected = anew.object_geometry(o);
      ASSERT_EQ(objects[o]->triangle_count(), expected.triangle_count());
      for (std::uint32_t t = 0; t < expected.triangle_count(); ++t) {
        ASSERT_EQ(objects[o]->triangle(t), expected.triangle(t));
        for (int k = 0; k < 3; ++k) ASSERT_EQ(objects[o]->corner(t, k), expected.corner(t, k));
        ASSERT_EQ(objects[o]->adjacency().is_walkable(t), expected.adjacency().is_walkable(t)) << "object " << o << " triangle " << t;
      }
    }
  }

  double size;
  MarkedMeshes meshes;
  MarkedList unmarked;
  std::vector<Box> bounds;
  Box scene_box;
  std::optional<LocalFrame> frame;
  MarkedObjects marked;
};

std::size_t unwalkable_count(const ObjectGeometry& object) { return object.triangle_count() - object.adjacency().walkable_count(); }

TEST(MarkedObjects, OnlyObjectsThatTouchAreCopied) {
  MarkedScene scene(1.0);
  const MarkedList first = scene.mark();
  EXPECT_GT(unwalkable_count(*first[0]), 0U) << "under the cube";
  EXPECT_GT(unwalkable_count(*first[1]), 0U);
  for (const std::size_t o : {0, 1}) EXPECT_NE(first[o], scene.unmarked[o]);
  for (const std::size_t o : {2, 3, 4}) EXPECT_EQ(first[o], scene.unmarked[o]) << "near none, also within another";
  EXPECT_EQ(unwalkable_count(*scene.unmarked[0]), 0U) << "the unmarked object stays as it is";
  scene.expect_as_built_anew(first);
}

TEST(MarkedObjects, WhatAMoveDoesNotConcernIsTheSameObjectAsBefore) {
  MarkedScene scene(1.0);
  const MarkedList first = scene.mark();
  EXPECT_EQ(scene.mark(), first);
  // The cylinder moves from one place in the air to another.
  scene.put(4, {0.3, 0.2, 0.1}, {0.3, -0.3, 0.3});
  const MarkedList second = scene.mark();
  for (const std::size_t o : {0, 1, 2, 3}) EXPECT_EQ(second[o], first[o]) << o;
  EXPECT_EQ(second[4], scene.unmarked[4]);
  // The cube is lifted off the table: its marks go, and the table is the unmarked object again.
  scene.put(1, Vec3::Zero(), {0.2, 0.0, 0.2});
  const MarkedList third = scene.mark();
  EXPECT_EQ(third[0], scene.unmarked[0]);
  EXPECT_EQ(third[1], scene.unmarked[1]);
  // The cylinder is put onto the table, and the cube onto another part of it.
  scene.put(4, Vec3::Zero(), {0.3, 0.3, 0.1});
  scene.put(1, Vec3::Zero(), {-0.3, 0.2, 0.05});
  const MarkedList fourth = scene.mark();
  scene.expect_as_built_anew(fourth);
  // Only the cube leaves: the marks under the cylinder stay.
  scene.put(1, Vec3::Zero(), {0.2, 0.0, 0.2});
  const MarkedList fifth = scene.mark();
  EXPECT_EQ(fifth[4], fourth[4]);
  EXPECT_GT(unwalkable_count(*fifth[0]), 0U);
  EXPECT_LT(unwalkable_count(*fifth[0]), unwalkable_count(*fourth[0]));
  scene.expect_as_built_anew(fifth);
}

// The objects touch, overlap, enclose each other or are far apart; one of them moves each time.
TEST(MarkedObjects, AreThoseOfASceneThatIsBuiltAnewWhateverHasMoved) {
  constexpr unsigned kSeed = 224;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (const double size : {1.0, 1e-6, 1e6}) {
    SCOPED_TRACE(testing::Message() << "seed " << kSeed << ", size " << size);
    MarkedScene scene(size);
    std::size_t unwalkable = 0;
    for (int n = 0; n < 40; ++n) {
      const std::size_t object = 1 + static_cast<std::size_t>(random() % (kObjects - 1));
      const double x = 0.35 * uniform(random);
      const double y = 0.35 * uniform(random);
      const bool stands = n % 3 != 0;
      const Vec3 turn = stands ? Vec3(0.0, 0.0, uniform(random)) : Vec3(uniform(random), uniform(random), uniform(random));
      scene.put(object, turn, {x, y, stands && object == 1 ? 0.05 : 0.12 + 0.1 * uniform(random)});
      const MarkedList objects = scene.mark();
      scene.expect_as_built_anew(objects);
      if (testing::Test::HasFatalFailure()) return;
      for (const auto& each : objects) unwalkable += unwalkable_count(*each);
    }
    EXPECT_GT(unwalkable, 500U) << "most of them touch others";
  }
}

TEST(MarkedObjects, AnObjectWithoutTrianglesIsNearNone) {
  MarkedObjects marked;
  const LocalFrame frame;
  const auto box = std::make_shared<const ObjectGeometry>(make_box({0.5, 0.5, 0.5}, 2), frame);
  const auto empty = std::make_shared<const ObjectGeometry>(TriangleMesh(), frame);
  const std::vector<Box> bounds = {box->bounds(), Box(), box->bounds()};
  const auto objects = marked.update({box, empty, box}, bounds);
  EXPECT_EQ(objects[1], empty);
  EXPECT_EQ(objects[0]->adjacency().walkable_count(), 0U) << "every triangle lies on one of the other";
  EXPECT_TRUE(marked.update({}, {}).empty());
}

}  // namespace
}  // namespace hapton
