#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "core/force/proxy/proxy_method.h"
#include "core/force/reference/reference_method.h"

namespace hapton {
namespace {

constexpr double kHeldRadius = 1.0;
constexpr double kPullLength = 3.0;
constexpr double kHeldAngle = std::numbers::pi / 6.0;  // angle below the sphere's middle at which it leans on the edge

// A floor with a step half a radius high: a sphere on the floor leans on the step's edge.
TouchScene floor_with_step() {
  TriangleMesh mesh;
  const double x = kHeldRadius * std::cos(kHeldAngle);
  const double high = kHeldRadius * (1.0 - std::sin(kHeldAngle));
  for (const double y : {-20.0, 20.0}) {
    mesh.vertices.insert(mesh.vertices.end(), {{-20.0, y, 0.0}, {x, y, 0.0}, {x, y, high}, {20.0, y, high}});
  }
  mesh.triangles = {{0, 1, 4}, {1, 5, 4}, {1, 2, 5}, {2, 6, 5}, {2, 3, 6}, {3, 7, 6}};
  TouchScene scene;
  TouchObject object;
  object.mesh = std::make_shared<const TriangleMesh>(mesh);
  scene.objects.push_back(object);
  return scene;
}

// The device whose pull would just lift the sphere over the step, but with the sideways part of the pull reduced by this share.
Vec3 device_short_of_lifting(double share) {
  const double sideways = std::cos(kHeldAngle) / std::sin(kHeldAngle) * (1.0 - share);
  return Vec3(0.0, 0.0, kHeldRadius) + kPullLength * Vec3(sideways, 0.0, -1.0).normalized();
}

const Vec3 kLeaningCentre(0.0, 0.0, kHeldRadius);

class HeldSphere : public testing::TestWithParam<std::string> {
 protected:
  // Presses the sphere onto the floor before the step, and then pulls it to the device in steps of a thousandth of its radius. Returns the
  // proxy.
  static Vec3 pull_to(const Vec3& device) {
    MethodSettings settings;
    settings.name = GetParam();
    settings.probe_radius_m = kHeldRadius;
    const auto method = make_method(settings, floor_with_step()).value();
    const Vec3 free = kLeaningCentre + Vec3(-1e-3, 0.0, 1e-3);
    method->reset(free);
    const Vec3 below = kLeaningCentre - Vec3(0.0, 0.0, kPullLength);
    method->step({.p_SD = below});
    const auto steps = static_cast<int>((device - below).norm() / (1e-3 * kHeldRadius));
    Vec3 proxy;
    for (int i = 0; i <= steps; ++i) proxy = method->step({.p_SD = below + (device - below) * (static_cast<double>(i) / steps)}).p_SP;
    return proxy;
  }
};

TEST_P(HeldSphere, LeansOnTheStepAsLongAsNothingLeadsDown) {
  for (const double share : {0.2, 0.05, 0.01, 0.001}) {
    EXPECT_LE((pull_to(device_short_of_lifting(share)) - kLeaningCentre).norm(), 1e-7 * kHeldRadius) << "short of lifting by " << share;
  }
}

TEST_P(HeldSphere, GoesOverOnceItIsLifted) {
  EXPECT_GE((pull_to(device_short_of_lifting(-0.001)) - kLeaningCentre).norm(), 0.5 * kHeldRadius);
}

INSTANTIATE_TEST_SUITE_P(Methods, HeldSphere, testing::Values("proxy", "reference"));

TEST(HeldSphere, TheReferenceFindsItAtAMinimumAtEveryOffset) {
  MethodSettings settings;
  settings.probe_radius_m = kHeldRadius;
  const auto reference = ReferenceMethod::make_reference(settings, floor_with_step()).value();
  for (const double share : {0.2, 0.05, 0.01, 0.001}) {
    const Vec3 proxy = reference->settle_from(kLeaningCentre + Vec3(0.0, 0.0, 1e-9), device_short_of_lifting(share)).p_SP;
    EXPECT_LE((proxy - kLeaningCentre).norm(), 1e-7 * kHeldRadius) << "short of lifting by " << share;
  }
}

}  // namespace
}  // namespace hapton
