#include "core/collision/fdh_scene.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <vector>

#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

struct Objects {
  std::vector<TriangleMesh> meshes;
  std::mt19937_64 random{61};
  std::uniform_real_distribution<double> unit{-1.0, 1.0};

  explicit Objects(int count) {
    for (int o = 0; o < count; ++o) {
      TriangleMesh mesh = o % 9 == 4 ? TriangleMesh() : made::sphere(0.02 + 0.001 * o, 6 + o % 5, 0.1);
      const Vec3 move = 0.5 * direction();
      for (Vec3& v : mesh.vertices) v += move;
      meshes.push_back(std::move(mesh));
    }
  }
  Vec3 direction() { return {unit(random), unit(random), unit(random)}; }
  template <int K>
  Result<FdhScene<K>> build() const {
    std::vector<typename FdhScene<K>::Object> views;
    for (const TriangleMesh& mesh : meshes) views.push_back({mesh.vertices, mesh.triangles});
    return FdhScene<K>::build(views);
  }
  double distance_squared(std::uint32_t o, std::uint32_t t, const Vec3& p) const {
    const TriangleMesh& mesh = meshes[o];
    return triangle_distance_squared(p, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
  }
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::uint32_t o = 0; o < meshes.size(); ++o) {
      for (std::uint32_t t = 0; t < meshes[o].triangles.size(); ++t) visit(o, t);
    }
  }
};

template <int K>
void expect_queries_as_brute_force(const Objects& objects, const FdhScene<K>& scene, Objects& directions) {
  for (int i = 0; i < 60; ++i) {
    const Vec3 p = 0.6 * directions.direction();
    const double radius = 0.02 * (i % 5);
    std::set<std::pair<std::uint32_t, std::uint32_t>> visited;
    scene.for_each_overlapping(FdhBall{p, radius}, [&](std::uint32_t o, std::uint32_t t) { visited.insert({o, t}); });
    FdhNear best = kNothingNear;
    objects.for_each([&](std::uint32_t o, std::uint32_t t) {
      const double d = objects.distance_squared(o, t, p);
      if (d < best.distance_squared) best = {d, t, o};
      if (std::sqrt(d) <= radius) {
        EXPECT_TRUE(visited.count({o, t}));
      }
      if (std::sqrt(d) > radius + 1e-12) {
        EXPECT_FALSE(visited.count({o, t}));
      }
    });
    FdhNearest nearest_one(1, std::numeric_limits<double>::infinity());
    scene.collect_nearest(p, p, nearest_one);
    const auto one = nearest_one.finish();
    ASSERT_EQ(one.size(), 1U);
    const FdhNear& found = one[0];
    EXPECT_EQ(found.distance_squared, best.distance_squared);
    EXPECT_EQ(found.object, best.object);
    EXPECT_EQ(found.triangle, best.triangle);

    FdhNearest nearest(64, std::numeric_limits<double>::infinity());
    scene.collect_nearest(p, p, nearest);
    visited.clear();
    for (const FdhNear& near : nearest.finish()) visited.insert({near.object, near.triangle});
    EXPECT_EQ(visited.size(), 64U);
    objects.for_each([&](std::uint32_t o, std::uint32_t t) {
      if (std::sqrt(objects.distance_squared(o, t, p)) < nearest.complete_radius()) {
        EXPECT_TRUE(visited.count({o, t}));
      }
    });

    const Vec3 q = 0.6 * directions.direction();
    visited.clear();
    scene.for_each_overlapping(FdhSweep{p, q, 0.003}, [&](std::uint32_t o, std::uint32_t t) { visited.insert({o, t}); });
    objects.for_each([&](std::uint32_t o, std::uint32_t t) {
      const TriangleMesh& mesh = objects.meshes[o];
      const double d =
          segment_triangle_distance_squared<double>(of3(p), of3(q), of3(mesh.corner(t, 0)), of3(mesh.corner(t, 1)), of3(mesh.corner(t, 2)));
      EXPECT_EQ(std::sqrt(d) <= 0.003, visited.count({o, t}) > 0);
    });
  }
}

