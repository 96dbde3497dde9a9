#include "core/collision/touch_geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TEST(TouchGeometry, LocalCoordinatesDoNotDependOnScaleOrPlace) {
  const TriangleMesh mesh = make_icosphere(0.05, 2);
  const TouchGeometry geometry({&mesh});
  for (const double scale : {0x1p-20, 0x1p20}) {
    const TriangleMesh scaled = scaled_and_moved(mesh, scale, Vec3::Zero());
    const TouchGeometry scaled_geometry({&scaled});
    EXPECT_EQ(scaled_geometry.unit_m(), geometry.unit_m() * scale);
    for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) {
      for (int k = 0; k < 3; ++k) EXPECT_EQ(scaled_geometry.corner(t, k), geometry.corner(t, k));
    }
  }
  const TriangleMesh far = scaled_and_moved(mesh, 1.0, Vec3(1e6, -1e6, 1e6));
  const TouchGeometry far_geometry({&far});
  EXPECT_LE((far_geometry.origin() - Vec3(1e6, -1e6, 1e6)).norm(), 1e-9);
}

std::vector<std::shared_ptr<const TriangleMesh>> one_mesh(TriangleMesh mesh) {
  return {std::make_shared<const TriangleMesh>(std::move(mesh))};
}

// A geometry of a part of a scene, built with the box of the scene, has the frame of the whole scene.
TEST(TouchGeometry, PartsOfASceneHaveItsFrame) {
  const TriangleMesh all = make_box({0.2, 0.1, 0.1});
  const TouchGeometry whole({&all});
  Box box;
  for (const Vec3& v : all.vertices) box.grow(v);
  for (const double x : {-0.08, 0.03}) {
    const auto part = one_mesh(scaled_and_moved(make_box({0.01, 0.02, 0.01}), 1.0, Vec3(x, 0.01, 0)));
    ASSERT_TRUE(TouchGeometry::check(part, box));
    const TouchGeometry geometry(part, BuildPolicy::at_once, std::nullopt, box);
    EXPECT_EQ(geometry.origin(), whole.origin());
    EXPECT_EQ(geometry.unit_m(), whole.unit_m());
    EXPECT_LT(TouchGeometry(part).unit_m(), whole.unit_m());
  }
}

TEST(TouchGeometry, APartLiesWithinTheScene) {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto part = one_mesh(make_box({0.02, 0.02, 0.02}));
  EXPECT_TRUE(TouchGeometry::check(part, Box()));
  EXPECT_FALSE(TouchGeometry::check(one_mesh({.vertices = {Vec3::Constant(infinity)}, .triangles = {{0, 0, 0}}}), Box()));
  EXPECT_TRUE(TouchGeometry::check(part, {Vec3::Constant(-0.01), Vec3::Constant(0.01)}));
  EXPECT_FALSE(TouchGeometry::check(part, {Vec3::Constant(-0.01), Vec3(0.01, 0.01, 0.00999)}));
  EXPECT_FALSE(TouchGeometry::check(part, {Vec3::Constant(-infinity), Vec3::Constant(infinity)}));
  EXPECT_FALSE(TouchGeometry::check(part, {Vec3::Constant(-1e308), Vec3::Constant(1e308)})) << "its diagonal is not finite";
  EXPECT_FALSE(TouchGeometry::check(one_mesh({.vertices = {Vec3::Constant(std::nan(""))}, .triangles = {{0, 0, 0}}}),
                                    {Vec3::Constant(-0.01), Vec3::Constant(0.01)}));
}

TEST(TouchGeometry, EdgesAreExact) {
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.1, 2000, 11);
  const TouchGeometry geometry({&mesh});
  for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Vec3& a = geometry.corner(t, k);
      const Vec3& b = geometry.corner(t, (k + 1) % 3);
      const Vec3 edge = b - a;
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(static_cast<long double>(b[axis]) - static_cast<long double>(a[axis]), static_cast<long double>(edge[axis]));
      }
    }
  }
}

