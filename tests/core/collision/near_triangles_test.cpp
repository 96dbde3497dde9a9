#include "core/collision/near_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

std::vector<std::uint32_t> all_triangles(const TouchGeometry& geometry) {
  std::vector<std::uint32_t> all;
  geometry.for_each_overlapping({Vec3::Constant(-10.0), Vec3::Constant(10.0)}, [&](std::uint32_t id) { all.push_back(id); });
  EXPECT_EQ(all.size(), geometry.triangle_count());
  return all;
}

// The distance along the segment is convex: ternary search finds its minimum.
double distance_to_segment(const ContactTriangle& shape, const Vec3& p, const Vec3& q) {
  const auto at = [&](double time) { return shape.separation(p + time * (q - p)).distance; };
  double low = 0.0;
  double high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double left = low + (high - low) / 3.0;
    const double right = high - (high - low) / 3.0;
    (at(left) < at(right) ? high : low) = at(left) < at(right) ? right : left;
  }
  return std::min({at(0.0), at(1.0), at(low)});
}

class NearTrianglesTest : public testing::TestWithParam<int> {
 protected:
  static std::vector<TriangleMesh> meshes(int which) {
    switch (which) {
      case 0:
        return {made::soup(71, 700, 0.3, 0.2)};
      case 1:
        return {made::sphere(0.4, 16, 0.1)};
      case 2:
        return {made::sheet(0.4, 0.0, 12)};
      default:
        return {made::sphere(0.3, 10, 0.1), made::box({0.1, -0.2, -0.2}, {0.5, 0.2, 0.2})};
    }
  }
};

TEST_P(NearTrianglesTest, NothingNearIsMissed) {
  const std::uint64_t seed = 100U + static_cast<std::uint64_t>(GetParam());
  RecordProperty("seed", std::to_string(seed));
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto draw_vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };

  const std::vector<TriangleMesh> objects = meshes(GetParam());
  std::vector<const TriangleMesh*> pointers;
  for (const TriangleMesh& mesh : objects) pointers.push_back(&mesh);
  const TouchGeometry geometry(pointers);
  const std::vector<std::uint32_t> all = all_triangles(geometry);
  const auto near = std::make_unique<NearTriangles>();
  std::size_t gathered = 0;
  std::size_t visited = 0;
  std::size_t offered = 0;
  for (int round = 0; round < 25; ++round) {
    // Some centres are at a corner of a triangle: the distance is zero there, and no direction gives a bound.
    Vec3 centre = 0.6 * draw_vector();
    if (round % 4 == 1) centre = geometry.corner(all[random() % all.size()], 0);
    if (round % 4 == 3) centre += 0.01 * draw_vector();
    const double within = 0.03 + 0.3 * std::fabs(unit(random));
    int queried = 0;
    ASSERT_TRUE(near->gather(geometry, centre, within, queried));
    std::set<std::uint32_t> ids;
    for (int slot = 0; slot < near->count(); ++slot) ids.insert(near->triangle(slot));
    ASSERT_EQ(ids.size(), static_cast<std::size_t>(near->count())) << "a triangle was gathered twice";
    EXPECT_GE(queried, near->count());
    gathered += ids.size();
    for (const std::uint32_t id : all) ASSERT_EQ(ids.count(id) != 0, geometry.separation(id, centre).distance <= within) << id;

    for (int i = 0; i < 3; ++i) {
      const double distance = 0.3 * within * std::fabs(unit(random));
      const Vec3 p = centre + (within - distance) * draw_vector() / 2.0;
      const Vec3 q = i == 0 ? p : Vec3(centre + (within - distance) * draw_vector() / 2.0);
      ASSERT_TRUE(near->covers(p, distance) && near->covers(q, distance));
      std::set<int> slots;
      near->visit_near(p, q, distance, [&](int slot) {
        ASSERT_TRUE(slot >= 0 && slot < near->count());
        ASSERT_TRUE(slots.insert(slot).second) << "a slot was visited twice";
      });
      visited += slots.size();
      offered += ids.size();
      for (int slot = 0; slot < near->count(); ++slot) {
        ASSERT_LE(near->distance_bound(slot, q), near->shape(slot).separation(q).distance) << near->triangle(slot);
        if (slots.count(slot) != 0) continue;
        ASSERT_GT(distance_to_segment(near->shape(slot), p, q), distance) << "round " << round << " triangle " << near->triangle(slot);
      }
    }
  }
  EXPECT_GT(gathered, 200U);
  EXPECT_LT(visited, offered / 2) << "the bounds exclude few triangles";
}

