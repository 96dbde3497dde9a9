#include "core/force/proxy/straight_sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "core/force/step_work.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kSweepSlop = 0x1p-31;

struct StraightStage {
  explicit StraightStage(const TriangleMesh& mesh, double radius_m)
      : geometry({&mesh}),
        materials(1),
        surfaces(geometry, materials),
        keep{.offset = radius_m / geometry.unit_m(), .slop = kSweepSlop, .tolerance = 0x1p-9 * kSweepSlop},
        sweep(surfaces, false) {}

  // Every triangle, from the start to the end in one piece.
  double first_by_brute_force(const Vec3& from, const Vec3& motion) const {
    double first = kNever;
    for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t)
      first = std::min(first, time_to_block(TriangleView{geometry, t}, from, motion, 1.0, keep));
    return first;
  }
  double clearance_of(const Vec3& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) least = std::min(least, geometry.separation(t, p).distance);
    return least;
  }

  TouchGeometry geometry;
  std::vector<Material> materials;
  ProxySurfaces surfaces;
  Clearance keep;
  StraightSweep sweep;
  ProxyState proxy;
};

TriangleMesh soup_of_sizes(std::size_t count, double size, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  TriangleMesh soup;
  for (std::uint32_t t = 0; t < count; ++t) {
    const Vec3 at = 0.1 * vector();
    for (int k = 0; k < 3; ++k) soup.vertices.push_back(at + size * vector());
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return soup;
}

class StraightSweepAmongMany : public testing::TestWithParam<unsigned> {};

// The same as one piece over all triangles, however little work each call has; and no call has hardly more than that.
TEST_P(StraightSweepAmongMany, StopsWhereBruteForceDoesAndIsInterruptedInTime) {
  RecordProperty("seed", std::to_string(GetParam()));
  std::mt19937_64 random(GetParam());
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  constexpr int kMostOver = 5 * 128 + 64;  // a box that is cut four times, and what a ball begins
  int interrupted = 0;
  int stopped = 0;
  for (const double size : {0.002, 0.02, 0.1}) {
    for (const double radius_m : {0.001, 0.01}) {
      StraightStage stage(soup_of_sizes(3000, size, random), radius_m);
      for (int i = 0; i < 100; ++i) {
        const Vec3 from = stage.geometry.to_local(0.12 * Vec3(unit(random), unit(random), unit(random)));
        if (stage.clearance_of(from) < stage.keep.offset) continue;
        const Vec3 motion = std::pow(10.0, unit(random) - 1.0) * Vec3(unit(random), unit(random), unit(random));
        const double expected = stage.first_by_brute_force(from, motion);
        const int most_work = 100 + static_cast<int>(random() % 400);
        stage.proxy.settle_at(from);
        stage.sweep.start(from, motion);
        double time = 0.0;
        for (int call = 0;; ++call) {
          ASSERT_LT(call, 1000);
          int work = 0;
          const auto end = stage.sweep.go_on(stage.proxy, stage.keep, 0, work, most_work);
          ASSERT_LE(work, most_work + kMostOver);
          ASSERT_EQ(stage.sweep.is_interrupted(), end == StraightSweep::End::interrupted);
          interrupted += stage.sweep.is_interrupted() ? 1 : 0;
          if (end == StraightSweep::End::free) time = 1.0;
          if (end == StraightSweep::End::free) break;
          if (end == StraightSweep::End::interrupted) continue;
          time = stage.sweep.time();
          if (!stage.sweep.blockers().empty()) ++stopped;
          break;
        }
        const bool has_arrived = stage.sweep.blockers().empty() && time < 1.0;  // out of work between two pieces
        if (has_arrived) {
          EXPECT_LE(time, expected);
        } else {
          EXPECT_NEAR(time, std::min(1.0, expected), 1e-9) << "size " << size << ", radius " << radius_m << ", path " << i;
        }
      }
    }
  }
  EXPECT_GT(interrupted, 0);
  EXPECT_GT(stopped, 50);
}

INSTANTIATE_TEST_SUITE_P(Seeds, StraightSweepAmongMany, testing::Values(1U, 2U, 3U));

// Around the centre of a fine ball are thousands of triangles in its box, and none is near.
TEST(StraightSweep, TrianglesInTheBoxButFarFromTheProbeCostNothing) {
  StraightStage stage(make_icosphere(0.05, 5), 0.045);
  int work = 0;
  const Vec3 motion = Vec3::Constant(1e-5);
  stage.proxy.settle_at(stage.geometry.to_local(Vec3::Zero()));
  stage.sweep.start(stage.proxy.position, motion);
  ASSERT_EQ(stage.sweep.go_on(stage.proxy, stage.keep, 0, work, StepWork::kMost), StraightSweep::End::free);
  EXPECT_LE(work, 160);
}

}  // namespace
}  // namespace hapton
