#include "core/collision/neighbourhood.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "core/collision/swept_sphere.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

// Every triangle that really blocks a motion must be listed, and not as met later than it is.
TEST(Neighbourhood, NeverDropsATriangleThatBlocks) {
  constexpr unsigned kSeed = 2027;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.1, 20000, 3);
  const TouchGeometry geometry({&mesh});
  Neighbourhood near;
  std::array<Neighbourhood::Meeting, Neighbourhood::kCapacity> meetings;
  std::size_t blocking = 0;
  std::size_t listed = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto triangle = static_cast<std::uint32_t>(random() % geometry.triangle_count());
    const double hover = 0x1p-30;
    const double rest = (i % 3) * 0.004 + hover;
    const Clearance clearance{.rest = rest, .slack = 0.5 * hover, .tolerance = 0x1p-10 * hover};
    const Vec3 centroid = (geometry.corner(triangle, 0) + geometry.corner(triangle, 1) + geometry.corner(triangle, 2)) / 3.0;
    const Vec3 start = centroid + 0.01 * Vec3(unit(random), unit(random), unit(random));
    const Vec3 motion = 0.008 * Vec3(unit(random), unit(random), unit(random));
    const Box way = Box::around(start, start + motion).inflated(rest);
    if (!near.fill(geometry, way.inflated(0.001))) continue;
    ASSERT_TRUE(near.covers(way));
    const int count = near.find_meetings(start, motion, rest, way, meetings);
    listed += static_cast<std::size_t>(count);
    for (int m = 1; m < count; ++m) EXPECT_LE(meetings[0].earliest, meetings[m].earliest);
    for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) {
      if (geometry.separation(t, start).distance <= rest) continue;
      const double time = time_to_block(TriangleView{geometry, t}, start, motion, 1.0, clearance);
      if (time > 1.0) continue;
      ++blocking;
      const auto at = std::find_if(meetings.begin(), meetings.begin() + count, [&](const auto& meeting) { return meeting.triangle == t; });
      ASSERT_NE(at, meetings.begin() + count) << "case " << i << ": triangle " << t << " blocks at " << time << " and was not listed";
      EXPECT_LE(static_cast<double>(at->earliest), time);
      EXPECT_EQ(near.shape(at->place).corner(0), geometry.corner(t, 0));
    }
    if (i > 300) break;  // brute force over all triangles is slow; 300 cases meet thousands of blockers
  }
  EXPECT_GT(blocking, 200U);
  EXPECT_LT(listed, 40 * blocking) << "the filter lets nearly everything through";
}

TEST(Neighbourhood, HoldsExactlyWhatOverlapsItsRegion) {
  const TriangleMesh mesh = make_icosphere(0.05, 4);
  const TouchGeometry geometry({&mesh});
  Neighbourhood near;
  const Vec3 top = geometry.to_local({0, 0, 0.05});
  ASSERT_TRUE(near.fill(geometry, Box{top.array() - 0.05, top.array() + 0.05}));
  std::size_t expected = 0;
  geometry.for_each_overlapping(Box{top.array() - 0.05, top.array() + 0.05}, [&](std::uint32_t) { ++expected; });
  EXPECT_EQ(static_cast<std::size_t>(near.count()), expected);
  EXPECT_GT(expected, 4U);
}

TEST(Neighbourhood, SaysWhenThereIsTooMuch) {
  const TriangleMesh mesh = make_icosphere(0.05, 4);
  const TouchGeometry geometry({&mesh});
  Neighbourhood near;
  EXPECT_FALSE(near.fill(geometry, Box{Vec3::Constant(-2), Vec3::Constant(2)}));
  EXPECT_EQ(near.count(), 0);
  EXPECT_FALSE(near.covers(Box::around(Vec3::Zero(), Vec3::Zero())));
}

TEST(Neighbourhood, TimeInsideEndsAtTheRegionsWall) {
  const TriangleMesh mesh = make_icosphere(0.05, 1);
  const TouchGeometry geometry({&mesh});
  Neighbourhood near;
  ASSERT_TRUE(near.fill(geometry, Box{Vec3::Constant(-0.25), Vec3::Constant(0.25)}));
  EXPECT_DOUBLE_EQ(near.time_inside(Vec3::Zero(), Vec3(0.5, 0, 0), 0.05), 0.4);
  EXPECT_EQ(near.time_inside(Vec3(0.24, 0, 0), Vec3(0.5, 0, 0), 0.05), 0.0);
}

TEST(Neighbourhood, TakesNothingFromTheHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "allocations cannot be counted in this build";
  const TriangleMesh mesh = make_icosphere(0.05, 4);
  const TouchGeometry geometry({&mesh});
  Neighbourhood near;
  std::array<Neighbourhood::Meeting, Neighbourhood::kCapacity> meetings;
  const Vec3 top = geometry.to_local({0, 0, 0.05});
  const AllocationGuard guard;
  ASSERT_TRUE(near.fill(geometry, Box{top.array() - 0.05, top.array() + 0.05}));
  near.find_meetings(top, Vec3(0.01, 0, -0.01), 1e-9, Box::around(top, top + Vec3(0.01, 0, -0.01)), meetings);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