template <int K>
void check_scene() {
  for (const int count : {1, 3, 40}) {
    Objects objects(count);
    auto scene = objects.build<K>();
    ASSERT_TRUE(scene) << scene.error().what;
    Objects directions(0);  // only a source of random directions
    expect_queries_as_brute_force<K>(objects, *scene, directions);
    std::vector<Vec3> moved = objects.meshes[0].vertices;
    for (Vec3& v : moved) v = 1.5 * v + Vec3(0.3, 0.4, -0.6);
    ASSERT_TRUE(scene->refit(0, moved));
    objects.meshes[0].vertices = moved;
    expect_queries_as_brute_force<K>(objects, *scene, directions);
    EXPECT_FALSE(scene->refit(static_cast<std::uint32_t>(count), moved));
  }
}

TEST(FdhScene, FindsWhatBruteForceFinds) {
  check_scene<6>();
  check_scene<14>();
  check_scene<18>();
  check_scene<26>();
}

TEST(FdhScene, WithoutObjectsFindsNothing) {
  const auto scene = FdhScene<14>::build({});
  ASSERT_TRUE(scene);
  FdhNearest nearest(1, std::numeric_limits<double>::infinity());
  scene->collect_nearest(Vec3::Zero(), Vec3::Zero(), nearest);
  EXPECT_TRUE(nearest.finish().empty());
  int visited = 0;
  scene->for_each_overlapping(FdhBall{Vec3::Zero(), 1.0}, [&](std::uint32_t, std::uint32_t) { ++visited; });
  EXPECT_EQ(visited, 0);
}

TEST(FdhScene, QueriesWithoutBoundsFindEverythingOnce) {
  Objects objects(12);
  const auto scene = objects.build<14>();
  std::size_t expected = 0;
  objects.for_each([&](std::uint32_t, std::uint32_t) { ++expected; });
  for (const double radius : {1e3, 1e30, 1e200}) {
    std::multiset<std::pair<std::uint32_t, std::uint32_t>> visited;
    scene->for_each_overlapping(FdhBall{Vec3(0, 0, 0), radius}, [&](std::uint32_t o, std::uint32_t t) { visited.insert({o, t}); });
    EXPECT_EQ(visited.size(), expected) << radius;
  }
}

// Each object is a single point, so that its own extent is small.
TEST(FdhScene, FindsObjectsFartherApartThanAFloatReaches) {
  std::vector<TriangleMesh> points;
  for (int o = 0; o < 12; ++o) points.push_back({{Vec3((o - 6) * 1e39, 1.0, 0.0)}, {{0, 0, 0}}});
  std::vector<FdhScene<14>::Object> objects;
  for (const TriangleMesh& point : points) objects.push_back({point.vertices, point.triangles});
  const auto scene = FdhScene<14>::build(objects);
  ASSERT_TRUE(scene) << scene.error().what;
  for (std::uint32_t o = 0; o < points.size(); ++o) {
    std::set<std::uint32_t> visited;
    scene->for_each_overlapping(FdhBall{points[o].vertices[0], 1.0}, [&](std::uint32_t object, std::uint32_t) { visited.insert(object); });
    EXPECT_TRUE(visited.count(o)) << o;
  }
}

TEST(FdhScene, NamesTheObjectItCannotHold) {
  TriangleMesh good = made::sphere(1.0, 8);
  TriangleMesh bad = made::sphere(1e20, 8);
  const std::vector<FdhScene<14>::Object> objects = {{good.vertices, good.triangles}, {bad.vertices, bad.triangles}};
  const auto scene = FdhScene<14>::build(objects);
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().what.find("object 1"), std::string::npos);
}

TEST(FdhScene, SkipsDistantObjects) {
  Objects objects(40);
  const auto scene = objects.build<14>();
  const FdhVisits far = scene->for_each_overlapping(FdhBall{Vec3(50, 0, 0), 0.1}, [](std::uint32_t, std::uint32_t) {});
  EXPECT_LE(far.nodes, 1U);
  EXPECT_EQ(far.items, 0U);
}

}  // namespace
}  // namespace hapton
