#include "core/collision/fdh_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"
#include "tests/support/obj_mesh.h"

namespace hapton {
namespace {

using Ids = std::set<std::uint32_t>;

struct NamedMesh {
  std::string name;
  TriangleMesh mesh;
};

const std::vector<NamedMesh>& meshes() {
  static const std::vector<NamedMesh> kMeshes = [] {
    std::vector<NamedMesh> all;
    all.push_back({"soup", made::soup(31, 1500, 1.0, 0.2)});
    all.push_back({"bumpy", made::sphere(0.05, 24, 0.1)});
    all.push_back({"car front", made::obj_mesh("car_front_3300.obj")});
    all.push_back({"wingnut", made::obj_mesh("wingnut.obj")});
    all.push_back({"one triangle", {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {{0, 1, 2}}}});
    all.push_back({"one point many times", {{Vec3(3, 4, 5)}, std::vector<Triangle>(50, Triangle{0, 0, 0})}});
    all.push_back(
        {"same triangle many times", {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, std::vector<Triangle>(50, Triangle{0, 1, 2})}});
    all.push_back({"far away", scaled_and_moved(made::sphere(1.0, 16, 0.1), 1.0, {1e6, -1e6, 1e6})});
    all.push_back({"tiny", scaled_and_moved(made::sphere(1.0, 16, 0.1), 1e-6, {0, 0, 0})});
    all.push_back({"tiny and off", scaled_and_moved(made::sphere(1.0, 16, 0.1), 1e-6, {1, 2, 3})});
    all.push_back({"huge", scaled_and_moved(made::sphere(1.0, 16, 0.1), 1e6, {0, 0, 0})});
    return all;
  }();
  return kMeshes;
}

// Query points about the mesh: near triangles, exactly at corners, around the box, far away.
struct QueryPoints {
  const TriangleMesh& mesh;
  std::mt19937_64 random{41};
  std::uniform_real_distribution<double> unit{-1.0, 1.0};
  double size = 0.0;

