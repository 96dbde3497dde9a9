#include "core/collision/object_geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

// The same triangles as the mesh, in some order, within the grid's rounding.
TEST(ObjectGeometry, HoldsTheMeshesTriangles) {
  const TriangleMesh mesh = make_torus(0.04, 0.01, 24, 12);
  const LocalFrame frame{.origin = Vec3(0.01, 0, 0), .unit_m = 0.0625};
  const ObjectGeometry object(mesh, frame);
  ASSERT_EQ(object.triangle_count(), mesh.triangles.size());
  std::vector<Vec3> expected;
  std::vector<Vec3> found;
  for (std::uint32_t t = 0; t < object.triangle_count(); ++t) {
    expected.push_back((mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0);
    found.push_back(frame.to_scene((object.corner(t, 0) + object.corner(t, 1) + object.corner(t, 2)) / 3.0));
  }
  std::set<Vec3*> nearest_of_all;
  for (const Vec3& centroid : found) {
    const auto nearest = std::min_element(expected.begin(), expected.end(),
                                          [&](const Vec3& a, const Vec3& b) { return (a - centroid).norm() < (b - centroid).norm(); });
    EXPECT_LE((*nearest - centroid).norm(), 1e-15);
    nearest_of_all.insert(&*nearest);
  }
  EXPECT_EQ(nearest_of_all.size(), expected.size()) << "each triangle once";
}

TEST(ObjectGeometry, BoundsAreThoseOfItsVertices) {
  const ObjectGeometry object(make_box({1, 2, 3}, 1), {.origin = Vec3(1, 0, 0), .unit_m = 2.0});
  EXPECT_EQ(object.bounds().low, object.with_origin_at(Vec3(0.5, 0, 0)).bounds().low + Vec3(0.5, 0, 0));
  EXPECT_EQ((object.bounds().high - object.bounds().low).eval(), Vec3(0.5, 1.0, 1.5));
}

TriangleMesh turned_and_moved(TriangleMesh mesh, const Quat& turn, const Vec3& by) {
  for (Vec3& v : mesh.vertices) v = turn * v + by;
  return mesh;
}

// The twin tests every pair of triangles of two cubes. They overlap, stand on each other, or have a gap of about the margin.
TEST(ObjectGeometry, FindsTheTrianglesThatAreNearAnotherObject) {
  constexpr unsigned kSeed = 2241;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const ObjectGeometry object(make_box({0.5, 0.5, 0.5}, 4), {});
  std::size_t most_found = 0;
  std::size_t empty_count = 0;
  for (int n = 0; n < 60; ++n) {
    const bool stands_on_object = n % 2 == 0;
    const double gap = n % 4 == 0 ? 0.0 : 1.5 * uniform(random) * ObjectGeometry::kWalkableMargin;
    const Vec3 by = stands_on_object ? Vec3(0.3 * uniform(random), 0.3 * uniform(random), 0.4 + gap)
                                     : Vec3(0.45 * Vec3(uniform(random), uniform(random), uniform(random)));
    const Quat turn = stands_on_object ? Quat(Eigen::AngleAxisd(uniform(random), Vec3::UnitZ()))
                                       : Quat(uniform(random), uniform(random), uniform(random), uniform(random)).normalized();
    const ObjectGeometry other(turned_and_moved(make_box({0.3, 0.3, 0.3}, 3), turn, by), {});
    for (const auto& [own, neighbour] : {std::pair(&object, &other), std::pair(&other, &object)}) {
      std::vector<std::uint32_t> expected;
      for (std::uint32_t u = 0; u < own->triangle_count(); ++u) {
        bool near = false;
        for (std::uint32_t t = 0; t < neighbour->triangle_count(); ++t) {
          near = near ||
                 !are_apart({own->corner(u, 0), own->corner(u, 1), own->corner(u, 2)},
                            {neighbour->corner(t, 0), neighbour->corner(t, 1), neighbour->corner(t, 2)}, ObjectGeometry::kWalkableMargin);
        }
        if (near) expected.push_back(u);
      }
      std::vector<std::uint32_t> found = own->find_near(*neighbour, own->bounds());
      std::ranges::sort(found);
      ASSERT_EQ(found, expected) << n;
      most_found = std::max(most_found, found.size());
      empty_count += found.empty() ? 1 : 0;
      ObjectGeometry marked = *own;
      marked.mark_unwalkable(found);
      for (std::uint32_t u = 0; u < own->triangle_count(); ++u)
        ASSERT_EQ(marked.adjacency().is_walkable(u), !std::ranges::binary_search(expected, u)) << n;
    }
  }
  EXPECT_GT(most_found, 20U);
  EXPECT_GT(empty_count, 4U);
}

TEST(ObjectGeometry, CopiesShareTheSurfaceButNotTheMarks) {
  const ObjectGeometry object(make_bumpy_sphere(0.3, 0.2, 300, 5), {}, 0.7);
  ObjectGeometry copy = object;
  EXPECT_EQ(copy.vertices().data(), object.vertices().data());
  EXPECT_EQ(&copy.triangle(7), &object.triangle(7));
  EXPECT_EQ(&copy.tree(), &object.tree());
  EXPECT_EQ(copy.bytes(), object.bytes());
  const std::vector<std::uint32_t> marked = {3, 7};
  copy.mark_unwalkable(marked);
  for (std::uint32_t t = 0; t < object.triangle_count(); ++t) {
    EXPECT_EQ(copy.adjacency().is_walkable(t), object.adjacency().is_walkable(t) && t != 3 && t != 7) << t;
    EXPECT_TRUE(object.adjacency().is_walkable(t)) << t;
    EXPECT_EQ(copy.smooth_normal(t, copy.corner(t, 0)), object.smooth_normal(t, object.corner(t, 0)));
  }
}

TEST(ObjectGeometry, NothingIsNearAnObjectWithoutTriangles) {
  const ObjectGeometry box(make_box({0.5, 0.5, 0.5}, 4), {});
  const ObjectGeometry empty(TriangleMesh(), {});
  EXPECT_TRUE(box.find_near(empty, box.bounds()).empty());
  EXPECT_TRUE(empty.find_near(box, empty.bounds()).empty());
}

TEST(ObjectGeometry, NeighboursAreNearInMemory) {
  const TriangleMesh mesh = make_icosphere(0.05, 5);
  const ObjectGeometry object(mesh, {});
  double total_jump = 0.0;
  for (std::uint32_t t = 1; t < object.triangle_count(); ++t) total_jump += (object.corner(t, 0) - object.corner(t - 1, 0)).norm();
  // Edges are about 2.3 mm long; an unordered list would jump by about 67 mm.
  EXPECT_LT(total_jump / object.triangle_count(), 0.006);
}

TEST(ObjectGeometry, SmoothNormalsAreTheAuthoredOnesWhereTheyAreValid) {
  TriangleMesh mesh = make_box({1, 1, 1}, 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<Eigen::Vector3f, 3> normals;
    for (int k = 0; k < 3; ++k) normals[k] = mesh.corner(t, k).cast<float>();
    mesh.authored_normals.push_back(normals);
  }
  constexpr double kCrease = 0.7;
  const ObjectGeometry rounded(mesh, {}, kCrease);
  for (std::uint32_t t = 0; t < rounded.triangle_count(); ++t) {
    const Vec3& a = rounded.corner(t, 0);
    const Vec3& b = rounded.corner(t, 1);
    const Vec3& c = rounded.corner(t, 2);
    const auto expect_normal = [&](const Vec3& at, const Vec3& expected) {
      EXPECT_LT((rounded.smooth_normal(t, at) - expected.normalized()).norm(), 1e-6);
    };
    for (const Vec3& corner : {a, b, c}) expect_normal(corner, corner);
    const Vec3 inside = 0.2 * a + 0.3 * b + 0.5 * c;
    expect_normal(inside, 0.2 * a.normalized() + 0.3 * b.normalized() + 0.5 * c.normalized());
    // Rounding may put the point a little beside the triangle.
    expect_normal(1.5 * a - 0.25 * (b + c), a);
    expect_normal(1.5 * b - 0.5 * a, b);
    expect_normal(1.5 * c - 0.5 * a, c);
    expect_normal(0.7 * b + 0.5 * c - 0.2 * a, 0.7 * b.normalized() + 0.3 * c.normalized());
  }
  for (auto& normals : mesh.authored_normals) normals = {-normals[0], -normals[1], -normals[2]};
  const ObjectGeometry sharp(mesh, {}, kCrease);
  for (std::uint32_t t = 0; t < sharp.triangle_count(); ++t) {
    const Vec3 normal = sharp.smooth_normal(t, sharp.corner(t, 1));
    EXPECT_NEAR(normal.cwiseAbs().maxCoeff(), 1.0, 1e-6) << "turned inwards, they are not valid";
  }
}

TEST(ObjectGeometry, ATriangleWithoutAreaHasNoSmoothNormal) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0.5, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}};
  const ObjectGeometry object(mesh, {}, 0.7);
  int without_area = 0;
  for (std::uint32_t t = 0; t < object.triangle_count(); ++t) {
    const bool has_area = object.corner(t, 0).y() + object.corner(t, 1).y() + object.corner(t, 2).y() > 0.0;
    without_area += has_area ? 0 : 1;
    EXPECT_EQ(object.smooth_normal(t, Vec3(0.25, 0, 0)), has_area ? Vec3::UnitZ().eval() : Vec3::Zero().eval());
  }
  EXPECT_EQ(without_area, 1);
}

