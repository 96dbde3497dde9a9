#include "core/force/proxy/free_flight.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr double kFlightOffset = 0x1p-30;
constexpr Clearance kFlightClearance{.offset = kFlightOffset, .slop = 0.5 * kFlightOffset, .tolerance = 0x1p-10 * kFlightOffset};

struct FlightStage {
  explicit FlightStage(const TriangleMesh& mesh, const Material& material = {})
      : geometry({&mesh}),
        materials{material},
        surfaces(geometry, materials),
        flight(surfaces, kFlightClearance),
        surface(geometry, materials) {}

  FreeFlight::Met fly(const Vec3& from_S, const Vec3& to_S, double& time) {
    surface.leave();
    return flight.fly(geometry.to_local(from_S), geometry.to_local(to_S), false, surface, time);
  }
  // The least time at which the segment crosses any triangle.
  double time_by_brute_force(const Vec3& from_S, const Vec3& to_S) const {
    double first = kNever;
    for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) {
      first = std::min(first, geometry.pierce(t, geometry.to_local(from_S), geometry.to_local(to_S)).time);
    }
    return first;
  }

  TouchGeometry geometry;
  std::vector<Material> materials;
  ProxySurfaces surfaces;
  FreeFlight flight;
  SurfaceFollower surface;
};

TEST(FreeFlight, LandsOnTheFirstOfAllTriangles) {
  constexpr unsigned kSeed = 20261122;
  RecordProperty("seed", std::to_string(kSeed));
  FlightStage stage(make_bumpy_sphere(0.05, 0.2, 3000, 5));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(-0.08, 0.08);
  int landings = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 from(unit(random), unit(random), unit(random));
    const Vec3 to(unit(random), unit(random), unit(random));
    const double expected = stage.time_by_brute_force(from, to);
    double time = 1.0;
    const FreeFlight::Met met = stage.fly(from, to, time);
    ASSERT_EQ(met, expected > 1.0 ? FreeFlight::Met::nothing : FreeFlight::Met::walkable) << "flight " << i;
    if (expected > 1.0) continue;
    EXPECT_EQ(time, expected);
    ASSERT_TRUE(stage.surface.is_on_surface());
    const Vec3 at = stage.geometry.to_local(Vec3(from + time * (to - from)));
    EXPECT_LE((stage.surface.point() - at).norm(), 1e-12);
    ++landings;
  }
  EXPECT_GT(landings, 1000);
}

// The units of work of a flight away from all triangles, and of one just below the tip of a fan of 2,000 triangles.
TEST(FreeFlight, ItsWorkGrowsWithTheTrianglesOnTheWay) {
  constexpr std::uint32_t kCount = 2000;
  TriangleMesh cone;
  cone.vertices = {{0.0, 0.0, 0.05}};
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kCount;
    cone.vertices.emplace_back(0.05 * std::cos(angle), 0.05 * std::sin(angle), 0.0);
    cone.triangles.push_back({0, 1 + i, 1 + (i + 1) % kCount});
  }
  FlightStage stage(cone);
  double time = 1.0;
  EXPECT_EQ(stage.fly(Vec3(0.06, 0.0, 0.02), Vec3(0.06, 0.0, 0.03), time), FreeFlight::Met::nothing);
  EXPECT_EQ(stage.flight.work(), FreeFlight::kMinWork);
  EXPECT_EQ(stage.fly(Vec3(-5e-5, 0.0, 0.0499), Vec3(5e-5, 0.0, 0.0499), time), FreeFlight::Met::nothing);
  EXPECT_GE(stage.flight.work(), static_cast<int>(kCount) / 2 / SurfaceFollower::kFacetsPerUnit);
}

TEST(FreeFlight, PassesAOneSidedFaceFromBehind) {
  FlightStage stage(make_box(Vec3::Constant(0.1), 2), {.two_sided = false});
  double time = 1.0;
  EXPECT_EQ(stage.fly(Vec3(0.01, 0.012, 0.013), Vec3(0.09, 0.012, 0.013), time), FreeFlight::Met::nothing);
  EXPECT_EQ(stage.fly(Vec3(0.09, 0.012, 0.013), Vec3(0.01, 0.012, 0.013), time), FreeFlight::Met::walkable);
  EXPECT_NEAR(time, 0.5, 1e-12);
}