INSTANTIATE_TEST_SUITE_P(Meshes, NearTrianglesTest, testing::Range(0, 4));

// Close above a boundary edge, a nearest point on the face may count as one on the edge: the direction to it leans, more the closer it is.
TEST(NearTriangles, BoundsHoldFromCloseAboveABoundary) {
  constexpr std::uint64_t kSeed = 7;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto draw_vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  const auto near = std::make_unique<NearTriangles>();
  int nearest_on_edge = 0;
  for (int mesh_number = 0; mesh_number < 40; ++mesh_number) {
    TriangleMesh mesh;
    mesh.vertices = {draw_vector(), draw_vector(), draw_vector()};
    mesh.triangles = {{0, 1, 2}};
    const TouchGeometry geometry({&mesh});
    const ContactTriangle shape(geometry.corner(0, 0), geometry.corner(0, 1), geometry.corner(0, 2));
    for (int i = 0; i < 60; ++i) {
      const int k = i % 3;
      const double height = std::exp2(-29.0 + 6.0 * std::fabs(unit(random)));
      const Vec3 inward = shape.normal().cross(shape.edge(k)) / shape.length(k);
      const Vec3 centre = shape.corner(k) + (0.5 + 0.4 * unit(random)) * shape.edge(k) + height * shape.normal() +
                          std::exp2(-53.0 + unit(random)) * unit(random) * inward;
      int queried = 0;
      ASSERT_TRUE(near->gather(geometry, centre, 0.5, queried));
      nearest_on_edge += geometry.separation(0, centre).feature == Feature::edge ? 1 : 0;
      // At the same height farther inward, the bound must not exceed the true distance.
      const Vec3 p = centre + 0.2 * inward;
      ASSERT_LE(near->distance_bound(0, p), shape.separation(p).distance) << "height " << height;
      bool is_visited = false;
      near->visit_near(p, p, shape.separation(p).distance, [&](int) { is_visited = true; });
      ASSERT_TRUE(is_visited) << "height " << height;
    }
  }
  EXPECT_GT(nearest_on_edge, 100);
}

TEST(NearTriangles, TheInnerHalfOfTheBallIsCentral) {
  const TriangleMesh mesh = made::sheet(0.4, 0.0, 12);
  const TouchGeometry geometry({&mesh});
  const auto near = std::make_unique<NearTriangles>();
  int queried = 0;
  const Vec3 centre(0.1, -0.2, 0.05);
  EXPECT_FALSE(near->is_central(centre)) << "nothing is gathered";
  ASSERT_TRUE(near->gather(geometry, centre, 0.2, queried));
  EXPECT_TRUE(near->is_central(centre));
  EXPECT_TRUE(near->is_central(centre + Vec3(0.0, 0.099, 0.0)));
  EXPECT_FALSE(near->is_central(centre + Vec3(0.0, 0.101, 0.0)));
}

TEST(NearTriangles, TooManyTrianglesLeaveItEmpty) {
  const TriangleMesh mesh = made::sheet(0.5, 0.0, 80);
  const TouchGeometry geometry({&mesh});
  ASSERT_GT(geometry.triangle_count(), static_cast<std::size_t>(NearTriangles::kCapacity));
  const auto near = std::make_unique<NearTriangles>();
  int queried = 0;
  ASSERT_TRUE(near->gather(geometry, Vec3::Zero(), 0.05, queried));
  EXPECT_GT(near->count(), 0);
  EXPECT_FALSE(near->gather(geometry, Vec3::Zero(), 4.0, queried));
  EXPECT_EQ(near->count(), 0);
  EXPECT_FALSE(near->covers(Vec3::Zero(), 0.0));
  EXPECT_GT(queried, NearTriangles::kMaxOutsideFans);
  bool is_visited = false;
  near->visit_near(Vec3::Zero(), Vec3::Zero(), 4.0, [&](int) { is_visited = true; });
  EXPECT_FALSE(is_visited);
  ASSERT_TRUE(near->gather(geometry, Vec3::Zero(), 0.05, queried));
  EXPECT_TRUE(near->covers(Vec3(0.01, 0.0, 0.0), 0.04));
  EXPECT_FALSE(near->covers(Vec3(0.02, 0.0, 0.0), 0.04));
  near->clear();
  EXPECT_FALSE(near->covers(Vec3::Zero(), 0.0));
}