TEST(TouchGeometry, KeepsEveryTriangleAndItsObject) {
  const TriangleMesh ball = make_icosphere(0.05, 2);
  const TriangleMesh box = scaled_and_moved(make_box({0.02, 0.02, 0.02}), 1.0, Vec3(0.2, 0, 0));
  const TouchGeometry geometry(std::vector<const TriangleMesh*>{&ball, &box});
  ASSERT_EQ(geometry.triangle_count(), ball.triangles.size() + box.triangles.size());
  std::size_t box_triangles = 0;
  geometry.for_each_overlapping(Box{Vec3::Constant(-2), Vec3::Constant(2)}, [&](std::uint32_t id) {
    const bool is_of_box = geometry.to_scene(geometry.corner(id, 0)).x() > 0.1;
    EXPECT_EQ(geometry.mesh_of(id), is_of_box ? 1U : 0U);
    box_triangles += is_of_box ? 1 : 0;
  });
  EXPECT_EQ(box_triangles, box.triangles.size());
  EXPECT_GT(geometry.bytes(), geometry.triangle_count() * 20);
}

TEST(TouchGeometry, MadeOfSharedObjectsItFindsTheSameAsOneThatBuildsThem) {
  const std::vector<std::shared_ptr<const TriangleMesh>> meshes = {
      std::make_shared<TriangleMesh>(make_bumpy_sphere(0.3, 0.2, 300, 3)), std::make_shared<TriangleMesh>(),
      std::make_shared<TriangleMesh>(scaled_and_moved(make_bumpy_sphere(0.2, 0.1, 80, 4), 1.0, {0.5, 0.1, 0.0}))};
  const TouchGeometry built(meshes);
  std::vector<std::shared_ptr<const ObjectGeometry>> objects;
  for (const auto& mesh : meshes) {
    objects.push_back(
        std::make_shared<const ObjectGeometry>(ObjectGeometry::make(*mesh, built.frame(), TouchGeometry::most_triangles(meshes))));
  }
  const TouchGeometry shared(objects, built.frame());
  EXPECT_EQ(shared.object_count(), 3U);
  EXPECT_EQ(shared.waiting_count(), 0U);
  EXPECT_EQ(shared.triangle_count(), built.triangle_count());
  EXPECT_EQ(&shared.object_geometry(2), objects[2].get());
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-0.6, 0.6);
  using Found = std::set<std::pair<std::uint32_t, std::uint32_t>>;
  const auto triangles_near = [](const TouchGeometry& scene, const Box& box) {
    Found found;
    scene.for_each_overlapping(box, [&](std::uint32_t id) { found.insert({scene.mesh_of(id), scene.triangle_of(id)}); });
    return found;
  };
  std::set<std::uint32_t> meshes_found;
  for (int n = 0; n < 200; ++n) {
    const Vec3 p(uniform(random), uniform(random), uniform(random));
    const Box box = Box{p, p}.inflated(0.05);
    const Found found = triangles_near(shared, box);
    ASSERT_EQ(found, triangles_near(built, box));
    for (const auto& [mesh, triangle] : found) meshes_found.insert(mesh);
  }
  EXPECT_EQ(meshes_found, (std::set<std::uint32_t>{0, 2}));
}

// bytes() counts the hierarchies before anything is built, and afterwards also what was built.
TEST(TouchGeometry, CountsTheBytesOfBothHierarchiesAndOfWhatIsBuilt) {
  const auto near = std::make_shared<TriangleMesh>(make_icosphere(0.05, 2));
  const auto far = std::make_shared<TriangleMesh>(scaled_and_moved(make_icosphere(0.05, 2), 1.0, Vec3(3, 0, 0)));
  TouchGeometry geometry({near, far}, BuildPolicy::on_approach);
  const std::size_t hierarchy_bytes = geometry.bytes();
  EXPECT_GE(hierarchy_bytes, 2 * 2 * sizeof(Box));
  EXPECT_LT(hierarchy_bytes, near->triangles.size() * 20);
  geometry.request_ahead(geometry.to_local({0, 0.1, 0}), 0.0);
  ASSERT_TRUE(geometry.build_requested());
  EXPECT_GT(geometry.bytes(), hierarchy_bytes + near->triangles.size() * 20);
  EXPECT_LT(geometry.bytes(), TouchGeometry(std::vector<const TriangleMesh*>{near.get(), far.get()}).bytes());
}