  explicit QueryPoints(const TriangleMesh& m) : mesh(m) {
    Vec3 low = m.vertices[0];
    Vec3 high = low;
    for (const Vec3& v : m.vertices) {
      low = low.cwiseMin(v);
      high = high.cwiseMax(v);
    }
    size = std::max((high - low).norm(), low.norm() * 1e-9);
  }
  Vec3 direction() { return {unit(random), unit(random), unit(random)}; }
  Vec3 make(int i) {
    const auto t = random() % mesh.triangles.size();
    if (i % 4 == 0) return mesh.corner(t, i % 3);
    if (i % 4 == 1) return (mesh.corner(t, 0) + mesh.corner(t, 1)) * 0.5;
    if (i % 4 == 2) return mesh.corner(t, 1) + 0.05 * size * direction();
    return mesh.corner(t, 2) + 3.0 * size * direction();
  }
};

double distance_squared(const TriangleMesh& mesh, std::size_t t, const Vec3& p) {
  return triangle_distance_squared(p, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
}

template <class T>
class FdhTreeOf : public testing::Test {};

template <int K>
struct Directions {
  static constexpr int kCount = K;
};
using AllDirections = testing::Types<Directions<6>, Directions<14>, Directions<18>, Directions<26>>;
TYPED_TEST_SUITE(FdhTreeOf, AllDirections);

// Expects that every required triangle is visited, once, and only allowed ones.
template <class Tree, class Query, class Required, class Allowed>
void expect_visits(const Tree& tree, const TriangleMesh& mesh, const Query& query, const std::string& what, Required&& required,
                   Allowed&& allowed) {
  Ids visited;
  tree.for_each_overlapping(query, [&](std::uint32_t t) { EXPECT_TRUE(visited.insert(t).second) << what << ": visited twice"; });
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const bool is_visited = visited.count(t) > 0;
    if (required(t)) {
      EXPECT_TRUE(is_visited) << what << ": triangle " << t << " is missing";
    }
    if (is_visited) {
      EXPECT_TRUE(allowed(t)) << what << ": triangle " << t << " should not be visited";
    }
  }
}

TYPED_TEST(FdhTreeOf, BallFindsWhatBruteForceFinds) {
  for (const auto& [name, mesh] : meshes()) {
    const auto tree = FdhTree<TypeParam::kCount>::build(mesh.vertices, mesh.triangles);
    ASSERT_TRUE(tree) << tree.error().what;
    QueryPoints points(mesh);
    for (int i = 0; i < 60; ++i) {
      const Vec3 p = points.make(i);
      const double radius = points.size * (i % 5) * 0.04;
      const double tolerance = 1e-12 * (points.size + p.norm());
      expect_visits(
          *tree, mesh, FdhBall{p, radius}, name, [&](std::uint32_t t) { return std::sqrt(distance_squared(mesh, t, p)) <= radius; },
          [&](std::uint32_t t) { return std::sqrt(distance_squared(mesh, t, p)) <= radius + tolerance; });
    }
  }
}

TYPED_TEST(FdhTreeOf, SweptBallFindsWhatBruteForceFinds) {
  for (const auto& [name, mesh] : meshes()) {
    const auto tree = FdhTree<TypeParam::kCount>::build(mesh.vertices, mesh.triangles);
    ASSERT_TRUE(tree);
    QueryPoints points(mesh);
    for (int i = 0; i < 60; ++i) {
      const Vec3 p = points.make(i);
      Vec3 q = i % 7 == 0 ? p : Vec3(p + (i % 2 == 0 ? 0.3 : 0.01) * points.size * points.direction());
      if (i % 5 == 1) q = points.make(i + 2);
      if (i % 11 == 2) q = Vec3(p.x(), p.y(), p.z() + 0.2 * points.size);  // along an axis: two components are zero
      const double radius = i % 3 == 0 ? 0.0 : points.size * 0.02 * (i % 3);
      const double tolerance = 1e-12 * (points.size + p.norm());
      const auto distance = [&](std::uint32_t t) {
        return std::sqrt(segment_triangle_distance_squared<double>(of3(p), of3(q), of3(mesh.corner(t, 0)), of3(mesh.corner(t, 1)),
                                                                   of3(mesh.corner(t, 2))));
      };
      expect_visits(
          *tree, mesh, FdhSweep{p, q, radius}, name, [&](std::uint32_t t) { return distance(t) <= radius; },
          [&](std::uint32_t t) { return radius == 0.0 || distance(t) <= radius + tolerance; });
    }
  }
}

TYPED_TEST(FdhTreeOf, NearestIsTheNearest) {
  for (const auto& [name, mesh] : meshes()) {
    const auto tree = FdhTree<TypeParam::kCount>::build(mesh.vertices, mesh.triangles);
    ASSERT_TRUE(tree);
    QueryPoints points(mesh);
    for (int i = 0; i < 100; ++i) {
      const Vec3 p = points.make(i);
      FdhNear best = kNothingNear;
      for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const double d = distance_squared(mesh, t, p);
        if (d < best.distance_squared) best = {d, t, 0};
      }
      const FdhNear found = tree->find_nearest(p);
      EXPECT_EQ(found.distance_squared, best.distance_squared) << name;
      EXPECT_EQ(found.triangle, best.triangle) << name << ": of equally near triangles the first";
      if (best.distance_squared > 0.0) {
        EXPECT_FALSE(std::isfinite(tree->find_nearest(p, 0.999 * std::sqrt(best.distance_squared)).distance_squared)) << name;
      }
    }
  }
}

TYPED_TEST(FdhTreeOf, NearestSetIsCompleteWithinItsRadius) {
  for (const auto& [name, mesh] : meshes()) {
    const auto tree = FdhTree<TypeParam::kCount>::build(mesh.vertices, mesh.triangles);
    ASSERT_TRUE(tree);
    QueryPoints points(mesh);
    for (int i = 0; i < 60; ++i) {
      const Vec3 p = points.make(i);
      const Vec3 q = i % 2 == 0 ? p : Vec3(p + 0.05 * points.size * points.direction());
      const std::size_t count = std::array{1U, 16U, 64U, 256U}[i % 4];
      const double limit = i % 3 == 0 ? 0.1 * points.size : std::numeric_limits<double>::infinity();
      FdhNearest nearest(count, limit);
      tree->collect_nearest(p, q, 7, nearest);
      const auto found = nearest.finish();
      Ids ids;
      double farthest = 0.0;
      for (const FdhNear& near : found) {
        EXPECT_TRUE(ids.insert(near.triangle).second);
        EXPECT_EQ(near.object, 7U);
        farthest = std::max(farthest, std::sqrt(near.distance_squared));
      }
      EXPECT_LE(found.size(), count);
      EXPECT_LE(farthest, nearest.complete_radius() + 1e-9 * (points.size + p.norm()));
      std::size_t within = 0;
      for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const double d = std::sqrt(segment_triangle_distance_squared<double>(of3(p), of3(q), of3(mesh.corner(t, 0)), of3(mesh.corner(t, 1)),
                                                                             of3(mesh.corner(t, 2))));
        if (d < nearest.complete_radius()) {
          EXPECT_TRUE(ids.count(t)) << name << " misses " << t;
        }
        within += d <= limit ? 1 : 0;
      }
      EXPECT_EQ(found.size(), std::min(count, within)) << name;
    }
  }
}

