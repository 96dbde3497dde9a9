#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>

#include "core/force/force_method.h"
#include "core/force/proxy/proxy_method.h"
#include "core/force/reference/reference_method.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

// A probe with a radius pressed along a path over a bumpy sphere.
TEST(ProxyOffset, IsTheReferenceOverABumpySphere) {
  constexpr int kSteps = 300;
  const TouchScene scene{.objects = {{made::shared(made::sphere(0.05, 12, 0.05)), {}}}};
  const auto proxy = make_method({.name = "proxy", .probe_radius_m = 0.004}, scene).value();
  const auto reference = make_method({.name = "reference", .probe_radius_m = 0.004}, scene).value();
  const auto device = [](int i) {
    const double polar = 0.9 + 0.0021 * i;
    const double azimuth = 0.3 + 0.0037 * i;
    const double radius = 0.055 - 0.004 * std::min(1.0, i / 20.0) - 0.001 * std::sin(0.11 * i);
    return Vec3(radius * std::sin(polar) * std::cos(azimuth), radius * std::sin(polar) * std::sin(azimuth), radius * std::cos(polar));
  };
  proxy->reset(device(0));
  reference->reset(device(0));
  double worst_error = 0.0;
  int contacts = 0;
  for (int i = 0; i < kSteps; ++i) {
    const MethodOutput felt = proxy->step({.p_SD = device(i)});
    const MethodOutput expected = reference->step({.p_SD = device(i)});
    ASSERT_EQ(felt.contact, expected.contact) << "step " << i;
    if (!expected.contact) continue;
    ++contacts;
    const double error = (felt.force_n - expected.force_n).norm() / expected.force_n.norm();
    ASSERT_LE(error, 1e-6) << "step " << i;
    worst_error = std::max(worst_error, error);
  }
  RecordProperty("worst", std::to_string(worst_error));
  EXPECT_GT(contacts, 200);
  const ProxyCounters& counters = static_cast<const ProxyMethod&>(*proxy).counters();
  EXPECT_EQ(counters.swept, 0U);
  EXPECT_EQ(counters.exhausted, 0U);
}

// Bumps a fifth of the probe wide: a jump across the sheet takes many times the work of a step.
TEST(ProxyOffset, AMotionOutOfWorkGoesOnWithTheNextSteps) {
  constexpr int kParts = 2000;
  const auto finish = [](ForceMethod& method, const Vec3& device) {
    for (int i = 0; i < 100; ++i) {
      (void)method.step({.p_SD = device});
      if (!method.carried_from()) return true;
    }
    return false;
  };
  TriangleMesh bumps = made::sheet(0.05, 0.0, 200);
  for (Vec3& p : bumps.vertices) p.z() = 0.0001 * std::sin(2500.0 * p.x()) * std::sin(1900.0 * p.y() + 1.0);
  for (const double friction : {0.0, 0.4}) {
    const TouchScene scene{.objects = {{made::shared(bumps), {.friction_static = friction, .friction_dynamic = 0.75 * friction}}}};
    const auto at_once = make_method({.name = "proxy", .probe_radius_m = 0.002}, scene).value();
    const auto in_parts = make_method({.name = "proxy", .probe_radius_m = 0.002}, scene).value();
    const Vec3 from(-0.0443, 0.0029, 0.001);
    const Vec3 to(0.03, 0.01, 0.0);
    for (const auto& method : {at_once.get(), in_parts.get()}) {
      method->reset({-0.0442, 0.0027, 0.01});
      ASSERT_TRUE(finish(*method, from));
    }
    for (int i = 1; i < kParts; ++i) {
      const Vec3 device = from + (to - from) * i / kParts;
      ASSERT_TRUE(finish(*in_parts, device)) << i;
    }
    const MethodOutput expected = in_parts->step({.p_SD = to});
    MethodOutput output = at_once->step({.p_SD = to});
    int steps = 1;
    double remaining_m = (to - from).norm();
    for (; at_once->carried_from() && steps < 1000; ++steps) {
      const Vec3 reached = *at_once->carried_from();
      ASSERT_LE((reached - to).norm(), remaining_m);
      ASSERT_LE((reached - from).cross((to - from).normalized()).norm(), 1e-12) << "on the line of the motion";
      remaining_m = (reached - to).norm();
      ASSERT_TRUE(output.contact);
      ASSERT_NEAR((output.force_n - 1000.0 * (output.p_SP - to)).norm(), 0.0, 1e-3) << "the force is that of the proxy on its way";
      output = at_once->step({.p_SD = to});
    }
    for (const auto& method : {at_once.get(), in_parts.get()}) EXPECT_EQ(static_cast<const ProxyMethod&>(*method).counters().swept, 0U);
    EXPECT_GT(steps, 5) << "friction " << friction;
    EXPECT_FALSE(at_once->carried_from());
    // With friction, the errors of the cubics that approximate longer paths add up.
    EXPECT_LE((output.p_SP - expected.p_SP).norm(), (friction > 0.0 ? 1e-3 : 1e-8) * 0.002) << "friction " << friction;
    EXPECT_EQ(at_once->step({.p_SD = to}).p_SP, output.p_SP);
  }
}