// All triangles of a large fan fit, but of other triangles no more than elsewhere. Shapes are right in any order of the slots, even where
// there are more slots than shapes that are kept prepared.
TEST(NearTriangles, AFanOfThousandsFits) {
  TriangleMesh mesh;
  mesh.vertices = {{0.0, 0.0, 0.0}};
  for (std::uint32_t i = 0; i < 5000; ++i) {
    mesh.vertices.emplace_back(0.5 * std::cos(0.001 * i), 0.5 * std::sin(0.001 * i), 0.05 * std::sin(0.01 * i));
    if (i > 0) mesh.triangles.push_back({0, i, i + 1});
  }
  const auto near = std::make_unique<NearTriangles>();
  int queried = 0;
  {
    const TouchGeometry geometry({&mesh});
    ASSERT_TRUE(near->gather(geometry, Vec3(0.0, 0.0, 0.1), 0.15, queried));
    EXPECT_EQ(near->count(), static_cast<int>(mesh.triangles.size()));
    std::mt19937_64 random(2403);
    for (int i = 0; i < 20000; ++i) {
      const int slot = static_cast<int>(random() % mesh.triangles.size());
      const ContactTriangle& shape = near->shape(slot);
      for (int k = 0; k < 3; ++k) ASSERT_EQ(shape.corner(k), geometry.corner(near->triangle(slot), k)) << "seed 2403";
    }
  }
  const TriangleMesh sheet = scaled_and_moved(made::sheet(0.5, 0.0, 40), 1.0, Vec3(0.0, 0.0, 0.2));
  const TriangleMesh both = joined(mesh, sheet);
  const TouchGeometry geometry({&both});
  EXPECT_FALSE(near->gather(geometry, Vec3(0.0, 0.0, 0.1), 2.0, queried)) << sheet.triangles.size() << " others";
}

// The share of the triangles that a smaller ball would hold. On an even sheet 10 mm below the centre, a ball of 11 mm holds half as many as
// one of 12 mm; at the tip of a fan it holds all of them.
TEST(NearTriangles, ItCountsTheShareWithinASmallerBall) {
  const auto share = [](const TriangleMesh& mesh, int most) {
    const TouchGeometry geometry({&mesh});
    NearTriangles near;
    int queried = 0;
    const bool fits = near.gather(geometry, geometry.to_local(Vec3(0.0, 0.0, 0.01)), 0.012 / geometry.unit_m(), queried, most);
    EXPECT_EQ(fits, most == NearTriangles::kCapacity);
    EXPECT_EQ(near.count() > 0, fits);
    return near.share_within(0.011 / geometry.unit_m());
  };
  TriangleMesh fan;
  fan.vertices = {{0.0, 0.0, 0.0}};
  for (std::uint32_t i = 0; i < 300; ++i) {
    fan.vertices.emplace_back(0.05 * std::cos(0.02 * i), 0.05 * std::sin(0.02 * i), 0.0);
    if (i > 0) fan.triangles.push_back({0, i, i + 1});
  }
  EXPECT_NEAR(share(made::sheet(0.05, 0.0, 140), NearTriangles::kCapacity), 0.5, 0.1);
  for (const int most : {100, NearTriangles::kCapacity}) EXPECT_EQ(share(fan, most), 1.0) << "even where there are too many to gather";
}

TEST(NearTriangles, ShapesAreThoseOfTheGeometryAndNothingAllocates) {
  const TriangleMesh mesh = made::sphere(0.4, 12, 0.1);
  const TouchGeometry geometry({&mesh});
  const auto near = std::make_unique<NearTriangles>();
  int queried = 0;
  const AllocationGuard guard;
  // Gathers at two places: shapes that were prepared for the first one must not be used for the second.
  for (const Vec3& centre : {Vec3(0.4, 0.0, 0.0), Vec3(0.0, 0.4, 0.0)}) {
    ASSERT_TRUE(near->gather(geometry, centre, 0.3, queried));
    ASSERT_GT(near->count(), 4);
    for (int slot = 0; slot < near->count(); ++slot) {
      for (int k = 0; k < 3; ++k) ASSERT_EQ(near->shape(slot).corner(k), geometry.corner(near->triangle(slot), k));
    }
  }
  EXPECT_TRUE(!AllocationGuard::is_available() || guard.count() == 0U);
}

}  // namespace
}  // namespace hapton