// A triangle just within the largest distance may be missed by rounding; then the set is not complete up to that distance.
TYPED_TEST(FdhTreeOf, NearestSetIsCompleteWithinItsRadiusAlsoAtTheLargestDistance) {
  using LongVec3 = Eigen::Matrix<long double, 3, 1>;
  TriangleMesh mesh;
  mesh.vertices = {Vec3(10.13, 20.29, 30.17), Vec3(11.31, 20.57, 30.71), Vec3(10.41, 21.37, 30.23)};
  mesh.triangles = {{0, 1, 2}};
  const auto tree = FdhTree<TypeParam::kCount>::build(mesh.vertices, mesh.triangles);
  ASSERT_TRUE(tree);
  const auto exact = [&](std::size_t v) { return LongVec3(mesh.vertices[v].template cast<long double>()); };
  const LongVec3 normal = (exact(1) - exact(0)).cross(exact(2) - exact(0)).normalized();
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> weight(0.2, 0.4);
  int missed = 0;
  for (int i = 0; i < 1000; ++i) {
    const double u = weight(random);
    const double v = weight(random);
    const Vec3 p = u * mesh.vertices[0] + v * mesh.vertices[1] + (1.0 - u - v) * mesh.vertices[2] + 1e-3 * normal.template cast<double>();
    const long double distance = (p.template cast<long double>() - exact(0)).dot(normal);
    FdhNearest nearest(1, static_cast<double>(distance * (1.0L + 1e-14L)));
    tree->collect_nearest(p, 0, nearest);
    if (!nearest.finish().empty()) continue;
    ++missed;
    EXPECT_LE(static_cast<long double>(nearest.complete_radius()), distance) << i;
  }
  EXPECT_GT(missed, 0);
}

TYPED_TEST(FdhTreeOf, FollowsMovedVertices) {
  TriangleMesh mesh = made::sphere(0.05, 20, 0.1);
  auto tree = FdhTree<TypeParam::kCount>::build(mesh.vertices, mesh.triangles);
  ASSERT_TRUE(tree);
  std::vector<Vec3> moved = mesh.vertices;
  for (Vec3& v : moved) v = Vec3(2.0 * v.y() + 10.0 * v.x() * v.x(), v.z(), -v.x()) + Vec3(100.0, 0.0, 0.0);
  ASSERT_TRUE(tree->refit(moved));
  mesh.vertices = moved;
  QueryPoints points(mesh);
  for (int i = 0; i < 100; ++i) {
    const Vec3 p = points.make(i);
    double best = 1e300;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) best = std::min(best, distance_squared(mesh, t, p));
    EXPECT_EQ(tree->find_nearest(p).distance_squared, best);
  }
  std::vector<Vec3> fewer(moved.begin(), moved.end() - 1);
  EXPECT_FALSE(tree->refit(fewer));
}

TYPED_TEST(FdhTreeOf, EmptyTreesAndNonFiniteQueriesFindNothing) {
  const auto empty = FdhTree<TypeParam::kCount>::build({}, {});
  ASSERT_TRUE(empty);
  EXPECT_FALSE(std::isfinite(empty->find_nearest(Vec3::Zero()).distance_squared));
  const TriangleMesh mesh = made::sphere(1.0, 8);
  const auto tree = FdhTree<TypeParam::kCount>::build(mesh.vertices, mesh.triangles);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  int visited = 0;
  const auto count = [&visited](std::uint32_t) { ++visited; };
  tree->for_each_overlapping(FdhBall{Vec3(nan, 0, 0), 1.0}, count);
  tree->for_each_overlapping(FdhBall{Vec3(0, 0, 0), nan}, count);
  tree->for_each_overlapping(FdhSweep{Vec3(0, 0, 0), Vec3(infinity, 0, 0), 0.0}, count);
  EXPECT_EQ(visited, 0);
  EXPECT_FALSE(std::isfinite(tree->find_nearest(Vec3(nan, nan, nan)).distance_squared));
}