TEST(TouchGeometry, MayHaveLargeFansWhereAnObjectHasOneOrIsNotBuiltYet) {
  const auto few_sided = std::make_shared<TriangleMesh>(make_cylinder(0.05, 0.02, 12));
  const auto many_sided = std::make_shared<TriangleMesh>(make_cylinder(0.05, 0.02, SurfaceAdjacency::kLargeFan + 6));
  EXPECT_FALSE(TouchGeometry({few_sided}).may_have_large_fans());
  EXPECT_TRUE(TouchGeometry({few_sided, many_sided}).may_have_large_fans());
  EXPECT_TRUE(TouchGeometry({many_sided, few_sided}).may_have_large_fans());
  TouchGeometry geometry({few_sided}, BuildPolicy::on_approach);
  EXPECT_TRUE(geometry.may_have_large_fans());
  geometry.request_ahead(geometry.to_local({0, 0.06, 0}), 0.0);
  ASSERT_TRUE(geometry.build_requested());
  EXPECT_FALSE(geometry.may_have_large_fans());
}

TEST(TouchGeometry, ToLocalAndBackIsTheSamePoint) {
  const TriangleMesh mesh = make_icosphere(0.05, 1);
  const TouchGeometry geometry({&mesh});
  const Vec3 p(0.013, -0.4, 0.02);
  EXPECT_LE((geometry.to_scene(geometry.to_local(p)) - p).norm(), 1e-16);
}

TEST(TouchGeometry, BuildsOnApproachAndActivatesNoObjectAroundTheProbe) {
  const auto near = std::make_shared<TriangleMesh>(make_icosphere(0.05, 2));
  const auto far = std::make_shared<TriangleMesh>(scaled_and_moved(make_icosphere(0.05, 2), 1.0, Vec3(3, 0, 0)));
  TouchGeometry geometry({near, far}, BuildPolicy::on_approach);
  const auto active_triangles = [&] {
    int count = 0;
    geometry.for_each_overlapping(Box{Vec3::Constant(-9), Vec3::Constant(9)}, [&](std::uint32_t) { ++count; });
    return count;
  };
  EXPECT_EQ(geometry.built_count(), 0U);
  EXPECT_FALSE(geometry.build_requested()) << "nothing was requested";
  EXPECT_GT(geometry.request_ahead(geometry.to_local({0, 1.5, 0}), 0.0), 0.0);
  EXPECT_FALSE(geometry.build_requested());
  EXPECT_EQ(geometry.request_ahead(geometry.to_local({0, 0.1, 0}), 0.0), 0.0);
  EXPECT_EQ(active_triangles(), 0);
  EXPECT_TRUE(geometry.build_requested());
  EXPECT_FALSE(geometry.build_requested()) << "the far one was built, too";
  EXPECT_EQ(geometry.request_ahead(geometry.to_local({0, 0, 0}), 0.0), 0.0);
  EXPECT_EQ(active_triangles(), 0) << "it became active around the probe";
  EXPECT_GT(geometry.request_ahead(geometry.to_local({0, 0.1, 0}), 0.0), 0.0);
  EXPECT_EQ(active_triangles(), static_cast<int>(near->triangles.size()));
  EXPECT_EQ(geometry.built_count(), 1U);
}