// With friction. Two kinds of differences are left out: both methods start again after a jump over an edge whose radius is smaller than the
// depth, which the reference cuts short, and after a step in which the reference is unsettled.
struct RubbingPath {
  double radius;  // m
  double friction_static, friction_dynamic;
  std::uint64_t seed;
};
class ProxyOffsetWithFriction : public testing::TestWithParam<RubbingPath> {};

TEST_P(ProxyOffsetWithFriction, IsTheReferenceOverABumpySphere) {
  constexpr int kSteps = 120;
  constexpr double kSize = 0.4;  // m
  const RubbingPath& path = GetParam();
  RecordProperty("seed", std::to_string(path.seed));
  const Material rough{.friction_static = path.friction_static, .friction_dynamic = path.friction_dynamic};
  const TouchScene scene{.objects = {{made::shared(made::sphere(kSize, 16, 0.05)), rough}}};
  const auto proxy = make_method({.name = "proxy", .probe_radius_m = path.radius}, scene).value();
  const auto reference = make_method({.name = "reference", .probe_radius_m = path.radius}, scene).value();
  const ProxyMethod& method = static_cast<const ProxyMethod&>(*proxy);
  const SphereFollower& sphere = method.sphere();
  std::mt19937_64 random(path.seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Vec3 direction = Vec3(0.3, 0.5, 0.7).normalized();
  Vec3 turn = Vec3::Zero();
  proxy->reset(0.8 * direction);
  reference->reset(0.8 * direction);
  int compared_steps = 0;
  double sum_of_squares = 0.0;
  double worst_error = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double x = unit(random);
    const double y = unit(random);
    turn = 0.9 * turn + 0.004 * Vec3(x, y, unit(random));
    direction = (direction + turn).normalized();
    const Vec3 device = (kSize + path.radius * (0.2 + 0.3 * std::sin(0.05 * i))) * direction;
    const std::uint64_t slips = sphere.slips();
    const MethodOutput felt = proxy->step({.p_SD = device});
    const MethodOutput expected = reference->step({.p_SD = device});
    ASSERT_TRUE(felt.force_n.allFinite());
    if (sphere.slips() != slips || !static_cast<const ReferenceMethod&>(*reference).last_step().settled) {
      proxy->reset(0.8 * direction);
      reference->reset(0.8 * direction);
      continue;
    }
    ASSERT_EQ(felt.contact, expected.contact) << "step " << i;
    if (!expected.contact) continue;
    const double error = (felt.force_n - expected.force_n).norm() / expected.force_n.norm();
    ASSERT_LE(error, 1e-3) << "step " << i;
    sum_of_squares += error * error;
    worst_error = std::max(worst_error, error);
    ++compared_steps;
  }
  RecordProperty("worst", std::to_string(worst_error));
  EXPECT_GT(compared_steps, kSteps / 3);
  EXPECT_LE(std::sqrt(sum_of_squares / compared_steps), 1e-5);
  EXPECT_EQ(method.swept().counters().unconverged, 0U);
}

INSTANTIATE_TEST_SUITE_P(Paths, ProxyOffsetWithFriction,
                         testing::Values(RubbingPath{0.03, 0.3, 0.3, 1}, RubbingPath{0.03, 0.5, 0.4, 2}, RubbingPath{0.01, 0.3, 0.3, 3},
                                         RubbingPath{0.003, 0.3, 0.3, 1}, RubbingPath{0.003, 0.5, 0.4, 2}));

}  // namespace
}  // namespace hapton
