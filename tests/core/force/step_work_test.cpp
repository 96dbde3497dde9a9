#include "core/force/step_work.h"

#include <gtest/gtest.h>

#include <random>

#include "core/force/proxy/proxy_method.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_scene.h"

namespace hapton {
namespace {

// A box that stands on another one: where their faces touch, the triangles are not walkable.
TriangleMesh touching_boxes() {
  TriangleMesh boxes = make_box(Vec3(0.1, 0.1, 0.05), 12);
  const TriangleMesh upper = make_box(Vec3(0.05, 0.05, 0.05), 8);
  const auto first = static_cast<std::uint32_t>(boxes.vertices.size());
  for (const Vec3& v : upper.vertices) boxes.vertices.push_back(v + Vec3(0.01, 0.0, 0.05));
  for (const Triangle& t : upper.triangles) boxes.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  return boxes;
}

// A point and a sphere, each with and without friction, on triangles that are not walkable and on many that are.
template <class Try>
void for_each_case(Try&& try_case) {
  for (const TriangleMesh& mesh : {touching_boxes(), make_bumpy_sphere(0.05, 0.2, 20000, 5)}) {
    for (const double radius_m : {0.0, 0.003}) {
      for (const double friction : {0.0, 0.5}) {
        SCOPED_TRACE(testing::Message() << mesh.triangles.size() << " triangles, radius " << radius_m << ", friction " << friction);
        TouchScene scene = scene_of(mesh);
        scene.objects[0].material.friction_static = friction;
        scene.objects[0].material.friction_dynamic = 0.8 * friction;
        try_case([&] { return std::move(*ProxyMethod::make({.probe_radius_m = radius_m}, scene)); });
      }
    }
  }
}

// Positions inside and outside of these meshes, far from each other.
class RandomPosition {
 public:
  explicit RandomPosition(unsigned seed) : random_(seed) {}
  Vec3 operator()() {
    const double x = place_(random_);
    const double y = place_(random_);
    return {x, y, place_(random_)};
  }

 private:
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> place_{-0.06, 0.06};
};

// However far the device moves in a step, follower and sweep together do no more than the work of one step plus the event in progress.
TEST(StepWork, NoStepExceedsItsWork) {
  constexpr std::uint64_t kWorkOfAnEvent = 1024;
  constexpr unsigned kSeed = 154;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::uint64_t most_work = 0;
  int carried_steps = 0;
  for_each_case([&](auto&& make) {
    const auto method = make();
    auto& proxy = static_cast<ProxyMethod&>(*method);
    RandomPosition random_position(kSeed);
    proxy.reset(Vec3(0.0, 0.0, 0.2));
    for (int i = 0; i < 300; ++i) {
      const std::uint64_t queried_before = proxy.sphere().queried();
      const std::uint64_t tested_before = proxy.swept().counters().tests;
      (void)proxy.step({.p_SD = random_position()});
      most_work = std::max(most_work, proxy.sphere().queried() - queried_before + proxy.swept().counters().tests - tested_before);
      carried_steps += proxy.carried_from() ? 1 : 0;
    }
    EXPECT_LE(proxy.counters().most_events, static_cast<std::uint64_t>(StepWork::kMax));
  });
  EXPECT_LE(most_work, static_cast<std::uint64_t>(StepWork::kMax) + kWorkOfAnEvent);
  EXPECT_GT(carried_steps, 20) << "no motion was long enough to try it";
}

// A point between two walls of several triangles each does not search for a way out, not even at the edges of their triangles.
TEST(StepWork, APointBetweenWallsLooksForNoWayOut) {
  constexpr double kWall = 0.035;  // x of the upper box
  constexpr double kTop = 0.025;   // z of the lower one
  constexpr double kCell = 0.05 / 8.0;
  constexpr std::uint64_t kMaxWork = 60;  // in units; a step takes 10 to 40, a search for a way out 60 to 130 more
  const auto method = std::move(*ProxyMethod::make({}, scene_of(touching_boxes())));
  auto& proxy = static_cast<ProxyMethod&>(*method);
  std::uint64_t steps_with_work = 0;
  for (int line = -2; line <= 3; ++line) {
    for (const double beside : {0.0, 1e-9, -1e-9, 1e-3}) {
      const double y = line * kCell + beside;
      proxy.reset({kWall + 0.01, y, kTop + 0.01});
      // The probe slides there along y, so that the gathered triangles reach as far as a way out would lead.
      for (int i = 100; i >= 0; --i) (void)proxy.step({.p_SD = {kWall - 0.001, y - 1e-4 * i, kTop - 0.001}});
      for (int i = 1; i <= 10; ++i) {
        const double depth = 0.001 + 0.0001 * i;
        const std::uint64_t queried_before = proxy.sphere().queried();
        const MethodOutput felt = proxy.step({.p_SD = {kWall - depth, y, kTop - 1.3 * depth}});
        const std::uint64_t work = proxy.sphere().queried() - queried_before;
        steps_with_work += work > 0 ? 1 : 0;
        EXPECT_LE(work, kMaxWork) << "line " << line << ", beside " << beside << ", step " << i;
        EXPECT_LE((felt.p_SP - Vec3(kWall, y, kTop)).norm(), 1e-9);
      }
    }
  }
  EXPECT_GT(steps_with_work, 200U) << "the triangles are walkable";
}

// The result of a step does not depend on anything before the reset: a method that has been used gives the same force as a new one, to
// the last bit.
TEST(StepWork, AResetForgetsAllThatWasBefore) {
  constexpr unsigned kSeed = 155;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  for_each_case([&](auto&& make) {
    const auto used = make();
    const auto fresh = make();
    RandomPosition random_position(kSeed);
    for (int round = 0; round < 3; ++round) {
      for (int i = 0; i < 50; ++i) (void)used->step({.p_SD = random_position()});
      used->reset(Vec3(0.0, 0.0, 0.2));
      fresh->reset(Vec3(0.0, 0.0, 0.2));
      for (int i = 0; i < 50; ++i) {
        const Vec3 device = random_position();
        const Vec3 expected_n = fresh->step({.p_SD = device}).force_n;
        ASSERT_EQ(used->step({.p_SD = device}).force_n, expected_n) << "step " << i << " of round " << round;
      }
    }
  });
}

}  // namespace
}  // namespace hapton
