#include "core/force/proxy/straight_sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

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
        clearance{.offset = radius_m / geometry.unit_m(), .slop = kSweepSlop, .tolerance = 0x1p-9 * kSweepSlop},
        sweep(surfaces, false) {}

  // Tests every triangle against the whole motion in one piece.
  double time_by_brute_force(const Vec3& from, const Vec3& motion) const {
    double first = kNever;
    for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t)
      first = std::min(first, time_to_block(TriangleView{geometry, t}, from, motion, 1.0, clearance));
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
  Clearance clearance;
  StraightSweep sweep;
  ProxyState proxy;
};

TriangleMesh soup_of_size(std::size_t count, double size, std::mt19937_64& random) {
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

// However little work a call may do, the sweep ends where one test of the whole motion against all triangles ends; no call does much more.
TEST_P(StraightSweepAmongMany, StopsWhereBruteForceDoesAndIsInterruptedInTime) {
  RecordProperty("seed", std::to_string(GetParam()));
  std::mt19937_64 random(GetParam());
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  constexpr int kMaxOver = 5 * 128 + 64;  // five boxes of 128, as a piece is cut up to four times; and at least 64 tests in a ball
  int interruptions = 0;
  int stops = 0;
  for (const double size : {0.002, 0.02, 0.1}) {
    for (const double radius_m : {0.001, 0.01}) {
      StraightStage stage(soup_of_size(3000, size, random), radius_m);
      for (int i = 0; i < 100; ++i) {
        const Vec3 from = stage.geometry.to_local(0.12 * Vec3(unit(random), unit(random), unit(random)));
        if (stage.clearance_of(from) < stage.clearance.offset) continue;
        const Vec3 motion = std::pow(10.0, unit(random) - 1.0) * Vec3(unit(random), unit(random), unit(random));
        const double expected = stage.time_by_brute_force(from, motion);
        const int most_work = 100 + static_cast<int>(random() % 400);
        stage.proxy.settle_at(from);
        stage.sweep.start(from, motion);
        double time = 0.0;
        for (int call = 0;; ++call) {
          ASSERT_LT(call, 1000);
          int work = 0;
          const auto end = stage.sweep.go_on(stage.proxy, stage.clearance, 0, work, most_work);
          ASSERT_LE(work, most_work + kMaxOver);
          ASSERT_EQ(stage.sweep.is_interrupted(), end == StraightSweep::End::interrupted);
          interruptions += stage.sweep.is_interrupted() ? 1 : 0;
          if (end == StraightSweep::End::free) time = 1.0;
          if (end == StraightSweep::End::free) break;
          if (end == StraightSweep::End::interrupted) continue;
          time = stage.sweep.time();
          if (!stage.sweep.blockers().empty()) ++stops;
          break;
        }
        const bool has_used_up_its_work = stage.sweep.blockers().empty() && time < 1.0;  // the work was used up after a free piece
        if (has_used_up_its_work) {
          EXPECT_LE(time, expected);
        } else {
          EXPECT_NEAR(time, std::min(1.0, expected), 1e-9) << "size " << size << ", radius " << radius_m << ", path " << i;
        }
      }
    }
  }
  EXPECT_GT(interruptions, 0);
  EXPECT_GT(stops, 50);
}

INSTANTIATE_TEST_SUITE_P(Seeds, StraightSweepAmongMany, testing::Values(1U, 2U, 3U));

// The box around the probe at the centre of a fine ball contains thousands of triangles; none of them is near the probe.
TEST(StraightSweep, TrianglesInTheBoxButFarFromTheProbeCostNothing) {
  StraightStage stage(make_icosphere(0.05, 5), 0.045);
  int work = 0;
  const Vec3 motion = Vec3::Constant(1e-5);
  stage.proxy.settle_at(stage.geometry.to_local(Vec3::Zero()));
  stage.sweep.start(stage.proxy.position, motion);
  ASSERT_EQ(stage.sweep.go_on(stage.proxy, stage.clearance, 0, work, StepWork::kMax), StraightSweep::End::free);
  EXPECT_LE(work, 160);
}

// Small triangles in directions around +z, each about kRadius_m from the origin.
class StraightSweepOnACap : public testing::TestWithParam<unsigned> {
 protected:
  static constexpr std::size_t kCount = 60;  // more than the contacts that a proxy can have
  static constexpr double kRadius_m = 0.05;

  StraightSweepOnACap() : random_(GetParam()) { RecordProperty("seed", std::to_string(GetParam())); }
  // slack_m: each triangle is nearer to the origin than kRadius_m by a random distance up to this.
  TriangleMesh cap(double slack_m) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < kCount; ++i) {
      const double x = unit(random_);
      const double y = unit(random_);
      const Vec3 out = Vec3(x, y, 1.5).normalized();
      const Vec3 along = out.unitOrthogonal();
      const Vec3 at = (kRadius_m - slack_m * (0.5 + 0.5 * unit(random_))) * out;
      mesh.vertices.insert(mesh.vertices.end(),
                           {at - 1e-4 * along - 1e-4 * out.cross(along), at + 1e-4 * along, at + 1e-4 * out.cross(along)});
      mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
  }
  // The triangles of the `count` smallest values.
  static std::vector<std::uint32_t> triangles_of_least(std::vector<std::pair<double, std::uint32_t>> values, std::size_t count) {
    std::sort(values.begin(), values.end());
    std::vector<std::uint32_t> triangles;
    for (std::size_t i = 0; i < std::min(count, values.size()); ++i) triangles.push_back(values[i].second);
    std::sort(triangles.begin(), triangles.end());
    return triangles;
  }

  std::mt19937_64 random_;
};

