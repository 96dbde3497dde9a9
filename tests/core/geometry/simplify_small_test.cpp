#include "core/geometry/simplify_small.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/smooth_surface.h"

namespace hapton {
namespace {

TriangleMesh faces_of(const SmoothSurface& surface) {
  TriangleMesh mesh;
  mesh.vertices = surface.mesh.vertices;
  mesh.triangles.assign(surface.mesh.triangles.begin(), surface.mesh.triangles.begin() + static_cast<std::ptrdiff_t>(surface.face_count));
  return mesh;
}

TEST(SimplifySmall, SimplificationStaysWithinItsBound) {
  const TriangleMesh mesh = make_icosphere(0.05, 5);
  SmoothSurfaceReport report;
  const auto surface = make_smooth_surface(mesh, {.longest_edge = 0.0, .simplify_error = 0.003}, report);
  ASSERT_TRUE(surface);
  EXPECT_LT(report.simplify.after, report.simplify.before / 4);
  EXPECT_LE(report.simplify.error_m, 0.003 * 0.1 * 1.01);
  const TriangleMesh fewer = faces_of(*surface);
  EXPECT_TRUE(count_edges(fewer).closed());
  for (const Triangle& t : fewer.triangles) {
    const Vec3 middle = (fewer.vertices[t[0]] + fewer.vertices[t[1]] + fewer.vertices[t[2]]) / 3;
    EXPECT_NEAR(middle.norm(), 0.05, 2.0 * 0.003 * 0.1);
  }
}

}  // namespace
}  // namespace hapton
