#include "core/geometry/simplify_small.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/repair_mesh.h"
#include "core/geometry/smooth_surface.h"
#include "core/geometry/triangle_distance.h"
#include "tests/core/geometry/smooth_faces.h"
#include "tests/support/obj_mesh.h"

namespace hapton {
namespace {

TEST(SimplifySmall, SimplificationStaysWithinItsBound) {
  const TriangleMesh mesh = make_icosphere(0.05, 5);
  SmoothSurfaceReport report;
  const auto surface = make_smooth_surface(mesh, {.longest_edge = 0.0, .simplify_error_m = 0.0003}, report);
  ASSERT_TRUE(surface);
  EXPECT_LT(report.simplify.after, report.simplify.before / 4);
  EXPECT_LE(report.simplify.error_m, 0.0003);
  const TriangleMesh simplified = faces_of(*surface);
  EXPECT_TRUE(count_edges(simplified).closed());
  for (const Triangle& t : simplified.triangles) {
    const Vec3 middle = (simplified.vertices[t[0]] + simplified.vertices[t[1]] + simplified.vertices[t[2]]) / 3;
    EXPECT_NEAR(middle.norm(), 0.05, 0.0003);
  }
}

double distance_to(const TriangleMesh& mesh, const Vec3& p) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    least = std::min(least, triangle_distance_squared(p, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)));
  }
  return std::sqrt(least);
}

TEST(SimplifySmall, NoVertexIsLeftFartherOffThanTheBoundAllows) {
  for (const TriangleMesh& mesh : {make_bumpy_sphere(0.05, 0.2, 2000, 5), make_icosphere(0.05, 4), make_torus(0.035, 0.015, 64, 32),
                                   make_plane_grid(0.1, 24), made::obj_mesh("wingnut.obj")}) {
    const TriangleMesh clean = [&] {
      RepairReport report;
      return repair_mesh(mesh, report);
    }();
    const double extent = compute_bounds(clean).extent();
    for (const double share : {1e-4, 1e-3, 1e-2}) {
      TriangleMesh simplified = clean;
      const auto report = simplify_small(simplified, share * extent);
      ASSERT_TRUE(report) << report.error().what;
      EXPECT_EQ(report->after, simplified.triangles.size());
      EXPECT_LE(report->error_m, share * extent);
      if (share == 1e-2) {
        EXPECT_LT(report->after, report->before / 2);
      }
      std::set<std::uint32_t> used;
      for (const Triangle& t : clean.triangles) used.insert(t.begin(), t.end());
      for (const std::uint32_t v : used) ASSERT_LE(distance_to(simplified, clean.vertices[v]), report->error_m * (1.0 + 1e-12));
    }
  }
}

// The faces of a pyramid are small in a large plane, so the quadrics give its tip little weight; the tip must not be cut off.
TEST(SimplifySmall, KeepsAFlatTipWithinItsBound) {
  TriangleMesh plane = make_plane_grid(0.1, 20);
  auto middle =
      std::min_element(plane.vertices.begin(), plane.vertices.end(), [](const Vec3& a, const Vec3& b) { return a.norm() < b.norm(); });
  middle->z() = 0.0005;
  const Vec3 tip = *middle;
  const auto report = simplify_small(plane, 0.00049);
  ASSERT_TRUE(report);
  EXPECT_LT(report->after, report->before);
  EXPECT_LE(distance_to(plane, tip), 0.00049);
}

TEST(SimplifySmall, RejectsAnImpossibleBound) {
  TriangleMesh box = make_box(Vec3(0.1, 0.02, 0.03), 3);
  for (const double bound_m : {-1e-6, 0.1, 7.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    const auto report = simplify_small(box, bound_m);
    ASSERT_FALSE(report) << bound_m;
    EXPECT_NE(report.error().what.find("longest side, 0.1 m"), std::string::npos) << report.error().what;
  }
  const std::size_t before = box.triangles.size();
  ASSERT_TRUE(simplify_small(box, 0.0));
  EXPECT_EQ(box.triangles.size(), before);
}

}  // namespace
}  // namespace hapton
