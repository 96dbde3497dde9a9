#include "core/force/sphere/gathered_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr std::uint64_t kSeedOfBalls = 2414;
constexpr Clearance kClearanceOfBalls{0.01, 0x1p-40, 0x1p-46};

class GatheredTrianglesOf : public testing::Test {
 protected:
  GatheredTrianglesOf() { RecordProperty("seed", std::to_string(kSeedOfBalls)); }
  Vec3 random_unit_vector() {
    const double x = unit_(random_);
    const double y = unit_(random_);
    return Vec3(x, y, unit_(random_)).normalized();
  }
  double least_distance(const Vec3& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t t = 0; t < count(); ++t) least = std::min(least, geometry.separation(t, p).distance);
    return least;
  }
  std::uint32_t count() const { return static_cast<std::uint32_t>(geometry.triangle_count()); }

  TriangleMesh mesh = made::sphere(0.4, 40, 0.05);
  TouchGeometry geometry{{&mesh}};
  std::vector<Material> materials{Material{}};
  std::unique_ptr<GatheredTriangles> near = std::make_unique<GatheredTriangles>(geometry, materials, kClearanceOfBalls, 1e-4);
  std::mt19937_64 random_{kSeedOfBalls};
  std::uniform_real_distribution<double> unit_{-1.0, 1.0};
};

TEST_F(GatheredTrianglesOf, HoldsAllThatBruteForceFindsAndASensibleNumber) {
  int small_sets = 0;
  for (int i = 0; i < 60; ++i) {
    const Vec3 c = geometry.to_local(0.42 * random_unit_vector());
    int work = 0;
    const Vec3 towards = 0.02 * random_unit_vector();
    ASSERT_TRUE(near->gather(c, towards, work));
    EXPECT_GE(work, near->count());
    ASSERT_TRUE(near->covers(c, kClearanceOfBalls.offset));
    const double covered_radius = near->covered_radius_at(c);
    std::vector<std::uint32_t> visited;
    near->visit_near(c, c, covered_radius, [&](int slot) { visited.push_back(near->triangle(slot)); });
    for (std::uint32_t t = 0; t < count(); ++t) {
      if (geometry.separation(t, c).distance > covered_radius) continue;
      EXPECT_TRUE(std::count(visited.begin(), visited.end(), t) == 1) << i;
    }
    small_sets += near->count() <= 300 ? 1 : 0;
  }
  EXPECT_GT(small_sets, 50) << "the radius adapts itself";
  EXPECT_GE(near->gathered(), 60U);
}

TEST_F(GatheredTrianglesOf, IsClearWhereBruteForceIs) {
  int clear_centres = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 c = geometry.to_local((0.41 + 0.02 * unit_(random_)) * random_unit_vector());
    int work = 0;
    const bool is_clear = near->is_clear_here(c, 0.0, work);
    EXPECT_EQ(is_clear, least_distance(c) >= kClearanceOfBalls.offset) << i;
    clear_centres += is_clear ? 1 : 0;
  }
  EXPECT_GT(clear_centres, 20);
  EXPECT_LT(clear_centres, 180);
}

TEST_F(GatheredTrianglesOf, CoversAPathOrItsBeginning) {
  int whole_paths = 0;
  for (int i = 0; i < 100; ++i) {
    const Vec3 c = geometry.to_local(0.42 * random_unit_vector());
    const CentrePath path = CentrePath::straight(c, c + (i % 2 == 0 ? 0.01 : 1.0) * random_unit_vector());
    double until = 1.0;
    int work = 0;
    ASSERT_TRUE(near->cover(path, until, work));
    ASSERT_GT(until, 0.0);
    EXPECT_TRUE(near->covers(path.at(until), kClearanceOfBalls.offset));
    whole_paths += until >= 1.0 ? 1 : 0;
  }
  EXPECT_GT(whole_paths, 40) << "of 50 that are short";
}

TEST_F(GatheredTrianglesOf, AOneSidedTriangleCanBeTouchedFromItsFrontOnly) {
  const ObjectGeometry::Corners corners = geometry.corners(7);
  const ContactTriangle shape(corners.a, corners.b, corners.c);
  const Vec3 front = corners.a + 0.1 * shape.normal();
  const Vec3 behind = corners.a - 0.1 * shape.normal();
  EXPECT_TRUE(near->can_touch(7, shape, front));
  EXPECT_TRUE(near->can_touch(7, shape, behind));
  materials[0].two_sided = false;
  EXPECT_TRUE(near->can_touch(7, shape, front));
  EXPECT_FALSE(near->can_touch(7, shape, behind));
}

TEST_F(GatheredTrianglesOf, WhereThereAreTooManyItIsNotTriedAgainAtTheSamePlace) {
  const TriangleMesh many = made::soup(3, 9000, 1e-4, 1e-4);
  const TouchGeometry crowded({&many});
  const auto gathered = std::make_unique<GatheredTriangles>(crowded, materials, Clearance{2.0, 0x1p-40, 0x1p-46}, 1.0);
  int work = 0;
  EXPECT_FALSE(gathered->gather(Vec3::Zero(), Vec3::Zero(), work));
  EXPECT_GT(work, 0);
  work = 0;
  EXPECT_FALSE(gathered->gather(Vec3(0.01, 0.0, 0.0), Vec3::Zero(), work));
  EXPECT_EQ(work, 0);
  gathered->clear();
  EXPECT_FALSE(gathered->gather(Vec3::Zero(), Vec3::Zero(), work));
  EXPECT_GT(work, 0);
}

}  // namespace
}  // namespace hapton
