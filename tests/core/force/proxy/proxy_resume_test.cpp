// A method resumes where another instance, on another part of the same scene, has held the probe.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>

#include "core/force/proxy/proxy_method.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_scene.h"

namespace hapton {
namespace {

constexpr double kSheetHalfSide = 0.05;

// Sheets in the same place. Their triangles face away from the hand, which is above: only the position of the probe shows on which side it
// is.
TriangleMesh reversed_sheets(int count) {
  TriangleMesh mesh;
  for (int n = 0; n < count; ++n) {
    const TriangleMesh one = made::sheet(kSheetHalfSide, 0.0, 10);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), one.vertices.begin(), one.vertices.end());
    for (const Triangle& t : one.triangles) mesh.triangles.push_back({first + t[0], first + t[2], first + t[1]});
  }
  return mesh;
}

std::unique_ptr<ForceMethod> proxy_of(const TouchScene& scene) { return std::move(*ProxyMethod::make(MethodSettings(), scene)); }

// On walkable faces, and on two sheets in the same place, whose faces are not walkable.
TEST(ProxyResume, ResumesOnTheSideThatTheProbeIsOn) {
  for (const int sheets : {1, 2}) {
    const TouchScene scene = scene_of(reversed_sheets(sheets));
    auto before = proxy_of(scene);
    auto after = proxy_of(scene);
    const std::uint64_t seed = 3;
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (int n = 0; n < 500; ++n) {
      const Vec3 above(0.8 * kSheetHalfSide * unit(random), 0.8 * kSheetHalfSide * unit(random), 0.01);
      const Vec3 below = above + Vec3(0.002 * unit(random), 0.002 * unit(random), -0.012);
      before->reset(above);
      const MethodOutput held = before->step({.p_SD = below});
      ASSERT_TRUE(before->held_at().has_value());
      after->resume(*before->held_at());
      const MethodOutput felt = after->step({.p_SD = below});
      ASSERT_NEAR((felt.force_n - held.force_n).norm(), 0.0, 1e-6) << sheets << " sheets, n " << n;
      ASSERT_NEAR(felt.force_n.z(), 2.0, 1e-6);
    }
  }
}

// The device is exactly on the surface: no force is left, but the probe is held.
TEST(ProxyResume, AProbeWithoutForceIsHeldStill) {
  const TouchScene scene = scene_of(reversed_sheets(1));
  auto before = proxy_of(scene);
  before->reset({0.001, 0.002, 0.01});
  (void)before->step({.p_SD = {0.001, 0.002, -0.001}});
  EXPECT_FALSE(before->step({.p_SD = {0.001, 0.002, 0.0}}).contact);
  ASSERT_TRUE(before->held_at().has_value());
  auto after = proxy_of(scene);
  after->resume(*before->held_at());
  EXPECT_NEAR(after->step({.p_SD = {0.001, 0.002, -0.001}}).force_n.z(), 1.0, 1e-6);
}

TEST(ProxyResume, AFreeProbeIsNotHeld) {
  auto method = proxy_of(scene_of(reversed_sheets(1)));
  method->reset({0.0, 0.0, 0.01});
  EXPECT_FALSE(method->held_at().has_value());
  for (int n = 0; n < 20; ++n) (void)method->step({.p_SD = {0.0, 0.0, 0.01 + 1e-5 * n}});
  EXPECT_FALSE(method->held_at().has_value());
}

// The whole is a sheet on which the hand slides from the right half to the left half; the part is the left half.
TEST(ProxyResume, APartOfTheSceneGivesTheForceOfTheWhole) {
  const TriangleMesh whole_mesh = reversed_sheets(1);
  TriangleMesh half = whole_mesh;
  std::erase_if(half.triangles, [&](const Triangle& t) {
    return std::any_of(t.begin(), t.end(), [&](std::uint32_t v) { return whole_mesh.vertices[v].x() > 0.011; });
  });
  TouchScene part = scene_of(half);
  for (const Vec3& v : whole_mesh.vertices) part.part_of.grow(v);
  auto whole = proxy_of(scene_of(whole_mesh));
  auto of_part = proxy_of(part);
  whole->reset({0.02, 0.0, 0.01});
  double worst_n = 0.0;
  AllocationGuard guard;
  for (int n = 0; n < 400; ++n) {
    const MethodInput input{.p_SD = {0.02 - 1e-4 * n, 1e-5 * n, -0.002}};
    const MethodOutput expected = whole->step(input);
    if (n == 200) of_part->resume(*whole->held_at());
    if (n < 200) continue;
    worst_n = std::max(worst_n, (of_part->step(input).force_n - expected.force_n).norm());
  }
  EXPECT_TRUE(!AllocationGuard::is_available() || guard.count() == 0U);
  EXPECT_LT(worst_n, 1e-6);
}

}  // namespace
}  // namespace hapton
