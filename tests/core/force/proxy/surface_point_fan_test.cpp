#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <utility>

#include "core/force/proxy/surface_point.h"
#include "core/geometry/mesh_shapes.h"
#include "core/math/side_sign.h"
#include "tests/support/surface_stage.h"

// SurfacePoint at a vertex: its fan, the directions that lead on from the vertex, and its free side.
namespace hapton {
namespace {

// Height of p above the fan at vertex 0, which is the origin, with the faces of the fan extended to infinity.
double height_over_fan(const TriangleMesh& saddle, const Vec3& p) {
  for (const auto& [a, b, c] : saddle.triangles) {
    Eigen::Matrix2d base;
    base << saddle.vertices[b].head<2>(), saddle.vertices[c].head<2>();
    const Eigen::Vector2d shares = base.inverse() * p.head<2>();
    if (shares.minCoeff() >= 0.0) return p.z() - shares[0] * saddle.vertices[b].z() - shares[1] * saddle.vertices[c].z();
  }
  ADD_FAILURE() << "no face over " << p.transpose();
  return 0.0;
}

// The fan has every triangle side at the vertex once, and each shares its edge `next` with the one after it.
void expect_a_whole_fan(const SurfaceStage& stage, const std::set<std::uint32_t>& triangles_at_vertex, std::size_t sides) {
  const SurfacePoint& point = stage.point;
  const auto fan = point.fan();
  std::set<std::pair<std::uint32_t, bool>> sides_in_fan;
  for (std::size_t i = 0; i < fan.size(); ++i) {
    const SurfacePoint::FanFacet& facet = fan[i];
    EXPECT_TRUE(triangles_at_vertex.contains(facet.id));
    EXPECT_TRUE(sides_in_fan.insert({facet.id, facet.back}).second);
    EXPECT_EQ(stage.geometry.corner(facet.id, facet.corner), point.point());
    const SurfacePoint::FanFacet& after = fan[(i + 1) % fan.size()];
    const int far = facet.next == facet.corner ? (facet.corner + 1) % 3 : facet.next;
    const Vec3 along = stage.geometry.corner(facet.id, far) - point.point();
    expect_near(facet.direction, along.normalized());
    EXPECT_TRUE(stage.round(point.point() + along).contains(after.id));
    const Vec3 to_middle = stage.middle(facet.id) - point.point();
    EXPECT_NEAR(facet.normal.dot(to_middle), 0.0, 1e-14);
    EXPECT_NEAR(facet.normal.norm(), 1.0, 1e-14);
    for (const Vec3& inward : facet.inward) EXPECT_GT(inward.dot(to_middle), 0.0);
  }
  EXPECT_EQ(sides_in_fan.size(), sides * triangles_at_vertex.size());
}

TEST(SurfacePointFan, AFanIsAllTrianglesRoundAVertexOfAClosedMesh) {
  SurfaceStage stage(make_bumpy_sphere(0.5, 0.2, 300, 5));
  for (std::uint32_t t = 0; t < stage.count(); ++t) {
    for (int k = 0; k < 3; ++k) {
      ASSERT_TRUE(stage.point.land(t, k == 1, stage.middle(t)));
      ASSERT_TRUE(stage.point.reach_vertex(k));
      EXPECT_EQ(stage.point.point(), stage.geometry.corner(t, k));
      EXPECT_EQ(stage.point.fan()[0].back, k == 1);
      expect_a_whole_fan(stage, stage.round(stage.geometry.corner(t, k)), 1);
    }
  }
}

TEST(SurfacePointFan, AFanAtABoundaryIsBothSidesOfItsTriangles) {
  const TriangleMesh mesh = make_plane_grid(1.0, 3);
  SurfaceStage stage(mesh);
  SurfaceStage one_sided(mesh, false);
  int inner = 0;
  for (const Vec3& vertex : mesh.vertices) {
    const Vec3 p = stage.geometry.to_local(vertex);
    const bool is_inner = vertex.cwiseAbs().maxCoeff() < 0.4;
    inner += is_inner ? 1 : 0;
    ASSERT_TRUE(stage.stand_at_vertex(p));
    expect_a_whole_fan(stage, stage.round(p), is_inner ? 1 : 2);
    EXPECT_EQ(one_sided.stand_at_vertex(p), is_inner);  // at the boundary, the back side of the fan holds nothing
    EXPECT_EQ(one_sided.point.on() == SurfacePoint::On::vertex, is_inner);
  }
  EXPECT_EQ(inner, 4);
}

// The length of the steepest way is the largest component of the vector to the device along any direction in the faces of the fan.
TEST(SurfacePointFan, TheSteepestWayIsTheSteepestDirectionOfAllFaces) {
  constexpr int kDirections = 500;
  std::mt19937_64 random = make_random(23);
  int faces = 0, edges = 0, none = 0;
  SurfaceStage stage(make_bumpy_sphere(0.5, 0.3, 80, 9));
  for (int trial = 0; trial < 600; ++trial) {
    const std::uint32_t t = static_cast<std::uint32_t>(random() % stage.count());
    ASSERT_TRUE(stage.point.land(t, trial % 2 == 1, stage.middle(t)));
    ASSERT_TRUE(stage.point.reach_vertex(trial % 3));
    const auto fan = stage.point.fan();
    Vec3 to_device = random_vector(random);
    if (trial % 4 == 0) {  // the device is behind most faces, so that the vertex may be a local minimum
      to_device *= 0.2;
      for (const SurfacePoint::FanFacet& facet : fan) to_device -= facet.normal;
    }
    double steepest = 0.0;
    for (std::size_t i = 0; i < fan.size(); ++i) {
      const Vec3& first = fan[(i + fan.size() - 1) % fan.size()].direction;
      for (int d = 0; d <= kDirections; ++d) {
        const double u = static_cast<double>(d) / kDirections;
        steepest = std::max(steepest, ((1.0 - u) * first + u * fan[i].direction).normalized().dot(to_device));
      }
    }
    const SurfacePoint::Descent way = stage.point.find_steepest(to_device, 0.0);
    ASSERT_EQ(way.facet != nullptr, steepest > 0.0) << trial;
    EXPECT_EQ(stage.point.find_steepest(to_device, 1.0001 * steepest + 1e-9).facet, nullptr) << trial;
    none += way.facet == nullptr ? 1 : 0;
    if (way.facet == nullptr) continue;
    (way.over_face ? faces : edges) += 1;
    EXPECT_NEAR(way.length, steepest, 1e-4 * to_device.norm()) << trial;
    EXPECT_GE(way.length, steepest - 1e-14 * to_device.norm()) << trial;
    const double of_way = way.over_face ? way.facet->normal.cross(to_device).norm() : way.facet->direction.dot(to_device);
    EXPECT_NEAR(way.length, of_way, 1e-13 * to_device.norm());
  }
  EXPECT_GT(faces, 100);
  EXPECT_GT(edges, 20);
  EXPECT_GT(none, 10);
}

TEST(SurfacePointFan, BeforeTheFanOfACubesCornerIsOutsideTheCube) {
  std::mt19937_64 random = make_random(31);
  const TriangleMesh mesh = make_box(Vec3::Constant(1.0));
  SurfaceStage stage(mesh);
  for (const bool back : {false, true}) {
    int before = 0;
    for (const Vec3& corner : mesh.vertices) {
      ASSERT_TRUE(stage.stand_at_vertex(stage.geometry.to_local(corner), back));
      for (int i = 0; i < 200; ++i) {
        const Vec3 p = corner + 0.1 * random_vector(random).normalized();
        const bool is_outside = p.cwiseAbs().maxCoeff() > 0.5;
        EXPECT_EQ(stage.point.is_before_fan(stage.geometry.to_local(p)), is_outside != back) << p.transpose();
        before += is_outside != back ? 1 : 0;
      }
    }
    EXPECT_GT(before, 100);
  }
}

// A point exactly on the surface counts as shifted (side_sign.h): on an edge either of two faces may decide, at the corner any of three.
TEST(SurfacePointFan, OnAnEdgeOfACubeBeforeItsFanIsWhereTheShiftLeads) {
  const TriangleMesh mesh = make_box(Vec3::Constant(1.0));
  SurfaceStage stage(mesh);
  for (const bool back : {false, true}) {
    for (const Vec3& corner : mesh.vertices) {
      ASSERT_TRUE(stage.stand_at_vertex(stage.geometry.to_local(corner), back));
      for (int axis = 0; axis < 3; ++axis) {
        for (const double along : {0.25, 0.0}) {
          Vec3 p = corner;
          p[axis] *= 1.0 - along;
          const bool is_outside = (p + 1e-9 * kShift).cwiseAbs().maxCoeff() > 0.5;
          EXPECT_EQ(stage.point.is_before_fan(stage.geometry.to_local(p)), is_outside != back) << p.transpose();
        }
      }
    }
  }
}

TEST(SurfacePointFan, BeforeTheFanOfASaddleIsAboveIt) {
  std::mt19937_64 random = make_random(37);
  for (const int waves : {2, 3}) {
    for (const double height : {0.1, 0.8, 3.0}) {
      const TriangleMesh mesh = make_saddle(waves, height, 7 * waves);
      SurfaceStage stage(mesh);
      for (const bool back : {false, true}) {
        ASSERT_TRUE(stage.stand_at_vertex(stage.local(0, 0, 0), back));
        for (int i = 0; i < 1000; ++i) {
          const Vec3 p = 0.2 * random_vector(random).normalized();
          const double above = height_over_fan(mesh, p);
          if (std::fabs(above) < 1e-12) continue;
          EXPECT_EQ(stage.point.is_before_fan(stage.geometry.to_local(p)), (above > 0.0) != back) << p.transpose();
        }
      }
    }
  }
}

TEST(SurfacePointFan, AtACubesCornerItIsFreeTowardsTheOutside) {
  const TriangleMesh mesh = make_box(Vec3::Constant(1.0));
  SurfaceStage stage(mesh);
  for (const Vec3& corner : mesh.vertices) {
    ASSERT_TRUE(stage.stand_at_vertex(stage.geometry.to_local(corner)));
    const Vec3 off = corner.normalized();
    EXPECT_TRUE(stage.point.is_free_at_vertex(0.1 * off));
    EXPECT_FALSE(stage.point.is_free_at_vertex(-0.1 * off));
    EXPECT_FALSE(stage.point.is_free_at_vertex(0.5 * SurfacePoint::kMinPull * off));  // too near to the vertex to tell
  }
}

}  // namespace
}  // namespace hapton
