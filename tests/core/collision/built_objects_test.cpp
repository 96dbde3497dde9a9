#include "core/collision/built_objects.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "core/collision/marked_objects.h"
#include "core/collision/touch_geometry.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

using BuiltMeshes = std::vector<std::shared_ptr<const TriangleMesh>>;

// A plate, a cube on it, an empty mesh, and a ball beside them.
BuiltMeshes make_built_meshes() {
  return {std::make_shared<TriangleMesh>(scaled_and_moved(make_box({0.2, 0.2, 0.01}, 6), 1.0, {0.0, 0.0, -0.005})),
          std::make_shared<TriangleMesh>(scaled_and_moved(make_box({0.02, 0.02, 0.02}, 3), 1.0, {0.0, 0.0, 0.01})),
          std::make_shared<TriangleMesh>(),
          std::make_shared<TriangleMesh>(scaled_and_moved(make_bumpy_sphere(0.02, 0.05, 300, 4), 1.0, {0.05, 0.0, 0.04}))};
}

BuiltObjects build_all(const BuiltMeshes& meshes) {
  BuiltObjects built;
  built.meshes = meshes;
  Box scene;
  std::vector<Box> boxes;
  for (const auto& mesh : meshes) {
    boxes.emplace_back();
    for (const Vec3& v : mesh->vertices) boxes.back().grow(v);
    scene.grow(boxes.back());
  }
  built.frame = TouchGeometry::frame_of(scene);
  std::vector<std::shared_ptr<const ObjectGeometry>> unmarked;
  for (std::size_t o = 0; o < meshes.size(); ++o) {
    built.bounds.push_back(TouchGeometry::local_bounds(built.frame, boxes[o]));
    unmarked.push_back(
        std::make_shared<const ObjectGeometry>(ObjectGeometry::make(*meshes[o], built.frame, TouchGeometry::most_triangles(meshes))));
  }
  built.objects = MarkedObjects().update(unmarked, built.bounds);
  return built;
}

TEST(BuiltObjects, AreBuiltFromTheirMeshesAndCreaseAlone) {
  const BuiltMeshes meshes = make_built_meshes();
  BuiltObjects built;
  built.meshes = meshes;
  EXPECT_TRUE(built.are_built_from(meshes, std::nullopt));
  EXPECT_FALSE(built.are_built_from(meshes, 0.5));
  built.shading_crease_rad = 0.5;
  EXPECT_TRUE(built.are_built_from(meshes, 0.5));
  EXPECT_FALSE(built.are_built_from(meshes, 0.25));
  EXPECT_FALSE(built.are_built_from(meshes, std::nullopt));
  BuiltMeshes other = meshes;
  other.pop_back();
  EXPECT_FALSE(built.are_built_from(other, 0.5));
  other = meshes;
  other[1] = std::make_shared<TriangleMesh>(*other[1]);
  EXPECT_FALSE(built.are_built_from(other, 0.5)) << "an equal mesh, but another one";
}

// Compares numbers of triangles, marks, adjacency and queries.
TEST(BuiltObjects, MakeTheGeometryThatTheirMeshesMake) {
  const BuiltMeshes meshes = make_built_meshes();
  const TouchGeometry from_meshes(meshes);
  const TouchGeometry from_objects(build_all(meshes));
  EXPECT_EQ(from_objects.origin(), from_meshes.origin());
  EXPECT_EQ(from_objects.unit_m(), from_meshes.unit_m());
  EXPECT_EQ(from_objects.object_bits(), from_meshes.object_bits());
  EXPECT_EQ(from_objects.waiting_count(), 0U);
  EXPECT_EQ(from_objects.built_count(), 4U);
  EXPECT_EQ(from_objects.bytes(), from_meshes.bytes());
  std::vector<std::uint32_t> all;
  from_meshes.for_each_overlapping(Box{Vec3::Constant(-2.0), Vec3::Constant(2.0)}, [&](std::uint32_t id) { all.push_back(id); });
  ASSERT_EQ(all.size(), from_meshes.triangle_count());
  std::size_t unwalkable = 0;
  for (const std::uint32_t id : all) {
    for (int k = 0; k < 3; ++k) {
      ASSERT_EQ(from_objects.corner(id, k), from_meshes.corner(id, k));
      ASSERT_EQ(from_objects.adjacent(id, k).id, from_meshes.adjacent(id, k).id);
    }
    ASSERT_EQ(from_objects.is_walkable(id), from_meshes.is_walkable(id)) << id;
    unwalkable += from_meshes.is_walkable(id) ? 0 : 1;
  }
  EXPECT_GT(unwalkable, 10U) << "where cube and plate touch";
  constexpr unsigned kSeed = 31;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> uniform(-0.6, 0.6);
  for (int n = 0; n < 300; ++n) {
    const Vec3 p(uniform(random), uniform(random), 0.5 * uniform(random));
    const auto found = [&](const TouchGeometry& geometry) {
      std::vector<std::uint32_t> ids;
      geometry.visit_nearest(p, 0.04, [&](std::uint32_t id, double bound) {
        ids.push_back(id);
        return bound;
      });
      return ids;
    };
    ASSERT_EQ(found(from_objects), found(from_meshes)) << n;
  }
}

}  // namespace
}  // namespace hapton