TYPED_TEST(FdhTreeOf, QueriesWithoutBoundsFindEverythingOnce) {
  const TriangleMesh mesh = made::sphere(1.0, 8);
  const auto tree = FdhTree<TypeParam::kCount>::build(mesh.vertices, mesh.triangles);
  const auto expect_all = [&](const auto& query, const char* what) {
    std::multiset<std::uint32_t> visited;
    tree->for_each_overlapping(query, [&](std::uint32_t t) { visited.insert(t); });
    EXPECT_EQ(visited.size(), mesh.triangles.size()) << what;
    EXPECT_EQ(std::set<std::uint32_t>(visited.begin(), visited.end()).size(), mesh.triangles.size()) << what;
  };
  expect_all(FdhBall{Vec3(0, 0, 0), 1e200}, "ball");
  expect_all(FdhBall{Vec3(1e100, 0, 0), 1e150}, "far ball");
  expect_all(FdhSweep{Vec3(-1e30, 0, 0), Vec3(1e30, 0, 0), 1e31}, "sweep");
  EXPECT_TRUE(std::isfinite(tree->find_nearest(Vec3(1e100, 0, 0)).distance_squared));
}

// The sweeps go through the middle of the mesh; some of their ends are too large for a float, or their products for a double.
TYPED_TEST(FdhTreeOf, SweepsFromBeyondAFloatMissNothing) {
  const TriangleMesh mesh = made::sphere(1.0, 8);
  const auto tree = FdhTree<TypeParam::kCount>::build(mesh.vertices, mesh.triangles);
  ASSERT_TRUE(tree);
  for (const Vec3& direction : {Vec3(1.0, 0.1, 0.2), Vec3(-0.1, 0.3, 1.0)}) {
    Ids pierced;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const double d = segment_triangle_distance_squared<double>(of3(-2.0 * direction), of3(2.0 * direction), of3(mesh.corner(t, 0)),
                                                                 of3(mesh.corner(t, 1)), of3(mesh.corner(t, 2)));
      if (d == 0.0) pierced.insert(t);
    }
    ASSERT_GE(pierced.size(), 2U);
    for (const double far : {1e29, 1e37, 1e38, 1e39, 1e100, 1e160, 1e308}) {
      for (const double radius : {0.0, 0.01}) {
        Ids visited;
        tree->for_each_overlapping(FdhSweep{-far * direction, far * direction, radius},
                                   [&](std::uint32_t t) { EXPECT_TRUE(visited.insert(t).second) << far << ": visited twice"; });
        for (const std::uint32_t t : pierced) EXPECT_TRUE(visited.count(t)) << far << ", radius " << radius << ": misses " << t;
      }
    }
  }
}

TEST(FdhTree, RejectsWhatSinglePrecisionCannotHold) {
  const TriangleMesh huge = scaled_and_moved(made::sphere(1.0, 8), 1e20, Vec3::Zero());
  const auto tree = FdhTree<14>::build(huge.vertices, huge.triangles);
  ASSERT_FALSE(tree);
  EXPECT_NE(tree.error().what.find("metres"), std::string::npos);
}

TEST(FdhTree, MoreDirectionsOpenFewerLeaves) {
  const TriangleMesh mesh = made::sphere(0.05, 80, 0.1);
  const auto box = FdhTree<6>::build(mesh.vertices, mesh.triangles);
  const auto hull = FdhTree<26>::build(mesh.vertices, mesh.triangles);
  QueryPoints points(mesh);
  FdhVisits with_6;
  FdhVisits with_26;
  for (int i = 0; i < 400; ++i) {
    const Vec3 p = points.make(i);
    const FdhSweep sweep{p, p + 0.2 * points.size * points.direction(), 0.0};
    with_6 += box->for_each_overlapping(sweep, [](std::uint32_t) {});
    with_26 += hull->for_each_overlapping(sweep, [](std::uint32_t) {});
  }
  EXPECT_LT(with_26.leaves, with_6.leaves);
}

TEST(FdhTree, HullsOfALevelContainTheirTrianglesAndTogetherAll) {
  for (const NamedMesh& named : meshes()) {
    const auto tree = *FdhTree<14>::build(named.mesh.vertices, named.mesh.triangles);
    for (int level = 0; level <= tree.stats().depth; ++level) {
      std::vector<std::uint32_t> covered;
      tree.for_each_hull(level, [&](const FdhHull<14>& hull, std::span<const std::uint32_t> triangles) {
        covered.insert(covered.end(), triangles.begin(), triangles.end());
        for (const std::uint32_t t : triangles) {
          for (int k = 0; k < 3; ++k) {
            const auto along = fdh_project<14>(named.mesh.corner(t, k));
            for (std::size_t i = 0; i < along.size(); ++i) {
              ASSERT_GE(along[i], hull.low[i]) << named.name;
              ASSERT_LE(along[i], hull.high[i]) << named.name;
            }
          }
        }
      });
      EXPECT_EQ(covered.size(), named.mesh.triangles.size()) << named.name << ", level " << level;
      EXPECT_EQ(Ids(covered.begin(), covered.end()).size(), covered.size()) << named.name << ", level " << level;
    }
  }
}

}  // namespace
}  // namespace hapton