// 125 icospheres of this level, side by side, some of them touching. Each has 20 triangles at level 0, 80 at level 1.
std::vector<std::shared_ptr<const TriangleMesh>> many_balls(int level) {
  std::vector<std::shared_ptr<const TriangleMesh>> meshes;
  const TriangleMesh ball = make_icosphere(0.05, level);
  for (int i = 0; i < 125; ++i) {
    const Vec3 place(0.11 * (i % 5), 0.1 * (i / 5 % 5), 0.13 * (i / 25));
    meshes.push_back(std::make_shared<TriangleMesh>(scaled_and_moved(ball, 1.0, place)));
  }
  return meshes;
}

TEST(TouchGeometry, QueriesOverManyObjectsAgreeWithBruteForce) {
  constexpr unsigned kSeed = 21;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const TouchGeometry geometry(many_balls(1));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  const auto for_each_triangle = [&](auto&& visit) {
    const auto bits = static_cast<std::uint32_t>(std::countr_zero(geometry.object_bits()));
    for (std::uint32_t o = 0; o < 125; ++o) {
      for (std::uint32_t t = 0; t < 80; ++t) visit(o << bits | t);
    }
  };
  for (int q = 0; q < 200; ++q) {
    const Vec3 p(place(random), place(random), place(random));
    const Box query{p.array() - 0.08, p.array() + 0.08};
    std::vector<std::uint32_t> found;
    geometry.for_each_overlapping(query, [&](std::uint32_t id) { found.push_back(id); });
    std::sort(found.begin(), found.end());
    ASSERT_EQ(std::adjacent_find(found.begin(), found.end()), found.end());
    double expected_distance = std::numeric_limits<double>::infinity();
    for_each_triangle([&](std::uint32_t id) {
      Box box = Box::around(geometry.corner(id, 0), geometry.corner(id, 1));
      box.grow(geometry.corner(id, 2));
      if (box.overlaps(query)) {
        EXPECT_TRUE(std::binary_search(found.begin(), found.end(), id));
      }
      expected_distance = std::min(expected_distance, geometry.separation(id, p).distance);
    });
    double best_squared = std::numeric_limits<double>::infinity();
    geometry.visit_nearest(p, best_squared, [&](std::uint32_t id, double bound) {
      const double d = geometry.separation(id, p).distance;
      return best_squared = std::min(bound, d * d);
    });
    EXPECT_DOUBLE_EQ(std::sqrt(best_squared), expected_distance);
  }
}

TEST(TouchGeometry, ANearestSearchOneTriangleAtATimeFindsTheSame) {
  constexpr unsigned kSeed = 222;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const TouchGeometry geometry(many_balls(1));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  TouchGeometry::NearestSearch search;
  std::size_t most_found = 0;
  for (int q = 0; q < 200; ++q) {
    const Vec3 p(place(random), place(random), place(random));
    std::vector<std::uint32_t> expected;
    geometry.visit_nearest(p, 0.04, [&](std::uint32_t id, double bound) {
      expected.push_back(id);
      return bound;
    });
    std::vector<std::uint32_t> found;
    search.start(p);
    while (const auto id = search.next(geometry, 0.04)) found.push_back(*id);
    ASSERT_EQ(found, expected);
    most_found = std::max(most_found, found.size());
  }
  EXPECT_GT(most_found, 100U);
}

TEST(TouchGeometry, AVisitEndsTheSearchOverAllObjects) {
  const TouchGeometry geometry(many_balls(0));
  int visits = 0;
  geometry.for_each_overlapping(Box{Vec3::Constant(-2), Vec3::Constant(2)}, [&](std::uint32_t) { return ++visits < 25; });
  EXPECT_EQ(visits, 25) << "an object has 20 triangles: the search went on in others";
}