TEST(FreeFlight, StopsBeforeTrianglesThatAreNotWalkable) {
  const TriangleMesh sheet = make_plane_grid(0.1, 2);
  FlightStage stage(joined(sheet, sheet));  // each triangle twice
  double time = 1.0;
  EXPECT_EQ(stage.fly(Vec3(0.011, 0.013, 0.05), Vec3(0.011, 0.013, -0.05), time), FreeFlight::Met::other);
  EXPECT_FALSE(stage.surface.is_on_surface());
  EXPECT_EQ(stage.fly(Vec3(0.011, 0.013, 0.05), Vec3(0.011, 0.013, 0.01), time), FreeFlight::Met::nothing);
}

TEST(FreeFlight, APointTooNearIsMovedOffOnItsOwnSide) {
  FlightStage stage(make_box(Vec3::Constant(0.1), 2));
  const double face = stage.geometry.to_local(Vec3(0.05, 0.0, 0.0)).x();
  const Vec3 beside = stage.geometry.to_local(Vec3(0.05, 0.012, 0.013));
  for (const double side : {1.0, -1.0}) {
    Vec3 p = beside;
    p.x() = face + side * 0.25 * kFlightOffset;
    const Vec3 off = stage.flight.clear_of_surfaces(p, 16.0 * kFlightOffset);
    EXPECT_NEAR(off.x() - face, side * kFlightOffset, 1e-3 * kFlightOffset);
    EXPECT_EQ(stage.flight.clear_of_surfaces(p, 0.25 * kFlightOffset), p);  // this limit is shorter than the way to the offset
  }
  const Vec3 far = stage.geometry.to_local(Vec3(0.06, 0.012, 0.013));
  EXPECT_EQ(stage.flight.clear_of_surfaces(far, 1.0), far);
}

TEST(FreeFlight, APointExactlyOnAnEdgeOrACornerIsMovedOffTheFacesThere) {
  FlightStage stage(make_box(Vec3::Constant(0.125), 1));  // its corners are exact in local units
  const double face = stage.geometry.to_local(Vec3(0.0625, 0.0, 0.0)).x();
  for (const int other_faces : {0, 1, 2}) {  // along how many axes, besides x, the point is at a face of the box
    const Vec3 p(face, other_faces >= 1 ? -face : 0.0101 * face, other_faces >= 2 ? face : 0.0203 * face);
    const Vec3 off = stage.flight.clear_of_surfaces(p, 16.0 * kFlightOffset) - p;
    for (int axis = 0; axis <= other_faces; ++axis)
      EXPECT_NEAR(std::fabs(off[axis]), kFlightOffset, 1e-3 * kFlightOffset) << "other faces " << other_faces;
    for (int axis = other_faces + 1; axis < 3; ++axis) EXPECT_NEAR(off[axis], 0.0, 1e-3 * kFlightOffset) << "other faces " << other_faces;
  }
}

TEST(FreeFlight, APointOnASurfaceTakesTheOuterSide) {
  FlightStage stage(make_box(Vec3::Constant(0.1), 2));
  for (const Vec3& p_S : {Vec3(0.05, 0.012, 0.013), Vec3(0.05, 0.05, 0.013), Vec3(0.05, 0.05, -0.05), Vec3(0.05, 0.0, 0.0)}) {
    const Vec3 off = stage.flight.off_surface(stage.geometry.to_local(p_S), kFlightOffset);
    EXPECT_GT(stage.geometry.to_scene(off).cwiseAbs().maxCoeff(), 0.05) << p_S.transpose();
    for (std::uint32_t t = 0; t < stage.geometry.triangle_count(); ++t) {
      EXPECT_GE(stage.geometry.separation(t, off).distance, kFlightOffset) << p_S.transpose();
    }
  }
}

}  // namespace
}  // namespace hapton
