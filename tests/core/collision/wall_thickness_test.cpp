#include "core/collision/wall_thickness.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

// Brute-force twin: tests every ray against every triangle.
ThinWalls find_thin_walls_by_brute_force(const TriangleMesh& mesh, double width) {
  ThinWalls found;
  const auto normal = [&](std::size_t t) -> Vec3 {
    return (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).normalized();
  };
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    bool is_thin = false;
    for_each_thickness_sample(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), width, [&](const Vec3& p) {
      double nearest = width;
      std::uint32_t hit_triangle = t;
      for (std::uint32_t other = 0; other < mesh.triangles.size(); ++other) {
        bool is_neighbour = false;
        for (const std::uint32_t v : mesh.triangles[t]) {
          for (const std::uint32_t w : mesh.triangles[other]) is_neighbour = is_neighbour || v == w;
        }
        if (is_neighbour) continue;
        const auto hit = find_ray_hit(p, -normal(t), nearest, mesh.corner(other, 0), mesh.corner(other, 1), mesh.corner(other, 2));
        if (!hit) continue;
        nearest = *hit;
        hit_triangle = other;
      }
      if (hit_triangle == t || normal(hit_triangle).dot(-normal(t)) < kWallCosine) return;
      is_thin = true;
      if (!found.thinnest || nearest < found.thinnest->thickness) found.thinnest = {t, p, nearest};
    });
    found.triangles += is_thin ? 1 : 0;
  }
  return found;
}

void expect_as_brute_force(const TriangleMesh& mesh, double width, const char* what) {
  SCOPED_TRACE(testing::Message() << what << ", width " << width);
  const ThinWalls fast = find_thin_walls(mesh, width);
  const ThinWalls slow = find_thin_walls_by_brute_force(mesh, width);
  EXPECT_EQ(fast.triangles, slow.triangles);
  ASSERT_EQ(fast.thinnest.has_value(), slow.thinnest.has_value());
  if (!fast.thinnest) return;
  EXPECT_EQ(fast.thinnest->thickness, slow.thinnest->thickness);
  EXPECT_EQ(fast.thinnest->triangle, slow.thinnest->triangle);
  EXPECT_EQ(fast.thinnest->point, slow.thinnest->point);
}

TEST(WallThickness, OfAPlateIsItsThickness) {
  for (const double thickness : {0.05, 1e-3, 1e-5}) {
    for (const int cells : {1, 6}) {
      const TriangleMesh plate = make_box(Vec3(1.0, 0.8, thickness), cells);
      const ThinWalls found = find_thin_walls(plate, 1.5 * thickness);
      ASSERT_TRUE(found.thinnest) << thickness;
      EXPECT_NEAR(found.thinnest->thickness, thickness, 1e-9 * thickness);
      EXPECT_NEAR(std::abs(found.thinnest->point.z()), 0.5 * thickness, 1e-12);
      EXPECT_GE(found.triangles, static_cast<std::size_t>(4 * cells * cells)) << "top and bottom";
      EXPECT_FALSE(find_thin_walls(plate, 0.9 * thickness).thinnest);
    }
  }
}

TEST(WallThickness, DoesNotDependOnScaleAndPlace) {
  const TriangleMesh plate = make_box(Vec3(1.0, 0.8, 0.01), 3);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    const ThinWalls found = find_thin_walls(scaled_and_moved(plate, scale, 30.0 * scale * Vec3(1, -2, 3)), 0.02 * scale);
    ASSERT_TRUE(found.thinnest) << scale;
    EXPECT_NEAR(found.thinnest->thickness, 0.01 * scale, 1e-9 * scale);
    EXPECT_EQ(found.triangles, find_thin_walls(plate, 0.02).triangles);
  }
}

