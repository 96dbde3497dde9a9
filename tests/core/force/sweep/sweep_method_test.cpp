#include "core/force/sweep/sweep_method.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "tests/support/allocation_guard.h"
#include "tests/support/brute_force_sweep.h"
#include "tests/support/made_meshes.h"
#include "tests/support/made_scene.h"

namespace hapton {
namespace {

constexpr double kOffsetVector = 0.0005 * 0.0254;  // 0.0005 inches, in metres

std::unique_ptr<SweepMethod> make_sweep(const TouchScene& scene, std::array<int, 3> division = {32, 32, 32},
                                        double offset_m = kOffsetVector) {
  MethodSettings settings;
  settings.grid_division = division;
  settings.offset_m = offset_m;
  auto made = SweepMethod::make(settings, scene);
  if (!made) {
    ADD_FAILURE() << made.error().what;
    return nullptr;
  }
  return std::unique_ptr<SweepMethod>(static_cast<SweepMethod*>(made->release()));
}

MethodOutput step(ForceMethod& method, const Vec3& p_SD) { return method.step({.p_SD = p_SD}); }

// What a step to p_SD adds to the counters.
SweepCounters count_step(SweepMethod& method, const Vec3& p_SD) {
  const SweepCounters before = method.counters();
  step(method, p_SD);
  const SweepCounters& after = method.counters();
  return {.cells_visited = after.cells_visited - before.cells_visited,
          .empty_cells = after.empty_cells - before.empty_cells,
          .repeated_triangles = after.repeated_triangles - before.repeated_triangles,
          .triangles_tested = after.triangles_tested - before.triangles_tested,
          .parallel = after.parallel - before.parallel,
          .out_of_length = after.out_of_length - before.out_of_length,
          .out_of_triangle = after.out_of_triangle - before.out_of_triangle,
          .from_behind = after.from_behind - before.from_behind,
          .collisions = after.collisions - before.collisions};
}

TEST(SweepMethod, AgreesWithItsBruteForceTwin) {
  constexpr std::uint64_t kSeed = 31;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal(0.0, 1.0);
  const auto vector = [&] { return Vec3(normal(random), normal(random), normal(random)); };

  TouchScene two_objects = scene_of(made::sphere(0.03, 16, 0.1));
  two_objects.objects.push_back({made::shared(made::box({0.01, -0.05, -0.05}, {0.05, 0.05, 0.05})), {.stiffness_n_per_m = 300.0}});
  const std::vector<TouchScene> scenes = {scene_of(made::soup(kSeed, 600, 0.05, 0.03)), scene_of(made::sphere(0.05, 20, 0.2)),
                                          scene_of(made::sheet(0.05, 0.0, 20)), two_objects};
  std::size_t contacts = 0;
  std::size_t steps_with_several_collisions = 0;
  for (const TouchScene& scene : scenes) {
    for (const auto& division : {std::array<int, 3>{32, 32, 32}, std::array<int, 3>{1, 1, 1}, std::array<int, 3>{5, 60, 13}}) {
      const auto method = make_sweep(scene, division);
      made::BruteForceSweep twin(scene, kOffsetVector);
      Vec3 p = 0.08 * vector().normalized();
      method->reset(p);
      twin.reset(p);
      for (int i = 0; i < 4000; ++i) {
        // A random walk attracted to the middle, with a long jump (and a pause) now and then.
        p += i % 50 == 49 ? Vec3(0.05 * vector()) : i % 50 == 25 ? Vec3(Vec3::Zero()) : Vec3(0.0006 * vector() - 0.002 * p);
        const std::uint64_t before = method->counters().collisions;
        const MethodOutput felt = step(*method, p);
        const MethodOutput expected = twin.step(p);
        // The twin rounds differently: forces agree to 1e-9 N, positions to a picometre.
        ASSERT_LE((felt.force_n - expected.force_n).norm(), 1e-9) << "step " << i;
        ASSERT_LE((felt.p_SP - expected.p_SP).norm(), 1e-12) << "step " << i;
        ASSERT_EQ(felt.contact, expected.contact) << "step " << i;
        ASSERT_EQ(method->counters().collisions - before, twin.collisions) << "step " << i;
        contacts += felt.contact ? 1 : 0;
        steps_with_several_collisions += twin.collisions > 1 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(contacts, 3000U);
  EXPECT_GT(steps_with_several_collisions, 100U);
}

TEST(SweepMethod, PressingAPlaneIsHookesLawFromEitherSide) {
  for (const double side : {1.0, -1.0}) {
    const auto method = make_sweep(scene_of(made::sheet(0.1, 0.0, 7), {.stiffness_n_per_m = 800.0}));
    method->reset({0.013, 0.02, side * 0.01});
    EXPECT_FALSE(step(*method, {0.013, 0.02, side * 0.001}).contact);
    for (const double depth : {0.0005, 0.001, 0.003, 0.002, 0.0001}) {
      const MethodOutput felt = step(*method, {0.013, 0.02, -side * depth});
      ASSERT_TRUE(felt.contact);
      EXPECT_NEAR(felt.force_n[2], side * 800.0 * depth, 1e-12);
      EXPECT_EQ(felt.force_n.head<2>().norm(), 0.0);
      EXPECT_NEAR((felt.p_SP - Vec3(0.013, 0.02, 0.0)).norm(), 0.0, 1e-15);
    }
    const MethodOutput free = step(*method, {0.013, 0.02, side * 0.0001});
    EXPECT_FALSE(free.contact);
    EXPECT_EQ(free.force_n, Vec3::Zero());
    EXPECT_EQ(free.p_SP, Vec3(0.013, 0.02, side * 0.0001));
  }
}

TEST(SweepMethod, TheNextLineStartsAtTheOffsetFromTheCollisionPoint) {
  // A slide at constant depth: the line that starts at the offset above the collision point meets the plane after the fraction
  // offset / (offset + depth) of the path to the new position.
  constexpr double kDepth = 0.001;
  for (const double offset : {kOffsetVector, 1e-4, 1e-3}) {
    const auto method = make_sweep(scene_of(made::sheet(0.1, 0.0, 7)), {32, 32, 32}, offset);
    method->reset({0.0, 0.0, 0.01});
    double x = step(*method, {0.0, 0.0, -kDepth}).p_SP[0];
    ASSERT_NEAR(x, 0.0, 1e-15);
    for (int i = 1; i <= 40; ++i) {
      const double goal = 1e-4 * i;
      x += (goal - x) * offset / (offset + kDepth);
      const MethodOutput felt = step(*method, {goal, 0.0, -kDepth});
      ASSERT_NEAR(felt.p_SP[0], x, 1e-12) << "offset " << offset << " step " << i;
      ASSERT_NEAR(felt.force_n[2], 1.0, 1e-9);
    }
  }
}

TEST(SweepMethod, SlidingKeepsContactOverEdgesOfAClosedShape) {
  const auto method = make_sweep(scene_of(made::sphere(0.05, 24, 0.0)));
  constexpr double kDepth = 0.0008;
  Vec3 outside(0.06, 0, 0.003);
  method->reset(outside);
  for (int i = 0; i < 8000; ++i) {
    const double angle = i * 2e-4;  // 8 mm/s at 1 kHz
    const Vec3 direction(std::cos(angle), std::sin(angle) * 0.8, std::sin(angle) * 0.6);
    const MethodOutput felt = step(*method, (0.05 - kDepth) * direction.normalized());
    ASSERT_TRUE(felt.contact) << "step " << i;
    ASSERT_GT(felt.force_n.dot(direction), 0.0) << "step " << i;
    ASSERT_NEAR(felt.force_n.norm(), 1000.0 * kDepth, 0.5) << "step " << i;
  }
}

TEST(SweepMethod, OfSeveralCollisionsTheFirstOnThePathHasTheGreatestDepth) {
  TouchScene scene = scene_of(made::sheet(0.05, 0.002, 3), {.stiffness_n_per_m = 100.0});
  scene.objects.push_back({made::shared(made::sheet(0.05, 0.001, 3)), {.stiffness_n_per_m = 10.0}});
  scene.objects.push_back({made::shared(made::sheet(0.05, 0.003, 3)), {.stiffness_n_per_m = 1000.0}});
  const auto method = make_sweep(scene);
  method->reset({0.001, 0.002, 0.01});
  EXPECT_NEAR(step(*method, {0.001, 0.002, 0.0}).force_n[2], 1000.0 * 0.003, 1e-12);
  EXPECT_EQ(method->counters().collisions, 3U);
  method->reset({0.001, 0.002, -0.01});
  EXPECT_NEAR(step(*method, {0.001, 0.002, 0.01}).force_n[2], -10.0 * 0.009, 1e-12);
}

TEST(SweepMethod, OneSidedSurfaceIsTouchedFromItsFrontOnly) {
  const auto method = make_sweep(scene_of(made::sheet(0.05, 0.0, 3), {.two_sided = false}));
  method->reset({0.01, 0.0, 0.001});
  EXPECT_TRUE(step(*method, {0.01, 0.0, -0.001}).contact);
  EXPECT_EQ(method->counters().from_behind, 0U);
  const std::uint64_t out_of_length = method->counters().out_of_length;
  method->reset({0.01, 0.0, -0.001});
  EXPECT_FALSE(step(*method, {0.01, 0.0, 0.001}).contact);
  EXPECT_EQ(method->counters().from_behind, 1U);
  EXPECT_EQ(method->counters().out_of_length, out_of_length);
  const std::string text = method->describe();
  EXPECT_NE(text.find("step 5 1 collisions, 1 more rejected: with the back of a one-sided triangle"), std::string::npos) << text;
}

TEST(SweepMethod, CountersShowWhereTheWorkEnded) {
  // One flat layer of 4 x 4 cells with two triangles.
  const auto method = make_sweep(scene_of(made::sheet(0.04, 0.0, 1)), {4, 4, 4});
  // A line within one cell below the diagonal; the cell lists only the lower triangle.
  method->reset({0.033, -0.033, 0.001});
  const SweepCounters within = count_step(*method, {0.033, -0.033, -0.001});
  EXPECT_EQ(within.cells_visited, 1U);
  EXPECT_EQ(within.triangles_tested, 1U);
  EXPECT_EQ(within.collisions, 1U);
  // A line from end to end visits all cells and tests each triangle once.
  method->reset({-0.039, 0.03, 0.001});
  const SweepCounters across = count_step(*method, {0.039, -0.038, -0.001});
  EXPECT_EQ(across.cells_visited, 16U);
  EXPECT_EQ(across.triangles_tested, 2U);
  EXPECT_EQ(across.triangles_tested + across.repeated_triangles, method->grid().occupancy().entries);
  EXPECT_EQ(across.collisions + across.out_of_triangle, 2U);
  // A line in the plane of the sheet ends at step 2 (parallel). A line above the sheet's box visits no cell at all.
  method->reset({-0.03, 0.01, 0.0});
  const SweepCounters along = count_step(*method, {-0.02, 0.01, 0.0});
  EXPECT_GE(along.parallel, 1U);
  EXPECT_EQ(along.collisions, 0U);
  method->reset({0, 0, 0.002});
  EXPECT_EQ(count_step(*method, {0, 0, 0.001}).cells_visited, 0U);
  EXPECT_EQ(method->steps(), 4U);
  EXPECT_EQ(method->counters().collisions, 2U);
}

TEST(SweepMethod, EmptyCellsEndAtStepOne) {
  const auto method = make_sweep(scene_of(made::sphere(0.05, 12)), {10, 10, 10});
  method->reset({-0.001, -0.001, -0.001});
  const SweepCounters counters = count_step(*method, {0.001, 0.001, 0.001});
  EXPECT_EQ(counters.cells_visited, 8U);
  EXPECT_EQ(counters.empty_cells, 8U);
  EXPECT_EQ(counters.triangles_tested, 0U);
}

TEST(SweepMethod, RestingAndWildSamplesAreHarmless) {
  const auto method = make_sweep(scene_of(made::sphere(0.05, 12)));
  method->reset({0.06, 0, 0.001});
  EXPECT_FALSE(step(*method, {0.06, 0, 0.001}).contact);  // the device has not moved: no line
  const MethodOutput pressed = step(*method, {0.045, 0, 0.001});
  EXPECT_TRUE(pressed.contact);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(step(*method, {nan, 0, 0}).force_n, Vec3::Zero());
  EXPECT_TRUE(step(*method, {0, nan, 0}).p_SP.allFinite()) << "a probe is drawn where it was";
  EXPECT_EQ(step(*method, {std::numeric_limits<double>::infinity(), 0, 0}).force_n, Vec3::Zero());
  EXPECT_EQ(step(*method, {0.045, 0, 0.001}).contact, true);  // contact continued
  const MethodOutput far = step(*method, Vec3::Constant(1e300));
  EXPECT_TRUE(far.force_n.allFinite());
}

TEST(SweepMethod, HugeFiniteSamplesGiveFiniteForcesAndBringNoneBackWithThem) {
  const double largest = std::numeric_limits<double>::max();
  const auto method = make_sweep(scene_of(made::sphere(0.05, 12)));
  const std::vector<Vec3> wild = {
      {-largest, 0.001, 0.002}, {largest, largest, largest}, {-largest, largest, -largest}, {1e160, -1e200, 3.0}, {0.0, 0.0, -largest}};
  std::size_t contacts = 0;
  for (const Vec3& from : wild) {
    for (const Vec3& to : wild) {
      method->reset(from);
      for (const Vec3& p : {Vec3(0.001, 0.002, 0.003), to, from, Vec3(0.06, 0.0, 0.001), Vec3(0.04, 0.0, 0.001)}) {
        const MethodOutput felt = step(*method, p);
        ASSERT_TRUE(felt.force_n.allFinite() && felt.p_SP.allFinite()) << from.transpose() << " to " << to.transpose();
        contacts += felt.contact ? 1 : 0;
      }
      method->reset({0.06, 0, 0.001});
      EXPECT_TRUE(step(*method, {0.045, 0, 0.001}).contact);
    }
  }
  EXPECT_GT(contacts, wild.size());
}

TEST(SweepMethod, StepsUseNoHeap) {
  if (!AllocationGuard::is_available()) {
    GTEST_SKIP() << "heap use cannot be counted in this build";
  }
  const auto method = make_sweep(scene_of(made::sphere(0.05, 24, 0.1)));
  const AllocationGuard guard;
  for (int round = 0; round < 3; ++round) {
    method->reset({0.2, 0, 0});
    for (int i = 0; i < 1000; ++i) {
      const double angle = 0.3 * i;
      step(*method, (0.05 + 0.04 * std::sin(0.7 * i)) * Vec3(std::cos(angle), std::sin(angle), std::cos(2.7 * angle)));
    }
  }
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(method->counters().collisions, 1000U);
}

TEST(SweepMethod, WithoutResetTheFirstSampleIsFree) {
  const auto method = make_sweep(scene_of(made::sheet(0.05, 0.0, 3)));
  EXPECT_FALSE(step(*method, {0.01, 0, -0.001}).contact);
  EXPECT_TRUE(step(*method, {0.01, 0, 0.001}).contact);  // from below
}

TEST(SweepMethod, WorksAtEveryScale) {
  for (const double scale : {1e-6, 1e-3, 1.0, 1e3, 1e6}) {
    const auto method = make_sweep(scene_of(made::sphere(scale, 24)), {32, 32, 32}, 1e-4 * scale);
    method->reset(Vec3(0.1, 0.2, 1.5) * scale);
    const Vec3 buried = 0.9 * scale * Vec3(0.1, 0.2, 0.97).normalized();
    step(*method, buried);
    const MethodOutput felt = step(*method, buried);
    EXPECT_NEAR(felt.force_n.norm(), 1000.0 * 0.1 * scale, 5.0 * scale) << scale;
  }
}

TEST(SweepMethod, RejectsWhatItCannotDo) {
  MethodSettings settings;
  TriangleMesh points;
  points.vertices = {Vec3::Zero()};
  points.triangles = {{0, 0, 0}};
  EXPECT_FALSE(SweepMethod::make(settings, scene_of(points)));
  const TouchScene scene = scene_of(made::sphere(1.0, 6));
  EXPECT_TRUE(SweepMethod::make(settings, scene));
  for (const double offset : {0.0, -1.0, 1e-18, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    settings.offset_m = offset;
    EXPECT_FALSE(SweepMethod::make(settings, scene)) << offset;
  }
  settings.offset_m = kOffsetVector;
  settings.grid_division = {0, 1, 1};
  EXPECT_FALSE(SweepMethod::make(settings, scene));
  settings.grid_division = {32, 32, 32};
  settings.probe_radius_m = 1e-3;
  EXPECT_FALSE(SweepMethod::make(settings, scene));
}

TEST(SweepMethod, DescribesItsGrid) {
  const auto method = make_sweep(scene_of(made::sheet(0.05, 0.0, 2)), {2, 2, 2});
  const std::string text = method->describe();
  EXPECT_NE(text.find("8 triangles"), std::string::npos) << text;
  EXPECT_NE(text.find("2 x 2 x 1 cells"), std::string::npos) << text;
  EXPECT_NE(text.find("100.00 % occupied"), std::string::npos) << text;
}

}  // namespace
}  // namespace hapton