TEST(ObjectGeometry, WithAnotherOriginItIsTheSameSurface) {
  const ObjectGeometry surface(make_bumpy_sphere(0.3, 0.2, 300, 5), {Vec3::Zero(), 1.0});
  const Vec3 p(0.1234567890123456, -0.2, 1.0 / 3.0);
  const ObjectGeometry other = surface.with_origin_at(p);
  ASSERT_EQ(other.triangle_count(), surface.triangle_count());
  for (std::uint32_t t = 0; t < surface.triangle_count(); ++t) {
    ASSERT_EQ(other.triangle(t), surface.triangle(t));
    for (int k = 0; k < 3; ++k) {
      ASSERT_LT((other.corner(t, k) - (surface.corner(t, k) - p)).cwiseAbs().maxCoeff(), 0x1p-51);
      // Edges are exact.
      ASSERT_EQ(other.corner(t, k) - other.corner(t, 0), surface.corner(t, k) - surface.corner(t, 0));
      ASSERT_EQ(other.adjacency().adjacent(t, k).triangle, surface.adjacency().adjacent(t, k).triangle);
    }
  }
}

TEST(ObjectGeometry, AnEmptyMeshIsEmpty) {
  const ObjectGeometry object(TriangleMesh(), {});
  EXPECT_EQ(object.triangle_count(), 0U);
  int visits = 0;
  object.tree().for_each_overlapping(Box{Vec3::Constant(-1), Vec3::Constant(1)}, [&](std::uint32_t) { ++visits; });
  EXPECT_EQ(visits, 0);
}

}  // namespace
}  // namespace hapton