TEST(WallThickness, IsThatOfTheMaterialNotOfTheGap) {
  // Two blocks with a narrow gap: only material counts as a wall, not the gap. Turned inside out, the gap is material.
  const TriangleMesh block = make_box(Vec3(1.0, 0.8, 0.6), 2);
  const TriangleMesh blocks = joined(block, scaled_and_moved(block, 1.0, Vec3(0, 0, 0.601)));
  EXPECT_FALSE(find_thin_walls(blocks, 0.01).thinnest);
  const ThinWalls turned = find_thin_walls(flipped(blocks), 0.01);
  ASSERT_TRUE(turned.thinnest);
  EXPECT_NEAR(turned.thinnest->thickness, 0.001, 1e-9);
}

TEST(WallThickness, AnEdgeIsNoThinWall) {
  EXPECT_FALSE(find_thin_walls(make_box(Vec3(1.0, 0.8, 0.6), 8), 0.3).thinnest);
  EXPECT_FALSE(find_thin_walls(make_icosphere(0.5, 3), 0.5).thinnest);
  // A wedge of 40 degrees, divided so finely that rays cross it near its edge.
  TriangleMesh wedge = make_box(Vec3(1.0, 1.0, 1.0), 12);
  const double slope = std::tan(40.0 * 3.14159265358979 / 180.0);
  for (Vec3& v : wedge.vertices) v.z() = (v.z() + 0.5) * slope * (v.x() + 0.5 + 1e-3);
  EXPECT_FALSE(find_thin_walls(wedge, 0.2).thinnest);
}

TEST(WallThickness, CoincidentFacesHaveNoThickness) {
  const TriangleMesh sheet = make_plane_grid(1.0, 4);
  EXPECT_FALSE(find_thin_walls(joined(sheet, flipped(sheet)), 0.1).thinnest);
  EXPECT_FALSE(find_thin_walls(TriangleMesh{}, 0.1).thinnest);
  TriangleMesh point;
  point.vertices = {Vec3::Zero()};
  point.triangles = {{0, 0, 0}};
  EXPECT_FALSE(find_thin_walls(point, 0.1).thinnest);
}

TEST(WallThickness, PartsThatTouchAreWallsOfTheirOwn) {
  const TriangleMesh plate = make_box(Vec3(1.0, 0.8, 0.01), 3);
  for (const double gap : {0.0, 1e-9, -1e-9}) {
    const ThinWalls found = find_thin_walls(joined(plate, scaled_and_moved(plate, 1.0, Vec3(0.01, 0.02, 0.01 + gap))), 0.015);
    ASSERT_TRUE(found.thinnest) << gap;
    EXPECT_NEAR(found.thinnest->thickness, 0.01, 1e-8) << gap;
  }
}

// The top is two large triangles, above a small thin spot. Rays meet it from the large triangle or from the small ones.
TEST(WallThickness, FindsASmallThinSpotUnderALargeFace) {
  TriangleMesh block = make_box(Vec3(1.0, 1.0, 0.5), 1);
  const TriangleMesh pit = scaled_and_moved(flipped(make_box(Vec3(0.05, 0.05, 0.3), 1)), 1.0, Vec3(0.21, -0.17, 0.05));
  const ThinWalls found = find_thin_walls(joined(block, pit), 0.08);
  ASSERT_TRUE(found.thinnest);
  EXPECT_NEAR(found.thinnest->thickness, 0.05, 1e-9) << "a cavity 0.05 below the top";
  EXPECT_NEAR(found.thinnest->point.x(), 0.21, 0.03);
  EXPECT_NEAR(found.thinnest->point.y(), -0.17, 0.03);
}

TEST(WallThickness, IsThatOfBruteForce) {
  for (const double width : {0.004, 0.03, 0.2, 5.0}) {
    expect_as_brute_force(make_box(Vec3(1.0, 0.8, 0.01), 4), width, "plate");
    expect_as_brute_force(make_bumpy_sphere(0.5, 0.25, 300, 1), width, "bumps");
    expect_as_brute_force(make_thin_wall(1.0, 0.002, 4), width, "wall");
    expect_as_brute_force(make_torus(0.4, 0.1, 20, 8), width, "ring");
  }
}

}  // namespace
}  // namespace hapton
