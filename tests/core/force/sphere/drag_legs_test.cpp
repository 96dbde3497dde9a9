#include "core/force/sphere/drag_legs.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "core/math/straight_motion.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr Clearance kClearanceOfDrags{0.02, 0x1p-40, 0x1p-46};
constexpr FrictionCoefficients kFrictionOfDrags{0.5, 0.4};

// A sphere on a plane of many triangles, or on the edge of a box.
struct DraggedSphere {
  explicit DraggedSphere(TriangleMesh shape) : mesh(std::move(shape)), geometry(std::vector<const TriangleMesh*>{&mesh}) {
    near = std::make_unique<GatheredTriangles>(geometry, materials, kClearanceOfDrags, 1e-4);
  }
  void touch(const Vec3& c) {
    centre = c;
    EXPECT_TRUE(near->gather(centre, Vec3::Zero(), work));
    contacts.clear();
    near->visit_near(centre, centre, kClearanceOfDrags.offset + 1e-9, [&](int slot) {
      if (!contacts.is_empty() || near->shape(slot).separation(centre).distance > kClearanceOfDrags.offset + 1e-9) return;
      contacts.add(OffsetContact::nearest(near->triangle(slot), near->shape(slot), centre));
    });
    contacts.activate_all();
    ASSERT_EQ(contacts.active_count(), 1);
  }
  OffsetDrag drag() const { return {contacts.active(), {&friction, 1}, kClearanceOfDrags.offset}; }
  DragLegs legs() { return {contacts, PathEvents(contacts, *near, *space, work), centre, step, work}; }

  TriangleMesh mesh;
  TouchGeometry geometry;
  std::vector<Material> materials{Material{}};
  std::unique_ptr<GatheredTriangles> near;
  std::unique_ptr<PathEvents::Space> space = std::make_unique<PathEvents::Space>();
  ContactSet contacts{kClearanceOfDrags};
  FrictionCoefficients friction = kFrictionOfDrags;
  Vec3 centre = Vec3::Zero();
  double step = 0.0;
  int work = 0;
};

TEST(DragLegsOf, ASlipOverAPlaneEndsOnTheCone) {
  DraggedSphere sphere(made::sheet(0.4, 0.0, 8));
  sphere.touch(Vec3(0.031, 0.017, kClearanceOfDrags.offset));
  const Vec3 device = sphere.centre + Vec3(0.015, -0.005, -0.02);
  OffsetDrag::Pull pull;
  ASSERT_TRUE(sphere.drag().find_pull(sphere.centre, device, pull));
  SlipPath slip;
  ASSERT_TRUE(sphere.legs().make_slip(sphere.drag(), pull, device, false, slip));
  EXPECT_TRUE(slip.stops);
  const double length = Vec3(0.015, -0.005, 0.0).norm() - kFrictionOfDrags.dynamic_mu * 0.02;
  EXPECT_NEAR(slip.length, length, 1e-14);
  EXPECT_LT((slip.path.end() - (sphere.centre + length * Vec3(0.015, -0.005, 0.0).normalized())).norm(), 1e-14);
}

// Compares with many small steps of return mapping, each of which puts the centre back onto the cone along the pull.
TEST(DragLegsOf, ADragOverAPlaneIsTheLimitOfSmallSteps) {
  constexpr int kSteps = 200'000;
  DraggedSphere sphere(made::sheet(0.4, 0.0, 8));
  sphere.touch(Vec3(0.031, 0.017, kClearanceOfDrags.offset));
  const double reach = kFrictionOfDrags.dynamic_mu * 0.02;
  const Vec3 from = sphere.centre + Vec3(reach, 0.0, -0.02);
  const Vec3 to = from + Vec3(0.004, 0.01, 0.0);
  DragLeg leg;
  ASSERT_EQ(sphere.legs().make(sphere.drag(), from, to, 0.0, leg), DragOutcome::moves);
  ASSERT_GT(leg.time, 0.0);
  Vec3 c = sphere.centre;
  for (int i = 1; i <= kSteps; ++i) {
    Vec3 off = on_path(from, to, leg.time * i / kSteps) - c;
    off.z() = 0.0;
    if (off.norm() > reach) c += (1.0 - reach / off.norm()) * off;
  }
  EXPECT_LT((leg.path.end() - c).norm(), 1e-7);
}

TEST(DragLegsOf, AroundAnEdgeTheEndIsOnTheCone) {
  DraggedSphere sphere(made::box(Vec3(-0.3, -0.3, -0.3), Vec3(0.3, 0.3, 0.3)));
  const Vec3 edge(0.3, 0.02, 0.3);
  const Vec3 normal = Vec3(1.0, 0.0, 1.0).normalized();
  sphere.touch(sphere.geometry.to_local(edge) + kClearanceOfDrags.offset * normal);
  ASSERT_EQ(sphere.contacts[0].part, Feature::edge);
  const double depth = 0.004;
  const Vec3 from = sphere.centre - depth * normal + kFrictionOfDrags.dynamic_mu * depth * Vec3::UnitY();
  DragLeg leg;
  const Vec3 to = from + Vec3(0.001, 0.004, -0.001);
  ASSERT_EQ(sphere.legs().make(sphere.drag(), from, to, 0.0, leg), DragOutcome::moves);
  ASSERT_GT(leg.time, 0.0);
  EXPECT_GT(leg.flow, 0.0);
  EXPECT_GT(sphere.step, 0.0);
  OffsetDrag::Pull there;
  ASSERT_TRUE(sphere.drag().find_pull(leg.path.end(), on_path(from, to, leg.time), there));
  EXPECT_NEAR(there.excess(), 0.0, 1e-9);
  EXPECT_NEAR(sphere.contacts[0].proximity(leg.path.end()).distance, kClearanceOfDrags.offset, kClearanceOfDrags.tolerance);
}

TEST(DragLegsOf, APullThatFallsBelowTheConeStops) {
  DraggedSphere sphere(made::sheet(0.4, 0.0, 8));
  sphere.touch(Vec3(0.031, 0.017, kClearanceOfDrags.offset));
  const Vec3 from = sphere.centre + Vec3(kFrictionOfDrags.dynamic_mu * 0.02, 0.0, -0.02);
  DragLeg leg;
  EXPECT_EQ(sphere.legs().make(sphere.drag(), from, from - Vec3(0.01, 0.0, 0.0), 0.0, leg), DragOutcome::stops);
}

}  // namespace
}  // namespace hapton