// A loop applies the rule to each object: which ones must be requested at p, and how far p may move before the next one must be.
TEST(TouchGeometry, LookAheadRequestsWhatALoopOverAllObjectsWould) {
  constexpr unsigned kSeed = 5;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const auto meshes = many_balls(0);
  TouchGeometry geometry(meshes, BuildPolicy::on_approach);
  std::vector<Box> bounds(meshes.size());
  for (std::size_t o = 0; o < meshes.size(); ++o) {
    for (const Vec3& v : meshes[o]->vertices) bounds[o].grow(geometry.to_local(v));
  }
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::vector<bool> requested(meshes.size(), false);
  Vec3 p(-1.5, -1.5, -1.5);
  Vec3 velocity = Vec3::Zero();
  // Position, range and result of the loop where the distance was last used up. From there on, what remains is that distance less the
  // motion.
  Vec3 searched_from = Vec3::Zero();
  double searched_range = 0.0;
  double searched_distance = 0.0;
  std::size_t free_steps = 0;
  for (int step = 0; step < 4000; ++step) {
    velocity = 0.98 * velocity + 0.0005 * Vec3(normal(random), normal(random), normal(random)) - 0.0001 * p;
    p += velocity;
    const double range = 20.0 * velocity.norm();
    const double free_distance = geometry.request_ahead(p, range);
    double expected_distance = std::numeric_limits<double>::infinity();
    for (std::size_t o = 0; o < bounds.size(); ++o) {
      const double distance_to_request = std::sqrt(bounds[o].distance_squared(p)) - std::max(range, bounds[o].diagonal());
      if (distance_to_request <= -1e-12) requested[o] = true;
      if (!requested[o]) expected_distance = std::min(expected_distance, std::max(0.0, distance_to_request));
    }
    EXPECT_LE(free_distance, expected_distance + 1e-12) << "step " << step;
    double moved = (p - searched_from).norm() + std::max(0.0, range - searched_range);
    if (!(moved < searched_distance)) {
      searched_from = p;
      searched_range = range;
      searched_distance = expected_distance;
      moved = 0.0;
    }
    const auto requested_count = static_cast<std::size_t>(std::count(requested.begin(), requested.end(), true));
    const bool is_any_pending = requested_count + geometry.waiting_count() > meshes.size();  // requested, but not active yet
    if (is_any_pending) {
      EXPECT_EQ(free_distance, 0.0) << "step " << step;
    } else {
      EXPECT_GE(free_distance, searched_distance - moved - 1e-12) << "step " << step;
      ++free_steps;
    }
    while (geometry.build_requested()) {
    }
    ASSERT_EQ(geometry.built_count(), static_cast<std::size_t>(std::count(requested.begin(), requested.end(), true))) << "step " << step;
    if (geometry.waiting_count() == 0) break;
  }
  EXPECT_GT(geometry.built_count(), 100U) << "the motion came near too few objects for this test";
  EXPECT_GE(free_steps, 20U);
}

TEST(TouchGeometry, AnObjectWithoutTrianglesIsNotWaitedFor) {
  const auto ball = std::make_shared<TriangleMesh>(make_icosphere(0.05, 1));
  TouchGeometry geometry({std::make_shared<TriangleMesh>(), ball}, BuildPolicy::on_approach);
  EXPECT_EQ(geometry.waiting_count(), 1U);
  geometry.request_ahead(geometry.to_local({0, 0.1, 0}), 0.0);
  EXPECT_TRUE(geometry.build_requested());
  EXPECT_EQ(geometry.request_ahead(geometry.to_local({0, 0.1, 0}), 0.0), std::numeric_limits<double>::infinity());
  const TouchGeometry at_once({std::make_shared<TriangleMesh>(), ball});
  EXPECT_EQ(at_once.triangle_count(), ball->triangles.size());
}

TEST(TouchGeometry, RejectsMoreTrianglesThanIds) {
  auto large = std::make_shared<TriangleMesh>();
  large->vertices.assign(3, Vec3::Zero());
  large->triangles.assign(1U << 20U, Triangle{0, 1, 2});
  // 2048 objects of 2^20 triangles use all 2^31 ids.
  std::vector<std::shared_ptr<const TriangleMesh>> meshes(2048, large);
  EXPECT_TRUE(TouchGeometry::check(meshes));
  meshes.push_back(large);
  const auto checked = TouchGeometry::check(meshes);
  ASSERT_FALSE(checked);
  EXPECT_NE(checked.error().what.find("2049 objects"), std::string::npos) << checked.error().what;
}

