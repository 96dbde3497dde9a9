#include "tools/check/surface_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/core.h>

#include <memory>
#include <utility>

#include "core/geometry/boundary_edges.h"
#include "core/geometry/cracked_shapes.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/seal_cracks.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

SceneObject object_with(TriangleMesh mesh) {
  SceneObject object;
  object.name = "part";
  object.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
  return object;
}

SceneObject sealed_object(TriangleMesh mesh) {
  SealReport report;
  SceneObject object = object_with(seal_cracks(std::move(mesh), report));
  object.sealed = report;
  return object;
}

SceneObject plate(double thickness_m) { return object_with(make_box(Vec3(0.08, 0.06, thickness_m), 2)); }

TEST(SurfaceCheck, AThinWallIsNamedWithAProbeThatFits) {
  const CheckFindings findings = check_surface(plate(0.00175), 0.001);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].fault, SceneFault::thin_wall);
  EXPECT_THAT(findings[0].what, HasSubstr("a wall is 1.75 mm thick, thinner than the ball of the probe (2 mm)"));
  EXPECT_EQ(findings[0].fix, "thicken it, or give --probe-radius 0.00087 or less") << "half of it is 0.000875";
  EXPECT_TRUE(check_surface(plate(0.00175), 0.00087).empty());
  EXPECT_TRUE(check_surface(plate(0.00175), 0.0).empty()) << "a point";
}

// Nobody wants a ball of less than a tenth of the given radius, so the fix is a point.
TEST(SurfaceCheck, AWallThatIsMuchTooThinIsTouchedWithAPoint) {
  EXPECT_EQ(check_surface(plate(0.00021), 0.001).at(0).fix, "thicken it, or give --probe-radius 0.0001 or less");
  EXPECT_EQ(check_surface(plate(0.00019), 0.001).at(0).fix, "thicken it, or touch it with a point (--probe-radius 0)");
}

TEST(SurfaceCheck, AVertexOfTooManyTrianglesIsNamedOnce) {
  EXPECT_TRUE(check_surface(object_with(make_cylinder(0.04, 0.02, 1000, 1)), 0.0).empty());
  const TriangleMesh wheel = make_cylinder(0.04, 0.02, 1001, 1);
  const CheckFindings findings = check_surface(object_with(wheel), 0.0);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].fault, SceneFault::large_fan);
  EXPECT_THAT(findings[0].what, HasSubstr("1001 triangles meet in one vertex (2 vertices of more than 1000)"));
  ASSERT_TRUE(findings[0].place_m);
  EXPECT_LT(findings[0].place_m->head<2>().norm(), 1e-9) << "in the middle of an end";
}

TEST(SurfaceCheck, OpeningsAreCountedAndTheWidestIsNamed) {
  TriangleMesh open = make_icosphere(0.04, 3);
  const auto remove = [&](const Vec3& at, double radius) {
    std::erase_if(open.triangles, [&](const Triangle& t) {
      return ((open.vertices[t[0]] + open.vertices[t[1]] + open.vertices[t[2]]) / 3.0 - at).norm() < radius;
    });
  };
  remove(Vec3(0, 0, 0.04), 0.015);
  const CheckFindings one = check_surface(object_with(open), 0.0);
  ASSERT_EQ(one.size(), 1U);
  EXPECT_EQ(one[0].fault, SceneFault::opening);
  EXPECT_THAT(one[0].what, HasSubstr("1 opening in its surface; the widest is "));
  remove(Vec3(0, 0, -0.04), 0.008);
  const CheckFindings two = check_surface(object_with(open), 0.0);
  ASSERT_EQ(two.size(), 1U);
  EXPECT_THAT(two[0].what, HasSubstr("2 openings in its surface; the widest is "));
  ASSERT_TRUE(two[0].place_m);
  EXPECT_GT(two[0].place_m->z(), 0.03) << "the wider one";
  EXPECT_THAT(check_surface(object_with(open), 0.0095).at(0).what, HasSubstr("1 opening")) << "the ball fits through the wider one alone";
  EXPECT_TRUE(check_surface(object_with(open), 0.03).empty()) << "it fits through none";
}

// A finding says how wide the open cracks are (not how far the check searched), and why they are open.
TEST(SurfaceCheck, CracksAreNamedWithTheirWidth) {
  SceneObject object = object_with(make_torn(make_icosphere(0.05, 2), 2.5e-5));
  CheckFindings findings = check_surface(object, 0.0);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].fault, SceneFault::crack);
  const BoundaryEdges cracks = count_boundary_edges(*object.mesh, 1e-4);
  EXPECT_LT(cracks.widest_crack, 2.5e-5);
  EXPECT_EQ(findings[0].what,
            fmt::format("960 edges of cracks up to {:.3g} mm wide are open: a point probe falls through", 1e3 * cracks.widest_crack));
  EXPECT_THAT(findings[0].fix, HasSubstr("remove seal_cracks = false"));

  object = sealed_object(*object.mesh);
  findings = check_surface(object, 0.0);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_THAT(findings[0].what, HasSubstr("are open; 960 wider than the 0.01 mm that is sealed: a point"));
  EXPECT_EQ(findings[0].fix, "close the gaps in the mesh");

  object = sealed_object(make_shaken(make_box(Vec3(0.1, 0.1, 0.1), 5), 1.5e-5, 1));
  ASSERT_GT(object.sealed.unsealed_edges, 0U);
  EXPECT_THAT(
      check_surface(object, 0.0).at(0).what,
      HasSubstr(fmt::format("{} not sealed, because that would move a vertex too far or flip a triangle", object.sealed.unsealed_edges)));
}

TEST(SurfaceCheck, SidesThatGoWrongAreCounted) {
  TriangleMesh turned = make_icosphere(0.04, 2);
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  SceneObject object = object_with(turned);
  object.material.two_sided = true;
  CheckFindings findings = check_surface(object, 0.0);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].what, "3 edges between triangles that face opposite sides: shading and methods that use the sides go wrong there");
  object.material.two_sided = false;
  findings = check_surface(object, 0.0);
  EXPECT_THAT(findings.at(0).what, HasSubstr("with two_sided = false they cannot be touched from outside"));
  const CheckFindings bodies = check_surface(
      object_with(joined(make_icosphere(0.04, 2), flipped(scaled_and_moved(make_icosphere(0.01, 2), 1.0, Vec3(0, 0.06, 0))))), 0.0);
  ASSERT_EQ(bodies.size(), 1U);
  EXPECT_THAT(bodies[0].what, HasSubstr("1 of 2 closed bodies are inside out"));
}

TEST(SurfaceCheck, InertiaIsNeededOfBodiesOnly) {
  SceneObject open = object_with(make_plane_grid(0.1, 2));
  EXPECT_TRUE(check_inertia(open).empty());
  open.mass_kg = 0.1;
  ASSERT_EQ(check_inertia(open).size(), 1U);
  EXPECT_EQ(check_inertia(open)[0].fault, SceneFault::no_inertia);
  SceneObject closed = plate(0.01);
  closed.mass_kg = 0.1;
  EXPECT_TRUE(check_inertia(closed).empty());
}

}  // namespace
}  // namespace hapton
