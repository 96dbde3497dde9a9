#include "core/geometry/smooth_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/obj_mesh.h"

namespace hapton {
namespace {

TEST(SmoothSurface, EveryPassReportsOneLine) {
  SmoothSurfaceReport report;
  const auto surface = make_smooth_surface(make_box(Vec3(1, 1, 1)), {}, report);
  ASSERT_TRUE(surface) << surface.error().what;
  const auto lines = report.lines();
  ASSERT_EQ(lines.size(), 7U);
  for (const char* pass : {"repair:", "simplify:", "normals:", "validation:", "split:", "fans:", "final validation:"}) {
    EXPECT_TRUE(std::any_of(lines.begin(), lines.end(), [&](const std::string& line) { return line.rfind(pass, 0) == 0; })) << pass;
  }
  EXPECT_EQ(report.final_check.repaired(), 0U);
}

TEST(SmoothSurface, MovedVerticesGiveWhatABuildGives) {
  for (TriangleMesh mesh : {make_icosphere(0.05, 2), make_box(Vec3(1, 1, 1), 2)}) {
    SmoothSurfaceReport report;
    auto moved = make_smooth_surface(mesh, {.longest_edge = 0.05}, report);
    ASSERT_TRUE(moved);
    EXPECT_GT(report.split.edges, 0U);
    const Pose motion = Eigen::Translation3d(0.1, 0.2, 0.3) * Eigen::AngleAxisd(1.0, Vec3(1, 2, 2) / 3.0);
    for (Vec3& v : mesh.vertices) v = motion * v;
    moved->move_vertices(mesh.vertices);
    // The bounding box of a rotated mesh differs: longest_edge is set so that edges of the same length are split.
    MeshBounds bounds = compute_bounds(mesh);
    const auto rebuilt = make_smooth_surface(mesh, {.longest_edge = report.split.longest_edge / bounds.diagonal()}, report);
    ASSERT_TRUE(rebuilt);
    ASSERT_EQ(rebuilt->mesh.triangles.size(), moved->mesh.triangles.size());
    for (std::size_t t = 0; t < rebuilt->mesh.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        EXPECT_LT((moved->mesh.corner(t, k) - rebuilt->mesh.corner(t, k)).norm(), 1e-12);
        EXPECT_LT((moved->mesh.normal(t, k) - rebuilt->mesh.normal(t, k)).norm(), 1e-9);
      }
    }
  }
}

// So far from the origin that rounding moves the middle of the long edge, and its two halves face elsewhere: the final check gives their
// corners normals of their own, which come after the normals of edge middles.
TEST(SmoothSurface, NormalsThatTheFinalCheckReplacedFollowTheirFace) {
  const double far = 0x1p30 + 0x1p-22;
  const TriangleMesh mesh = {{{0.0, far, 0.0}, {1.0, far + 0x1p-22, 0.0}, {0.5, far + 0x1p-22, 0x1p-28}}, {{0, 1, 2}}};
  SmoothSurfaceReport report;
  auto surface = make_smooth_surface(mesh, {.longest_edge = 0.6}, report);
  ASSERT_TRUE(surface) << surface.error().what;
  ASSERT_EQ(surface->face_count, 2U);
  ASSERT_EQ(report.final_check.repaired(), 6U);
  surface->move_vertices(mesh.vertices);
  const ShadedMesh& moved = surface->mesh;
  for (std::size_t t = 0; t < surface->face_count; ++t) {
    const Vec3 face = (moved.corner(t, 1) - moved.corner(t, 0)).cross(moved.corner(t, 2) - moved.corner(t, 0)).normalized();
    for (int k = 0; k < 3; ++k) EXPECT_LT((moved.normal(t, k) - face).norm(), 1e-9) << t << ", corner " << k;
  }
}

TEST(SmoothSurface, RealMeshesWithDefectsPassEveryStep) {
  for (const char* name : {"car_front_3300.obj", "nist_assembly_insert.obj", "demosthenes_17k_open.obj", "wingnut.obj"}) {
    const TriangleMesh mesh = made::obj_mesh(name);
    ASSERT_GT(mesh.triangles.size(), 1000U) << name;
    SmoothSurfaceReport report;
    const auto surface = make_smooth_surface(mesh, {}, report);
    ASSERT_TRUE(surface) << name;
    EXPECT_EQ(report.final_check.repaired(), 0U) << name;
    for (const Vec3& v : surface->mesh.vertices) EXPECT_TRUE(v.allFinite());
    for (const Triangle& t : surface->mesh.triangles) EXPECT_LT(std::max({t[0], t[1], t[2]}), surface->mesh.vertices.size());
  }
}

TEST(SmoothSurface, TheCreaseAngleDecidesWhetherABoxHasRoundedEdges) {
  SmoothSurfaceReport report;
  const auto normal_at_corner = [&](double degrees) {
    const auto surface = make_smooth_surface(make_box(Vec3(1, 1, 1)), {.crease_angle_rad = degrees / 180.0 * std::numbers::pi}, report);
    EXPECT_TRUE(surface);
    for (std::size_t t = 0; t < surface->face_count; ++t) {
      for (int k = 0; k < 3; ++k) {
        if (surface->mesh.corner(t, k) == Vec3(0.5, 0.5, 0.5)) return surface->mesh.normal(t, k);
      }
    }
    return Vec3(Vec3::Zero());
  };
  EXPECT_NEAR(normal_at_corner(89.0).cwiseAbs().maxCoeff(), 1.0, 1e-12);
  EXPECT_EQ(report.normals.sharp_edges, 12U);
  EXPECT_NE(report.normals.describe().find("12 sharp edges (faces turn by more than 89 degrees)"), std::string::npos);
  EXPECT_NEAR((normal_at_corner(91.0) - Vec3(1, 1, 1).normalized()).norm(), 0.0, 1e-12);
  EXPECT_EQ(report.normals.sharp_edges, 0U);
}

TEST(SmoothSurface, RejectsInvalidMeshesAndSettings) {
  SmoothSurfaceReport report;
  EXPECT_FALSE(make_smooth_surface({{Vec3(1, 1, 1)}, {{0, 0, 0}}}, {}, report));
  EXPECT_FALSE(make_smooth_surface(make_box(Vec3(1, 1, 1)), {.crease_angle_rad = -1.0}, report));
  EXPECT_FALSE(make_smooth_surface(make_box(Vec3(1, 1, 1)), {.simplify_error_m = 2.0}, report));
  EXPECT_FALSE(make_smooth_surface(make_box(Vec3(1, 1, 1)), {.growth = 0.0}, report));
}

}  // namespace
}  // namespace hapton