struct FirstHit {
  double time = 2.0;  // 0 to 1 along the segment; above 1: no hit
  bool from_back = false;
};

FirstHit find_first_hit(const TouchGeometry& geometry, const Vec3& p, const Vec3& q) {
  FirstHit first;
  geometry.visit_along(p, q, 0.0, [&](std::uint32_t id, double until) {
    const TouchGeometry::Hit hit = geometry.pierce(id, p, q);
    if (!(hit.time < first.time)) return until;
    first = {hit.time, hit.from_back};
    return hit.time;
  });
  return first;
}

TEST(TouchGeometry, ASegmentMeetsFirstWhatABruteForceSearchFinds) {
  const TriangleMesh ball = make_icosphere(0.05, 3);
  const TriangleMesh other = scaled_and_moved(make_bumpy_sphere(0.05, 0.2, 3000, 5), 1.0, Vec3(0.06, 0.01, 0.0));
  const TouchGeometry geometry(std::vector<const TriangleMesh*>{&ball, &other});
  std::vector<std::uint32_t> ids;
  geometry.for_each_overlapping(Box{Vec3::Constant(-4.0), Vec3::Constant(4.0)}, [&](std::uint32_t id) { ids.push_back(id); });
  ASSERT_EQ(ids.size(), ball.triangles.size() + other.triangles.size());
  std::mt19937_64 random(31);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  int hits = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 p(place(random), place(random), place(random));
    const Vec3 aim = geometry.corner(ids[random() % ids.size()], 0);
    const Vec3 q = aim + 0.2 * (aim - p) + std::pow(10.0, -(i % 4)) * 0.1 * Vec3(place(random), place(random), place(random));
    FirstHit expected;
    for (const std::uint32_t id : ids) {
      const TouchGeometry::Hit hit = geometry.pierce(id, p, q);
      if (hit.time < expected.time) expected = {hit.time, hit.from_back};
    }
    const FirstHit found = find_first_hit(geometry, p, q);
    EXPECT_EQ(found.time, expected.time) << i;
    if (expected.time > 1.0) continue;
    EXPECT_EQ(found.from_back, expected.from_back) << i;
    ++hits;
  }
  EXPECT_GT(hits, 50);
}

// The path goes from vertex to vertex, along edges and in the planes of faces. If it is closed, it enters as often as it leaves.
TEST(TouchGeometry, AClosedPathOnALatticeEntersAClosedSurfaceAsOftenAsItLeavesIt) {
  const TriangleMesh box = make_box(Vec3::Constant(0.5), 2);
  const TouchGeometry geometry({&box});
  std::vector<std::uint32_t> ids;
  geometry.for_each_overlapping(Box{Vec3::Constant(-4.0), Vec3::Constant(4.0)}, [&](std::uint32_t id) { ids.push_back(id); });
  const double spacing = 0.125 / geometry.unit_m();
  std::mt19937_64 random(32);
  const auto draw = [&] {
    const auto step = [&] { return static_cast<double>(static_cast<int>(random() % 7) - 3) * spacing; };
    const double x = step();
    const double y = step();
    return Vec3(x, y, step());
  };
  int total_entries = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 start = draw();
    Vec3 from = start;
    int entries = 0;
    int exits = 0;
    for (int leg = 0; leg < 5; ++leg) {
      const Vec3 to = leg < 4 ? draw() : start;
      for (const std::uint32_t id : ids) {
        const TouchGeometry::Hit hit = geometry.pierce(id, from, to);
        if (hit.time <= 1.0) ++(hit.from_back ? exits : entries);
      }
      from = to;
    }
    ASSERT_EQ(entries, exits) << "path " << i;
    total_entries += entries;
  }
  EXPECT_GT(total_entries, 1000);
}

}  // namespace
}  // namespace hapton