TEST_P(StraightSweepOnACap, OfManyOverlapsTheFastestApproachedBlock) {
  StraightStage stage(cap(1e-3), kRadius_m);
  const Vec3 from = stage.geometry.to_local(Vec3::Zero());
  const Vec3 motion(0.01, 0.02, 0.1);
  stage.proxy.settle_at(from);
  stage.sweep.start(from, motion);
  int work = 0;
  ASSERT_EQ(stage.sweep.go_on(stage.proxy, stage.clearance, 0, work, StepWork::kMax), StraightSweep::End::stopped);
  EXPECT_EQ(stage.sweep.time(), 0.0);
  std::vector<std::pair<double, std::uint32_t>> rates;
  for (std::uint32_t t = 0; t < kCount; ++t) rates.emplace_back(stage.geometry.separation(t, from).normal.dot(motion), t);
  std::vector<std::uint32_t> blocker_ids;
  for (const StraightSweep::Blocker& blocker : stage.sweep.blockers()) blocker_ids.push_back(blocker.triangle);
  std::sort(blocker_ids.begin(), blocker_ids.end());
  EXPECT_EQ(blocker_ids, triangles_of_least(rates, ProxyState::kMaxContacts));
}

TEST_P(StraightSweepOnACap, OfManyThatItTouchesItKeepsTheNearestAndThoseThatAreFixed) {
  StraightStage stage(cap(1e-3), kRadius_m);
  const Vec3 from = stage.geometry.to_local(Vec3::Zero());
  std::vector<std::pair<double, std::uint32_t>> distances;
  for (std::uint32_t t = 0; t < kCount; ++t) distances.emplace_back(stage.geometry.separation(t, from).distance, t);
  std::sort(distances.begin(), distances.end());
  for (const int fixed_count : {0, 3}) {
    stage.proxy = ProxyState();
    stage.proxy.settle_at(from);
    for (int i = 0; i < fixed_count; ++i) {  // the farthest triangles are the fixed contacts
      const std::uint32_t triangle = distances[distances.size() - 1 - static_cast<std::size_t>(i)].second;
      ProxyContact& contact = stage.proxy.contacts[static_cast<std::size_t>(stage.proxy.contact_count++)];
      contact = {.triangle = triangle, .shape = stage.surfaces.shape_of(triangle), .separation = stage.geometry.separation(triangle, from)};
    }
    std::vector<std::uint32_t> expected = triangles_of_least(distances, static_cast<std::size_t>(ProxyState::kMaxContacts - fixed_count));
    for (int i = 0; i < fixed_count; ++i) expected.push_back(stage.proxy.contacts[static_cast<std::size_t>(i)].triangle);
    std::sort(expected.begin(), expected.end());
    stage.sweep.drop();
    stage.sweep.start(from, Vec3::Zero());
    int work = 0;
    (void)stage.sweep.go_on(stage.proxy, stage.clearance, fixed_count, work, StepWork::kMax);
    ASSERT_EQ(stage.proxy.contact_count, ProxyState::kMaxContacts);
    std::vector<std::uint32_t> contact_ids;
    for (const ProxyContact& contact : stage.proxy.contacts) contact_ids.push_back(contact.triangle);
    std::sort(contact_ids.begin(), contact_ids.end());
    EXPECT_EQ(contact_ids, expected) << fixed_count << " fixed";
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, StraightSweepOnACap, testing::Values(1U, 2U, 3U));

// Small triangles around the x axis, a little farther from it than the probe's radius.
TriangleMesh make_tube(std::size_t count, double radius_m, std::mt19937_64& random) {
  TriangleMesh tube;
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (std::uint32_t t = 0; t < count; ++t) {
    const double angle = 3.15 * unit(random);
    const Vec3 out(0.0, std::cos(angle), std::sin(angle));
    const Vec3 at = 0.05 * unit(random) * Vec3::UnitX() + 1.05 * radius_m * out;
    tube.vertices.insert(tube.vertices.end(), {at, at + 1e-4 * Vec3::UnitX(), at + 1e-4 * Vec3::UnitX().cross(out)});
    tube.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return tube;
}

// A call begins where the last one stopped, with pieces as long as the last pieces of that call: the whole motion takes only a few tests
// for each triangle.
TEST_P(StraightSweepAmongMany, TheWholeMotionInManyStepsTestsEachTriangleAFewTimes) {
  RecordProperty("seed", std::to_string(GetParam()));
  std::mt19937_64 random(GetParam());
  constexpr double kRadius_m = 0.004;
  StraightStage stage(make_tube(20000, kRadius_m, random), kRadius_m);
  Vec3 from = stage.geometry.to_local(Vec3(-0.04, 0.0, 0.0));
  const Vec3 to = stage.geometry.to_local(Vec3(0.04, 0.0, 0.0));
  int work = 0;
  int calls = 0;
  for (auto end = StraightSweep::End::stopped; end != StraightSweep::End::free; ++calls) {
    ASSERT_LT(calls, 1000);
    stage.proxy.settle_at(from);
    if (!stage.sweep.is_interrupted()) stage.sweep.start(from, to - from);
    int call_work = 0;
    end = stage.sweep.go_on(stage.proxy, stage.clearance, 0, call_work, 1000);
    work += call_work;
    if (end == StraightSweep::End::stopped) from += stage.sweep.time() * (to - from);
  }
  EXPECT_LT(work, 2 * 20000);
  EXPECT_LT(calls, 40);
}

// A call that runs out of work moves the probe to the end of the last piece that was found free. The probe waits only until the first piece
// has been found free.
TEST_P(StraightSweepAmongMany, WithoutWorkLeftTheProbeMovesToTheEndOfTheSearchedPart) {
  RecordProperty("seed", std::to_string(GetParam()));
  std::mt19937_64 random(GetParam());
  constexpr double kRadius_m = 0.004;
  StraightStage stage(make_tube(20000, kRadius_m, random), kRadius_m);
  const Vec3 from = stage.geometry.to_local(Vec3(-0.04, 0.0, 0.0));
  const Vec3 motion = stage.geometry.to_local(Vec3(0.04, 0.0, 0.0)) - from;
  stage.proxy.settle_at(from);
  stage.sweep.start(from, motion);
  for (int call = 0, searched = 0;; ++call) {
    ASSERT_LT(call, 1000) << "the probe waits";
    int work = 0;
    const auto end = stage.sweep.go_on(stage.proxy, stage.clearance, 0, work, 100);
    searched += work;
    if (end == StraightSweep::End::interrupted) continue;
    ASSERT_EQ(end, StraightSweep::End::stopped);
    EXPECT_TRUE(stage.sweep.blockers().empty());
    EXPECT_GT(stage.sweep.time(), 0.0);
    EXPECT_LT(stage.sweep.time(), 1.0);
    EXPECT_LT(searched, 2000) << "of about 20,000 along the whole motion";
    RecordProperty("searched", searched);
    break;
  }
}

}  // namespace
}  // namespace hapton
